//! Events as a scene file describes them.

use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{Quantity, Time};
use schemars::JsonSchema;
use serde::Deserialize;

/// Something that happens once, or every time its condition comes true.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// Name in the log; `event 1` and so on if absent
    pub name: Option<String>,
    /// Condition at which the event happens
    pub when: WhenSpec,
    /// Actions, in order
    pub then: Vec<ThenSpec>,
    /// Whether the event happens again each time its condition becomes true again
    #[serde(default)]
    pub repeat: bool,
}

/// A condition, evaluated on the time grid.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum WhenSpec {
    /// At a time, and periodically after it if `every` is given
    At {
        /// First time of the event
        t: Time,
        /// Period after which the event happens again; once if absent
        every: Option<Time>,
    },
    /// A recorded column reaches the value from below
    Above {
        /// Recorded column, with its unit in its name
        column: String,
        /// Value that the column reaches, with its unit
        value: Quantity,
    },
    /// A recorded column reaches the value from above
    Below {
        /// Recorded column, with its unit in its name
        column: String,
        /// Value that the column reaches, with its unit
        value: Quantity,
    },
    /// A cable that was taut goes slack
    Slack {
        /// Name of the cable
        cable: String,
    },
    /// A cable that was slack becomes taut
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
    /// Replaces the signal of this name by `to`, whose time counts from the event
    Switch {
        /// Name of the signal, as listed by `check`
        signal: String,
        /// Signal that replaces it
        to: SignalSpec,
        /// Duration of the transition from the old value
        over: Option<Time>,
    },
    /// Ends the run here, as planned
    Stop {},
    /// Saves a state from which the run can be restarted
    Save {},
}
