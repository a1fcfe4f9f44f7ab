//! Memory of events, inputs and controllers between the points of the time grid; a part of every saved state.

use super::input::{Program, Source};
use super::{Controls, Fired};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Memory {
    /// Per input: the signal that it follows
    pub programs: Vec<Program>,
    /// Per input: the value set from outside
    pub outside: Vec<f64>,
    /// Per event
    pub events: Vec<Past>,
    /// Events so far
    pub log: Vec<Fired>,
    /// Memory of the controller
    pub controller: serde_json::Value,
}

/// Past of an event.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Past {
    /// Whether the condition was true at the last point of the grid
    pub was: bool,
    pub count: usize,
    /// Time of the last one \[s\]
    pub last: Option<f64>,
}

impl Controls {
    /// Before the first step.
    pub fn memory(&self) -> Memory {
        let initial = |source: &Source| if let Source::Controlled { initial } = source { *initial } else { 0.0 };
        Memory {
            programs: vec![Program::default(); self.inputs.len()],
            outside: self.inputs.iter().map(|i| initial(&i.source)).collect(),
            events: vec![Past::default(); self.events.len()],
            ..Memory::default()
        }
    }
}
