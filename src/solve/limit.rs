//! Limits that end a run before its last step: a deadline, or a flag that another thread sets.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Looked at before every step, every assembly and every factorisation.
#[derive(Clone, Debug, Default)]
pub struct Limit {
    pub deadline: Option<Instant>,
    /// Set to stop the run
    pub stop: Option<Arc<AtomicBool>>,
}

/// The limit that ends a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    Stopped,
    TimeOver,
}

impl Limit {
    /// The limit that is reached; none while the run may go on.
    pub fn reached(&self) -> Option<Reached> {
        if self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Some(Reached::Stopped);
        }
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline).then_some(Reached::TimeOver)
    }
}
