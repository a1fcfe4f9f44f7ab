//! Rotations by a signal, about a fixed axis.
//!
//! A point X moves to P + R(θ)(X − P), with R(θ) v = v + (cos θ − 1)(v − k kᵀv) + sin θ k × v (Rodrigues).

use super::build::builder::Builder;
use super::error::SceneError;
use super::notes::jump::{Impact, note_jump};
use super::signal::SignalSpec;
use super::signal::protocol::NamedSignal;
use super::text::quantity::Length;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::solve::{Integrator, TimeSpan};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A rotation by the right-hand rule, about a fixed axis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationSpec {
    /// Direction of the axis; its length does not matter
    pub axis: [f64; 3],
    /// A point of the axis
    pub about: [Length; 3],
    /// Angle of the rotation \[rad\]
    pub angle: SignalSpec,
}

/// 180° less a margin for rounding \[rad\].
const HALF_TURN: f64 = PI * (1.0 - 1e-9);

/// Largest rotation of a contacting part in one step, 20° plus a margin for rounding \[rad\]. Its nodes move along chords, so that between the ends of the
/// step it is smaller by 1 − cos(Δθ/2), 1.5 %.
const MOST_IN_CONTACT: f64 = PI / 9.0 * (1.0 + 1e-9);

/// A rotation whose angle is a function of time.
pub(super) struct Rotation {
    /// Unit vector along the axis
    axis: Vec3,
    /// A point of the axis \[m\]
    about: Vec3,
    /// Angle over time \[rad\]
    pub(super) angle: Signal,
}

impl RotationSpec {
    /// The rotation; its angle is recorded as `column`.
    pub(super) fn build(&self, builder: &mut Builder, place: &str, column: String) -> Result<Rotation, SceneError> {
        let axis = unit_vector(builder, place, "axis", self.axis)?;
        let angle = builder.signal(place, column.clone(), &self.angle, Dimension::ANGLE)?;
        note_jump(builder, &column, &angle, Impact::FromPlace);
        check_steps(builder, place, &angle)?;
        Ok(Rotation { axis, about: self.about.map(|x| x.0).into(), angle })
    }
}

/// Refuses a rotation by half a turn or more within one step. The angle set by a controller is known only after the run, see [`half_turns`].
fn check_steps(builder: &Builder, place: &str, angle: &Signal) -> Result<(), SceneError> {
    let Some(StepTurn { span, at, by }) = turns(builder, angle).find(|step| step.by >= HALF_TURN) else {
        return Ok(());
    };
    let fact = format!(
        "the angle changes by {:.0}° within the step at t = {at:.6} s, and from 180° on a step cannot tell in which direction it turned",
        by.to_degrees(),
    );
    Err(builder.content(place, fact, slower(span.dt * 0.25 * PI / by)))
}

/// Refuses steps in which an obstacle, or facets in contact, rotate too far. The angle set by a controller is not known here.
pub(super) fn check_in_contact(builder: &Builder, place: &str, angle: &Signal) -> Result<(), SceneError> {
    let limit = format!(
        "what is in contact turns by at most {:.0}° in a step: within it, it goes straight and might pass the other side",
        MOST_IN_CONTACT.to_degrees()
    );
    let first = builder.spans.first().filter(|first| first.integrator.is_static() && !angle.has_inputs());
    let start = first.map_or(0.0, |first| angle.at(first.point(0)).abs());
    if start > MOST_IN_CONTACT {
        let fact =
            format!("a static stage turns it by {:.0}° from its given place at once; {limit}", start.to_degrees());
        return Err(builder.content(place, fact, "let the angle begin at 0"));
    }
    let Some(StepTurn { span, at, by }) = turns(builder, angle).find(|step| step.by > MOST_IN_CONTACT) else {
        return Ok(());
    };
    let fact = format!("the angle changes by {:.0}° within the step at t = {at:.6} s; {limit}", by.to_degrees());
    Err(builder.content(place, fact, slower(span.dt * 0.75 * MOST_IN_CONTACT / by)))
}

/// Rotation within one step.
struct StepTurn<'a> {
    span: &'a TimeSpan,
    /// Start of the step \[s\]
    at: f64,
    /// Angle of the rotation \[rad\]
    by: f64,
}

/// The rotations of an angle in each step, in order; empty for an angle that is decided during the run.
fn turns<'a>(builder: &'a Builder, angle: &'a Signal) -> impl Iterator<Item = StepTurn<'a>> {
    let is_timed =
        move |span: &&TimeSpan| !angle.has_inputs() && !matches!(span.integrator, Integrator::ArcLength { .. });
    builder.spans.iter().filter(is_timed).flat_map(move |span| {
        let change = move |k: usize| (angle.at(span.point(k + 1)) - angle.at(span.point(k))).abs();
        (0..span.steps()).map(move |k| StepTurn { span, at: span.point(k), by: change(k) })
    })
}

/// The remedy, with the length of a step \[s\].
fn slower(dt: f64) -> String {
    format!("let it turn more slowly, or take a dt of {dt:.2e} s")
}

/// A note for each rotation that a controller changed by 180° or more from one row to the next; `values`: \[rows × signals\] of `signals`.
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

impl Rotation {
    /// Component `i` of the displacement \[m\] of the point at the position `at` \[m\] at rest.
    pub(super) fn displacement(&self, at: Vec3, i: usize) -> Signal {
        let v = at - self.about;
        let (cosine, sine) = ((v - self.axis * self.axis.dot(&v))[i], self.axis.cross(&v)[i]);
        match (cosine, sine) {
            (0.0, 0.0) => Signal::Constant(0.0),
            _ => Signal::Turn { angle: Box::new(self.angle.clone()), cosine, sine },
        }
    }
}

/// The unit vector of the direction `key` of a motion.
pub(super) fn unit_vector(builder: &Builder, place: &str, key: &str, v: [f64; 3]) -> Result<Vec3, SceneError> {
    let v = Vec3::from(v);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v.normalize());
    }
    Err(builder.content(place, format!("the {key} of the motion has no length"), "write for example [0, 0, 1]"))
}
