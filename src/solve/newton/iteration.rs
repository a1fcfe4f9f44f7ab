//! Reports of the iterations of Newton's method.

use std::sync::Arc;

/// An iteration of Newton's method, or a contact correction, before its direction is known; also for steps that are not accepted later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationReport {
    /// End of the step \[s\]
    pub t: f64,
    /// Length of the step \[s\]
    pub dt: f64,
    /// Number of iterations of the step so far
    pub number: usize,
    /// Error of the forces relative to the tolerance \[–\]; at most 1 if the tolerance is met
    pub error: f64,
}

/// A callback that receives the iterations of a run, in the thread that computes it.
pub type OnIteration = Arc<dyn Fn(&IterationReport) + Send + Sync>;
