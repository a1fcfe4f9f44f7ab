//! The time budget of a plan as wall time, and its shares.

use std::time::Instant;

/// Share of the budget for the pilots and their meshes.
const PILOTS: f64 = 0.25;
/// Share of the budget after which no further exploratory run is started.
const LEARNING: f64 = 0.5;

/// Remaining time of a budget from its start. Everything counts: meshes, symbolic factorisations, runs.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    start: Instant,
    total_s: f64,
}

impl Budget {
    /// Starts a budget now.
    pub fn new(total_s: f64) -> Self {
        Self { start: Instant::now(), total_s }
    }

    /// Wall time since the start \[s\].
    pub fn spent_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// The remaining time of the whole budget \[s\]; not negative.
    pub fn left_s(&self) -> f64 {
        self.share(1.0)
    }

    /// The remaining time for pilots \[s\].
    pub fn pilots_s(&self) -> f64 {
        self.share(PILOTS)
    }

    /// The remaining time for pilots and for the runs that examine the time step \[s\].
    pub fn learning_s(&self) -> f64 {
        self.share(LEARNING)
    }

    fn share(&self, share: f64) -> f64 {
        (share * self.total_s - self.spent_s()).max(0.0)
    }
}
