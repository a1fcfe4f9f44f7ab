//! Limits that end a run before its last step: a deadline, a number of iterations, or a flag that another thread sets.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A limit of a run, checked before every step, assembly and factorisation.
#[derive(Clone, Debug, Default)]
pub struct Limit {
    pub deadline: Option<Instant>,
    /// Number of iterations that are left
    pub iterations_left: Option<usize>,
    /// Flag that is set to stop the run
    pub stop: Option<Arc<AtomicBool>>,
}

/// The limit that ends a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    Stopped,
    TimeOver,
}

impl Limit {
    /// Counts an iteration.
    pub fn spend_iteration(&mut self) {
        if let Some(left) = &mut self.iterations_left {
            *left = left.saturating_sub(1);
        }
    }

    /// The limit that has been reached; `None` while the run may continue.
    pub fn reached(&self) -> Option<Reached> {
        if self.iterations_left == Some(0) || self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Some(Reached::Stopped);
        }
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline).then_some(Reached::TimeOver)
    }
}
