//! Signals prescribed over time, by name, and their extremes.

use crate::math::signal::Signal;
use crate::solve::{Integrator, TimeSpan};

/// A prescribed function of time; the unit is at the end of the name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSignal {
    pub name: String,
    pub signal: Signal,
}

/// Number of samples per step, to find extremes between the points of the time grid.
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

/// Share of its range by which a signal exceeds its values at the points of the time grid due to rounding \[–\].
const ROUNDING: f64 = 1e-9;
/// Number of samples between two points of the time grid, at positions that no period repeats.
const INSIDE: usize = 5;

/// A value of a signal between two points of the time grid that exceeds those at the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// Time of the value \[s\]
    pub t: f64,
    /// Value in the unit of the signal
    pub value: f64,
    /// Distance from the values at the points, relative to the range of the signal \[–\]
    pub share: f64,
}

/// The value between two points of the time grid that exceeds the values at the points most; `None` if no value exceeds them.
pub fn between(signal: &Signal, spans: &[TimeSpan]) -> Option<Between> {
    let widen = |(low, high): (f64, f64), s: f64| (low.min(s), high.max(s));
    let (mut on_grid, mut inside) = ((f64::INFINITY, f64::NEG_INFINITY), Vec::new());
    for span in spans.iter().filter(|span| !matches!(span.integrator, Integrator::ArcLength { .. })) {
        let points: Vec<f64> = (0..=span.steps().min(100_000)).map(|k| span.point(k)).collect();
        on_grid = points.iter().fold(on_grid, |range, t| widen(range, signal.at(*t)));
        for (k, step) in points.windows(2).enumerate() {
            // Multiples of the golden ratio
            let share = |j: usize| ((k * INSIDE + j) as f64 * 0.618_033_988_749_894_9).fract();
            let times = (1..=INSIDE).map(|j| step[0] + share(j) * (step[1] - step[0]));
            inside.extend(times.map(|t| (t, signal.at(t))).filter(|(_, s)| s.is_finite()));
        }
    }
    let (low, high) = inside.iter().fold(on_grid, |range, (_, s)| widen(range, *s));
    let beyond = |s: f64| (on_grid.0 - s).max(s - on_grid.1);
    let farthest = inside.into_iter().max_by(|a, b| beyond(a.1).total_cmp(&beyond(b.1)))?;
    let (t, value) = farthest;
    let share = beyond(value) / (high - low);
    (share > ROUNDING).then_some(Between { t, value, share })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points at 0.2 s and 0.4 s miss the maximum of a sine of 1 Hz by 4.9 % of its range over 0.4 s, and a point at 0.25 s hits it. Samples in a step lie up
    /// to a tenth of it away from the maximum, which lowers the result by (0.04π)²/2.
    #[test]
    fn the_share_that_steps_miss_is_found() {
        let sine = Signal::Sine { amplitude: 2.0, frequency: 1.0, phase: 0.0 };
        let share = |end: f64, dt: f64| {
            let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end, dt };
            between(&sine, &[span]).map(|b| b.share)
        };
        let missed = 1.0 - (0.4 * std::f64::consts::PI).sin();
        let found = share(0.4, 0.2).expect("the top lies between two points");
        assert!(found <= missed && found > missed - 0.008, "{found} of {missed}");
        assert_eq!(share(0.5, 0.05), None);
    }

    #[test]
    fn what_the_steps_do_not_see_is_found() {
        let seen = |signal: &Signal, dt: f64| {
            let span = TimeSpan { integrator: Integrator::Bdf2, start: 0.0, end: 1.0, dt };
            between(signal, &[span]).filter(|b| b.share > 0.1).map(|b| b.value.abs())
        };
        let sine = |frequency: f64| Signal::Sine { amplitude: 2.0, frequency, phase: 0.0 };
        // Multiples of the frequency of the grid, and of that of equally spaced samples in its steps
        for frequency in [100.0, 200.0, 400.0, 500.0, 2000.0] {
            assert!(seen(&sine(frequency), 0.01).is_some_and(|s| s > 1.9), "{frequency} Hz");
        }
        let cosine = Signal::RaisedCosine { amplitude: 5.0, frequency: 1.0 };
        assert!(seen(&cosine, 1.0).is_some_and(|s| s > 4.0));
        for (signal, dt) in [(sine(10.0), 0.01), (cosine, 0.25), (Signal::Constant(3.0), 1.0)] {
            assert_eq!(seen(&signal, dt), None, "{signal:?}");
        }
        let ramp = Signal::Ramp { from: 0.0, to: 1.0, start: 0.033, end: 0.034 };
        assert_eq!(seen(&ramp, 0.1), None, "a jump within a step ends at a value that the grid sees");
    }
}
