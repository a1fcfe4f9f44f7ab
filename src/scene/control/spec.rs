//! Events as a scene file describes them.

use crate::scene::kind::by_kind;
use crate::scene::quantity::{Quantity, Time};
use crate::scene::signal::SignalSpec;
use serde::Deserialize;

by_kind!(WhenSpec, ThenSpec);

/// Something that happens once, or every time its condition comes true.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// For the log; `event 1` and so on if absent
    pub name: Option<String>,
    pub when: WhenSpec,
    pub then: Vec<ThenSpec>,
    /// Again, whenever the condition comes true after it was not
    #[serde(default)]
    pub repeat: bool,
}

/// A condition, looked at on the time grid.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum WhenSpec {
    /// At a time, and every so often after it
    At {
        t: Time,
        every: Option<Time>,
    },
    /// A recorded column comes to the value from below
    Above {
        column: String,
        value: Quantity,
    },
    /// A recorded column comes to the value from above
    Below {
        column: String,
        value: Quantity,
    },
    /// A cable that was taut carries nothing
    Slack {
        cable: String,
    },
    Taut {
        cable: String,
    },
}

/// An action.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum ThenSpec {
    /// The signal of this name is `to` from then on, its time counted from the event
    Switch {
        signal: String,
        to: SignalSpec,
        /// Goes over from the old value within this time
        over: Option<Time>,
    },
    /// The run ends here, as planned
    Stop {},
    /// Saves a state to restart from
    Save {},
}
