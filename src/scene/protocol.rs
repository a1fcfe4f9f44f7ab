//! Signals prescribed over time, by name, and their extremes.

use crate::math::signal::Signal;
use crate::solve::TimeSpan;

/// A prescribed function of time; the unit is at the end of the name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSignal {
    pub name: String,
    pub signal: Signal,
}

/// Samples per step, for extremes between the points of the time grid.
const SAMPLES: usize = 4;

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
