//! The message about a run that its clients receive repeatedly: the newest values, not one message for each change.

use crate::solve::IterationReport;
use serde::Serialize;
use serde_json::{Value, json};

/// A signal that a page may set.
#[derive(Clone, Debug, Serialize)]
pub struct SignalState {
    pub name: String,
    /// Name and unit for display
    pub words: String,
    pub unit: &'static str,
    /// Requested value \[SI\]; the next step reaches it
    pub value: f64,
    /// Least and largest value, if the scene declares them
    pub range: Option<(f64, f64)>,
}

/// The values of a sequence that can be requested: those whose number is a multiple of the stride, and the last one.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Extent {
    pub stride: usize,
    pub count: usize,
}

/// The newest values of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct News {
    /// Distinguishes runs that are shown at the same address
    pub run: String,
    /// Time of the last accepted state, and of the end \[s\]
    pub t: f64,
    pub end: f64,
    pub paused: bool,
    /// The run is at a point of the time grid and waits
    pub waiting: bool,
    /// Status and its reason
    pub ended: Option<(String, Option<String>)>,
    pub states: Extent,
    pub rows: Extent,
    pub signals: Vec<SignalState>,
    /// Iterations that the client has not seen, with their numbers in the run
    pub iterations: Vec<(u64, IterationReport)>,
}

impl News {
    /// Returns the message as JSON.
    pub fn json(&self) -> Value {
        let iteration = |(k, i): &(u64, IterationReport)| json!([k, i.t, i.dt, i.number, i.error]);
        json!({
            "run": self.run,
            "t": self.t,
            "end": self.end,
            "paused": self.paused,
            "waiting": self.waiting,
            "ended": self.ended.as_ref().map(|(status, detail)| json!({ "status": status, "detail": detail })),
            "states": self.states,
            "rows": self.rows,
            "signals": self.signals,
            "iterations": self.iterations.iter().map(iteration).collect::<Vec<_>>(),
        })
    }
}

/// How far a client has followed the run.
#[derive(Default)]
pub(super) struct Seen {
    pub version: u64,
    /// The first iteration that it has not seen
    pub iteration: u64,
}
