//! Signals prescribed over time, by name, and the limits within which a cable can follow them.

use super::builder::Builder;
use super::error::SceneError;
use super::spec::SceneSpec;
use crate::math::signal::Signal;
use crate::solve::{Integrator, TimeSpan};

/// A prescribed function of time; the unit is at the end of the name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSignal {
    pub name: String,
    pub signal: Signal,
}

/// Samples per step, for extremes between the points of the time grid.
const SAMPLES: usize = 4;
/// Rounding of a sum of signals, as a share of the largest value.
const ROUNDING: f64 = 1e-12;

/// Smallest and largest value over the stages, each with its time: ((t, s), (t, s)).
pub fn extremes(signal: &Signal, spans: &[TimeSpan]) -> ((f64, f64), (f64, f64)) {
    let first = (spans.first().map_or(0.0, |s| s.start), f64::NAN);
    let mut found = (first, first);
    for span in spans {
        let steps = ((span.end - span.start) / span.dt).ceil().min(1e5) as usize * SAMPLES;
        for k in 0..=steps {
            let t = span.start + (span.end - span.start) * k as f64 / steps as f64;
            let s = signal.at(t);
            if found.0.1.is_nan() || s < found.0.1 {
                found.0 = (t, s);
            }
            if found.1.1.is_nan() || s > found.1.1 {
                found.1 = (t, s);
            }
        }
    }
    found
}

/// A formula must have a value wherever it is looked at.
pub(super) fn check_formulas(builder: &Builder, spans: &[TimeSpan]) -> Result<(), SceneError> {
    for NamedSignal { name, signal } in builder.signals.iter().filter(|s| !s.signal.has_inputs()) {
        let times = spans.iter().flat_map(|s| (0..=s.steps().min(100_000)).map(|k| s.point(k)));
        if let Some((t, value)) = times.map(|t| (t, signal.at(t))).find(|(_, value)| !value.is_finite()) {
            let fact = format!("it is {value} at t = {t} s");
            let remedy = "keep the formula defined there, for example by max(x, 0)";
            return Err(builder.content(&format!("signal {name}"), fact, remedy));
        }
    }
    Ok(())
}

/// The points of a continuation are its own, so that nothing can be decided at them.
pub(super) fn check_continued(builder: &Builder, spec: &SceneSpec, spans: &[TimeSpan]) -> Result<(), SceneError> {
    let decided = !spec.events.is_empty() || builder.signals.iter().any(|s| s.signal.has_inputs());
    let arc = spans.iter().position(|s| matches!(s.integrator, Integrator::ArcLength { .. }));
    let Some(k) = arc.filter(|_| decided) else { return Ok(()) };
    let fact = "a continuation together with events, or with signals that are decided during the run";
    Err(builder.content(&format!("stage {}", k + 1), fact, "take integrator = \"static\" without `continuation`"))
}

/// A cable cannot push: T(t) ≥ 0. A signal that is decided during the run is cut at 0.
pub(super) fn check_tension(
    builder: &Builder,
    place: &str,
    tension: &Signal,
    spans: &[TimeSpan],
) -> Result<(), SceneError> {
    if tension.has_inputs() {
        return Ok(());
    }
    let ((t, least), (_, most)) = extremes(tension, spans);
    if least >= -ROUNDING * most.abs() {
        return Ok(());
    }
    let fact = format!("the tension is {least:.4} N at t = {t:.4} s, and a cable cannot push");
    Err(builder.content(place, fact, "take a signal that is never negative, such as raised_cosine"))
}

/// Where a cable is slack.
pub(super) fn note_let_out(builder: &mut Builder, name: &str, shortening: &Signal, spans: &[TimeSpan]) {
    if shortening.has_inputs() {
        return;
    }
    let ((t, least), (_, most)) = extremes(shortening, spans);
    if least < -ROUNDING * most.abs() {
        let mm = -least * 1e3;
        builder.notes.push(format!("{name} is let out by up to {mm:.4} mm (t = {t:.4} s): it may be slack there"));
    }
}
