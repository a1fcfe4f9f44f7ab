//! What events, inputs and controllers remember between the points of the time grid; a part of every saved state.

use super::input::{Program, Source};
use super::{Controls, Fired};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Memory {
    /// Per input: what it follows
    pub programs: Vec<Program>,
    /// Per input: the value set from outside
    pub outside: Vec<f64>,
    /// Per event
    pub events: Vec<Past>,
    /// What happened so far
    pub log: Vec<Fired>,
    /// What the controller asked to keep
    pub controller: serde_json::Value,
}

/// Past of an event.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Past {
    /// Was the condition true at the last point of the grid?
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
