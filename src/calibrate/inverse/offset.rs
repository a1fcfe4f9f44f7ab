//! Offsets of the coordinates of one curve, as unknowns.

use crate::material::Parameter;
use crate::math::units::Dimension;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Coordinate of a curve whose offset is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OffsetAxis {
    /// x at which the specimen begins to carry load
    Slack,
    /// y that is recorded without load
    Zero,
}

impl OffsetAxis {
    /// The offset as an unknown, in the unit of its column.
    pub fn parameter(self) -> Parameter {
        match self {
            Self::Slack => {
                Parameter::new("slack", "x₀", Dimension::NONE, Parameter::ANY, "x at which the body begins to carry")
            }
            Self::Zero => Parameter::new("zero", "y₀", Dimension::NONE, Parameter::ANY, "y without load"),
        }
    }
}
