//! `[[contact]]` of a scene.

use crate::scene::build::shape::ShapeSpec;
use crate::scene::rotation::RotationSpec;
use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{Length, Modulus, Speed};
use schemars::JsonSchema;
use serde::Deserialize;

/// A part of the surface, or a rigid body, against an obstacle.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// Prefix of its columns; `contact` if absent
    #[serde(default = "contact")]
    pub name: String,
    /// Facets of the body, or the name of a rigid body
    pub region: String,
    /// Shape against which the region presses
    pub obstacle: ShapeSpec,
    /// How the obstacle moves; it stays where it is if absent
    pub motion: Option<MotionSpec>,
    /// How the contact pressure follows from the distance
    pub response: ResponseSpec,
    /// Coulomb's coefficient, 0 without friction
    pub friction: f64,
    /// Length in which the response acts; a hundredth of the mean size of the cells at the region if absent
    pub distance: Option<Length>,
    /// Pressure that the response is scaled with; Young's modulus of the law at the region if absent
    pub modulus: Option<Modulus>,
    /// Largest elastic slip of a point that sticks, over the length of a dynamic step; a thousandth of the size of the body per second if absent, and then at most `slip`
    pub stick_velocity: Option<Speed>,
    /// Largest elastic slip of a point that sticks, in statics; a thousandth of the mean size of the cells at the region if absent
    pub slip: Option<Length>,
}

fn contact() -> String {
    "contact".into()
}

/// A translation, a rotation, or both: turned first, then moved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// Direction of the translation
    pub direction: Option<[f64; 3]>,
    /// Displacement \[m\] along the direction
    pub displacement: Option<SignalSpec>,
    /// Rotation about a fixed axis
    pub turn: Option<RotationSpec>,
}

/// Relation between distance and contact pressure
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ResponseSpec {
    /// A logarithmic barrier, which no point crosses
    Barrier,
    /// A quadratic penalty of the penetration
    Penalty,
    /// Lagrange multipliers, without penetration
    Multiplier,
}

impl ResponseSpec {
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Barrier => "barrier",
            Self::Penalty => "penalty",
            Self::Multiplier => "multiplier",
        }
    }
}
