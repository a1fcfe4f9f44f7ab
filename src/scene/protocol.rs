//! What is prescribed over time, by name, and what of it a cable can follow.

use super::build::part;
use super::builder::Builder;
use super::error::SceneError;
use super::signal::SignalSpec;
use super::spec::SceneSpec;
use crate::math::signal::Signal;
use crate::math::units::Dimension;
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

impl Builder<'_> {
    /// The signal of this name, with the unit at its end; it is recorded and can be switched by it.
    pub(super) fn signal(
        &mut self,
        place: &str,
        name: String,
        spec: &SignalSpec,
        d: Dimension,
    ) -> Result<Signal, SceneError> {
        let built = self.signal_builder.signal(&name, spec, d, &self.base);
        let signal = built.map_err(|(event, e)| part(self.file, event.unwrap_or_else(|| place.into()), e))?;
        let signal = self.continued(signal);
        // The same motion of one region by two entries is one signal.
        if !self.signals.iter().any(|s| s.name == name) {
            self.signals.push(NamedSignal { name, signal: signal.clone() });
        }
        Ok(signal)
    }

    /// A formula must have a value wherever it is looked at.
    pub(super) fn check_formulas(&self, spans: &[TimeSpan]) -> Result<(), SceneError> {
        for NamedSignal { name, signal } in self.signals.iter().filter(|s| !s.signal.has_inputs()) {
            let times = spans.iter().flat_map(|s| (0..=s.steps().min(100_000)).map(|k| s.point(k)));
            if let Some((t, value)) = times.map(|t| (t, signal.at(t))).find(|(_, value)| !value.is_finite()) {
                let fact = format!("it is {value} at t = {t} s");
                let remedy = "keep the formula defined there, for example by max(x, 0)";
                return Err(self.content(&format!("signal {name}"), fact, remedy));
            }
        }
        Ok(())
    }

    /// Loads of an arc-length stage go on beyond the first and the last time of the protocol, as they do in it on average.
    pub(super) fn continue_signals(&mut self, spans: &[TimeSpan]) {
        let end = |s: &TimeSpan| (s.start, s.end, matches!(s.integrator, Integrator::ArcLength { .. }));
        let ends = spans.first().map(end).zip(spans.last().map(end));
        self.continued = ends.filter(|(first, last)| first.2 || last.2).map(|(first, last)| [first, last]);
    }

    /// The points of a continuation are its own, so that nothing can be decided at them.
    pub(super) fn check_continued(&self, spec: &SceneSpec, spans: &[TimeSpan]) -> Result<(), SceneError> {
        let decided = !spec.events.is_empty() || self.signals.iter().any(|s| s.signal.has_inputs());
        let arc = spans.iter().position(|s| matches!(s.integrator, Integrator::ArcLength { .. }));
        let Some(k) = arc.filter(|_| decided) else { return Ok(()) };
        let fact = "a continuation beside events, or signals that are decided on the way";
        Err(self.content(&format!("stage {}", k + 1), fact, "take integrator = \"static\" without `continuation`"))
    }

    pub(super) fn continued(&self, signal: Signal) -> Signal {
        let Some([first, last]) = self.continued.filter(|_| !signal.has_inputs()) else { return signal };
        let slope = |(start, end, arc): (f64, f64, bool)| {
            if arc { (signal.at(end) - signal.at(start)) / (end - start) } else { 0.0 }
        };
        let (before, after) = (slope(first), slope(last));
        if before == 0.0 && after == 0.0 {
            return signal;
        }
        Signal::Continued { signal: Box::new(signal), from: first.0, to: last.1, before, after }
    }

    /// A cable cannot push: T(t) ≥ 0. What is decided on the way is cut at 0.
    pub(super) fn check_tension(&self, place: &str, tension: &Signal, spans: &[TimeSpan]) -> Result<(), SceneError> {
        if tension.has_inputs() {
            return Ok(());
        }
        let ((t, least), (_, most)) = extremes(tension, spans);
        if least >= -ROUNDING * most.abs() {
            return Ok(());
        }
        let fact = format!("the tension is {least:.4} N at t = {t:.4} s, and a cable cannot push");
        Err(self.content(place, fact, "take a signal that is never negative, such as raised_cosine"))
    }

    /// Where a cable is slack.
    pub(super) fn note_let_out(&mut self, name: &str, shortening: &Signal, spans: &[TimeSpan]) {
        if shortening.has_inputs() {
            return;
        }
        let ((t, least), (_, most)) = extremes(shortening, spans);
        if least < -ROUNDING * most.abs() {
            let mm = -least * 1e3;
            self.notes.push(format!("{name} is let out by up to {mm:.4} mm (t = {t:.4} s): it may be slack there"));
        }
    }
}
