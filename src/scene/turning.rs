//! Rotations by a signal, about an axis that stays where it is.
//!
//! A point X goes to P + R(θ)(X − P), with R(θ) v = v + (cos θ − 1)(v − k kᵀv) + sin θ k × v (Rodrigues).

use super::builder::Builder;
use super::error::SceneError;
use super::jump::{Impact, note_jump};
use super::quantity::Length;
use super::signal::SignalSpec;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use schemars::JsonSchema;
use serde::Deserialize;

/// A rotation by the right-hand rule, about an axis that stays where it is.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurningSpec {
    /// Direction of the axis; its length does not count
    pub axis: [f64; 3],
    /// A point of the axis
    pub about: [Length; 3],
    /// Angle of the rotation \[rad\]
    pub angle: SignalSpec,
}

/// A rotation whose angle is a function of time.
pub(super) struct Turning {
    /// Unit vector along the axis
    axis: Vec3,
    /// \[m\]
    about: Vec3,
    /// \[rad\]
    angle: Signal,
}

impl TurningSpec {
    /// The rotation; its angle is recorded as `column`.
    pub(super) fn build(&self, builder: &mut Builder, place: &str, column: String) -> Result<Turning, SceneError> {
        let axis = unit_vector(builder, place, "axis", self.axis)?;
        let angle = builder.signal(place, column.clone(), &self.angle, Dimension::ANGLE)?;
        note_jump(builder, &column, &angle, Impact::FromPlace);
        Ok(Turning { axis, about: self.about.map(|x| x.0).into(), angle })
    }
}

impl Turning {
    /// Component `i` of the displacement \[m\] of the point that is at `at` \[m\] at rest.
    pub(super) fn displacement(&self, at: Vec3, i: usize) -> Signal {
        let v = at - self.about;
        let (cosine, sine) = ((v - self.axis * self.axis.dot(&v))[i], self.axis.cross(&v)[i]);
        match (cosine, sine) {
            (0.0, 0.0) => Signal::Constant(0.0),
            _ => Signal::Turn { angle: Box::new(self.angle.clone()), cosine, sine },
        }
    }
}

/// The direction `key` of a motion.
pub(super) fn unit_vector(builder: &Builder, place: &str, key: &str, v: [f64; 3]) -> Result<Vec3, SceneError> {
    let v = Vec3::from(v);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v.normalize());
    }
    Err(builder.content(place, format!("the {key} of the motion has no length"), "write for example [0, 0, 1]"))
}
