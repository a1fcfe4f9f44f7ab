//! Events as a scene file describes them.

use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{Quantity, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Something that happens once, or every time its condition comes true.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// For the log; `event 1` and so on if absent
    pub name: Option<String>,
    /// Condition at which the event happens
    pub when: WhenSpec,
    /// Actions, in their order
    pub then: Vec<ThenSpec>,
    /// Again, whenever the condition comes true after it was not
    #[serde(default)]
    pub repeat: bool,
}

/// A condition, looked at on the time grid.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum WhenSpec {
    /// At a time, and every so often after it
    At {
        /// First time of the event
        t: Time,
        /// Period after which the event happens again; once if absent
        every: Option<Time>,
    },
    /// A recorded column comes to the value from below
    Above {
        /// Recorded column, with its unit in its name
        column: String,
        /// Value that it comes to, with its unit
        value: Quantity,
    },
    /// A recorded column comes to the value from above
    Below {
        /// Recorded column, with its unit in its name
        column: String,
        /// Value that it comes to, with its unit
        value: Quantity,
    },
    /// A cable that was taut carries nothing
    Slack {
        /// Name of the cable
        cable: String,
    },
    /// A cable that was slack carries a force again
    Taut {
        /// Name of the cable
        cable: String,
    },
}

/// An action.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum ThenSpec {
    /// The signal of this name is `to` from then on, its time counted from the event
    Switch {
        /// Name of the signal, as `check` lists it
        signal: String,
        /// Signal that takes its place
        to: SignalSpec,
        /// Goes over from the old value within this time
        over: Option<Time>,
    },
    /// The run ends here, as planned
    Stop {},
    /// Saves a state to restart from
    Save {},
}
