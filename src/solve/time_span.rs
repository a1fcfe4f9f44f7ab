//! A span of time with one integrator and one nominal step.

use super::Integrator;

/// Share of the nominal step up to which the rest of a span is added to the last step \[–\]. It exceeds the rounding of (end − start)/dt if the steps
/// are [resolved](TimeSpan::is_resolved).
const REMAINDER: f64 = 1e-3;

/// A span of time with one integrator and one nominal step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpan {
    pub integrator: Integrator,
    pub start: f64,
    pub end: f64,
    /// Nominal step \[s\]; the grid points start + k·dt are reached exactly, whatever was cut
    pub dt: f64,
}

impl TimeSpan {
    /// Number of nominal steps. If the span is not a multiple of the nominal step, the last one is shorter, or longer by less than a thousandth of
    /// it.
    pub fn steps(&self) -> usize {
        ((self.end - self.start) / self.dt - REMAINDER).ceil().max(1.0) as usize
    }

    /// Whether the last step has the nominal length, like all others, up to the allowed rest.
    pub fn ends_with_whole_step(&self) -> bool {
        (self.end - self.point(self.steps() - 1) - self.dt).abs() <= 2.0 * REMAINDER * self.dt
    }

    /// Whether the rounding of the time at the end is less than a thousandth of the nominal step, so that all steps have their nominal lengths.
    pub fn is_resolved(&self) -> bool {
        f64::EPSILON * self.end.abs() <= REMAINDER * self.dt
    }

    /// Point `k` of the time grid, where the start is point 0.
    pub fn point(&self, k: usize) -> f64 {
        if k == self.steps() { self.end } else { self.start + k as f64 * self.dt }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever a stage starts, a multiple of dt has the corresponding number of steps of dt, and a rest is a step of its own or part of the last
    /// one. Lengths may lack the rounding of the times, ε t, at both ends.
    #[test]
    fn late_stages_have_the_steps_of_early_ones() {
        for start in [0.0, 300.0, 3600.0, 86400.0] {
            for dt in [1e-5, 1e-4, 1e-3 / 3.0, 2e-3, 0.1, 0.333_333_333_33] {
                for n in [1, 2, 3, 300, 3000] {
                    for (left, more, last) in
                        [(0.0, 0, 1.0), (1e-7, 0, 1.0), (5e-4, 0, 1.0), (2e-3, 1, 2e-3), (0.5, 1, 0.5)]
                    {
                        let end = start + (f64::from(n) + left) * dt;
                        let span = TimeSpan { integrator: Integrator::Bdf2, start, end, dt };
                        let (steps, rounding) = (n as usize + more, 2.0 * f64::EPSILON * end / dt);
                        let lengths: Vec<f64> = (0..steps).map(|k| (span.point(k + 1) - span.point(k)) / dt).collect();
                        let place = format!("{n} + {left} steps of {dt} s from {start} s");
                        assert!(span.is_resolved() && span.steps() == steps, "{place}: {}", span.steps());
                        assert_eq!(span.point(steps), end);
                        let (at_end, others) = lengths.split_last().expect("a step");
                        assert!(others.iter().all(|length| (length - 1.0).abs() <= rounding), "{place}: {others:?}");
                        assert!((at_end - last).abs() <= 1e-3 + rounding, "{place}: the last one is {at_end}");
                    }
                }
            }
        }
        for (end, is_whole) in [(1.0, true), (1.000_05, true), (1.0003, false), (0.95, false), (0.04, false)] {
            let span = TimeSpan { integrator: Integrator::Bdf2, start: 0.0, end, dt: 0.1 };
            assert_eq!(span.ends_with_whole_step(), is_whole, "{end}");
        }
        let swallowed = TimeSpan { integrator: Integrator::Bdf2, start: 86400.0, end: 86400.0 + 1e-6, dt: 1e-9 };
        assert!(!swallowed.is_resolved());
    }
}
