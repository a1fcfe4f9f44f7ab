//! Rotations by a signal, about an axis that stays where it is.
//!
//! A point X goes to P + R(θ)(X − P), with R(θ) v = v + (cos θ − 1)(v − k kᵀv) + sin θ k × v (Rodrigues).

use super::build::builder::Builder;
use super::error::SceneError;
use super::notes::jump::{Impact, note_jump};
use super::signal::SignalSpec;
use super::signal::protocol::NamedSignal;
use super::text::quantity::Length;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::solve::Integrator;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

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

/// 180° but for rounding \[rad\]
const HALF_TURN: f64 = PI * (1.0 - 1e-9);

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
        check_steps(builder, place, &angle)?;
        Ok(Turning { axis, about: self.about.map(|x| x.0).into(), angle })
    }
}

/// Refuses a half turn or more within one step. The angle of a controller is known after the run only, see [`half_turns`].
fn check_steps(builder: &Builder, place: &str, angle: &Signal) -> Result<(), SceneError> {
    if angle.has_inputs() {
        return Ok(());
    }
    let spans = builder.spans.iter().filter(|span| !matches!(span.integrator, Integrator::ArcLength { .. }));
    for span in spans {
        let change = |k: usize| (angle.at(span.point(k + 1)) - angle.at(span.point(k))).abs();
        if let Some(k) = (0..span.steps()).find(|&k| change(k) >= HALF_TURN) {
            let (by, dt) = (change(k), span.dt * 0.25 * PI / change(k));
            let fact = format!(
                "the angle changes by {:.0}° within the step at t = {:.6} s, and from 180° on a step cannot tell in which direction it turned",
                by.to_degrees(),
                span.point(k)
            );
            return Err(builder.content(place, fact, format!("let it turn more slowly, or take a dt of {dt:.2e} s")));
        }
    }
    Ok(())
}

/// A note for each turn that a controller changed by 180° or more from one row to the next: [rows × signals] `values` of `signals`.
pub fn half_turns(signals: &[NamedSignal], values: &[Vec<f64>]) -> Vec<String> {
    let turns = signals.iter().enumerate().filter(|(_, s)| s.signal.has_inputs() && s.name.ends_with("_rad"));
    let jumps = turns.filter_map(|(k, signal)| {
        let row = values.windows(2).position(|two| (two[1][k] - two[0][k]).abs() >= HALF_TURN)?;
        Some(format!(
            "{} changes by 180° or more after row {}, and a step cannot tell in which direction it turned: let the controller change it in several steps",
            signal.name,
            row + 1
        ))
    });
    jumps.collect()
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
