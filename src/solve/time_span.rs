//! A stretch of time with one integrator and one nominal step.

use super::Integrator;

/// A stretch of time with one integrator and one nominal step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpan {
    pub integrator: Integrator,
    pub start: f64,
    pub end: f64,
    /// Nominal step \[s\]; the grid start + k·dt is hit whatever was cut
    pub dt: f64,
}

impl TimeSpan {
    /// Number of nominal steps.
    pub fn steps(&self) -> usize {
        ((self.end - self.start) / self.dt - 1e-9).ceil().max(1.0) as usize
    }

    /// Point `k` of the time grid, the start being point 0.
    pub fn point(&self, k: usize) -> f64 {
        if k == self.steps() { self.end } else { self.start + k as f64 * self.dt }
    }
}
