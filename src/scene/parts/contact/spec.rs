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
    /// Prefix of the columns; `contact` if absent
    #[serde(default = "contact")]
    pub name: String,
    /// Facets of the body, or the name of a rigid body
    pub region: String,
    /// Shape against which the region presses
    pub obstacle: ShapeSpec,
    /// Motion of the obstacle; it does not move if absent
    pub motion: Option<MotionSpec>,
    /// Relation between distance and contact pressure
    pub response: ResponseSpec,
    /// Coulomb's coefficient of friction, 0 without friction
    pub friction: f64,
    /// Length over which the response acts; a hundredth of the mean size of the cells at the region if absent
    pub distance: Option<Length>,
    /// Pressure that scales the response; Young's modulus of the law at the region if absent
    pub modulus: Option<Modulus>,
    /// Largest elastic slip of a sticking point in a dynamic step, divided by the length of the step; if absent, a thousandth of the size of the body per
    /// second, and at most `slip` per step
    pub stick_velocity: Option<Speed>,
    /// Largest elastic slip of a sticking point in statics; a thousandth of the mean size of the cells at the region if absent
    pub slip: Option<Length>,
}

fn contact() -> String {
    "contact".into()
}

/// A translation, a rotation, or both: first the rotation, then the translation.
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
    /// A logarithmic barrier, which no point can cross
    Barrier,
    /// A quadratic penalty of the penetration
    Penalty,
    /// Lagrange multipliers, without penetration
    Multiplier,
}

impl ResponseSpec {
    /// Name as in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Barrier => "barrier",
            Self::Penalty => "penalty",
            Self::Multiplier => "multiplier",
        }
    }
}
