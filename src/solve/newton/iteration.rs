//! Iterations of Newton's method, for whoever follows them.

use std::sync::Arc;

/// An iteration of Newton's method or a contact correction, before its direction is known; also of a step that is not accepted later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationReport {
    /// End of the step \[s\]
    pub t: f64,
    /// Length of the step \[s\]
    pub dt: f64,
    /// Iterations of the step so far
    pub number: usize,
    /// Error of the forces as a share of the tolerance \[–\]; at most 1 where it is met
    pub error: f64,
}

/// Receives the iterations of a run, in the thread that computes it.
pub type OnIteration = Arc<dyn Fn(&IterationReport) + Send + Sync>;
