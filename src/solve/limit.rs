//! Limits that end a run before its last step: a deadline, or a flag that another thread sets.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A limit of a run, checked before every step, assembly and factorisation.
#[derive(Clone, Debug, Default)]
pub struct Limit {
    pub deadline: Option<Instant>,
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
    /// The limit that has been reached; `None` while the run may continue.
    pub fn reached(&self) -> Option<Reached> {
        if self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Some(Reached::Stopped);
        }
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline).then_some(Reached::TimeOver)
    }
}
