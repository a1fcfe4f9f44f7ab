//! Memory of events, inputs and controllers between the points of the time grid; a part of every saved state.

use serde::{Deserialize, Serialize};

/// Memory of a run at a point of the grid.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct ControlMemory {
    /// The signal that each input follows
    pub programs: Vec<Program>,
    /// The value of each input that was set from outside
    pub outside: Vec<f64>,
    /// The past of each event
    pub events: Vec<Past>,
    /// Events so far
    pub log: Vec<Fired>,
    /// Whether an event or the controller has ended the run here
    pub stopped: bool,
    /// Memory of the controller
    pub controller: serde_json::Value,
    /// Changes of the values set from outside: time of the grid point \[s\], and the values that were set there
    pub set: Vec<(f64, Vec<f64>)>,
    /// Controllers that have set these values, if they have an identity
    pub controllers: Vec<ControllerRecord>,
}

/// A controller, with the time from which it sets the signals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerRecord {
    /// Point of the time grid \[s\]
    pub from_t_s: f64,
    /// The controller's [`Controller::identity`](super::Controller::identity)
    pub identity: String,
}

/// Past of an event.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Past {
    /// Whether the condition was true at the last grid point
    pub was: bool,
    pub count: usize,
    /// Time at which the event last fired \[s\]
    pub last: Option<f64>,
}

/// The signal that an input follows.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Program {
    /// Index among the signals that events switch to; `None` for the input's own signal
    pub other: Option<usize>,
    /// Time of the switch \[s\]
    pub since: f64,
    /// Value at the switch
    pub from: f64,
}

/// An event that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fired {
    pub event: String,
    /// Time of the grid point \[s\]
    pub t_s: f64,
    /// Value of the column there, in its unit
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Actions, such as `switch cable_shortening_m`, `stop` or `save`
    pub did: Vec<String>,
}
