//! Events on the time grid: their conditions and actions.

use super::memory::{ControlMemory, Fired};
use crate::scene::signal::instant::rounding;

/// An event of a scene.
#[derive(Clone, Debug)]
pub struct Event {
    pub name: String,
    pub when: When,
    pub then: Vec<Then>,
    pub repeat: bool,
}

/// A condition on the recorded columns, by their index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    At { t: f64, every: Option<f64> },
    Above { column: usize, value: f64 },
    Below { column: usize, value: f64 },
}

/// An action of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum Then {
    /// Input, index among its other signals, name of the signal
    Switch {
        input: usize,
        other: usize,
        signal: String,
    },
    Stop,
    Save,
}

/// Evaluates the conditions at the first point: a condition that is true there does not become true later.
pub(super) fn look(events: &[Event], memory: &mut ControlMemory, row: &[f64]) {
    for (event, past) in events.iter().zip(&mut memory.events) {
        past.was = event.when.crossed(row);
    }
}

/// Fires and logs the events of this point of the grid and puts their switches into effect; returns their other actions. `step` is the length of the step to
/// this point \[s\].
pub(super) fn fire(events: &[Event], memory: &mut ControlMemory, row: &[f64], now: &[f64], step: f64) -> Vec<Then> {
    let (t, mut rest) = (row[0], Vec::new());
    for (e, event) in events.iter().enumerate() {
        let past = &mut memory.events[e];
        let is = event.when.crossed(row);
        let due = match event.when {
            When::At { t: first, every } => {
                let behind = |every: f64, last: f64| {
                    first + every * (((last + rounding(t, step) - first) / every).floor() + 1.0)
                };
                let next = every.zip(past.last).map_or(first, |(every, last)| behind(every, last));
                (past.count == 0 || every.is_some()) && t >= next - rounding(t, step)
            }
            _ => is && !past.was && (event.repeat || past.count == 0),
        };
        past.was = is;
        if !due {
            continue;
        }
        (past.count, past.last) = (past.count + 1, Some(t));
        for then in &event.then {
            match then {
                Then::Switch { input, other, .. } => {
                    let program = &mut memory.programs[*input];
                    (program.other, program.since, program.from) = (Some(*other), t, now[*input]);
                }
                other => rest.push(other.clone()),
            }
        }
        let did = event.then.iter().map(Then::words).collect();
        memory.log.push(Fired { event: event.name.clone(), t_s: t, value: event.when.value(row), did });
    }
    rest
}

impl When {
    fn crossed(&self, row: &[f64]) -> bool {
        match *self {
            Self::At { .. } => false,
            Self::Above { column, value } => row[column] >= value,
            Self::Below { column, value } => row[column] <= value,
        }
    }

    fn value(&self, row: &[f64]) -> Option<f64> {
        match *self {
            Self::At { .. } => None,
            Self::Above { column, .. } | Self::Below { column, .. } => Some(row[column]),
        }
    }
}

impl Then {
    fn words(&self) -> String {
        match self {
            Self::Switch { signal, .. } => format!("switch {signal}"),
            Self::Stop => "stop".into(),
            Self::Save => "save".into(),
        }
    }
}
