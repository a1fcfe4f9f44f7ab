//! CPU time of computations.

use super::threads::owns_the_process;
use cpu_time::{ProcessTime, ThreadTime};
use std::time::Duration;

/// CPU time of a computation: of all threads where the process computes nothing else, otherwise of the thread that calls.
#[derive(Clone, Copy, Debug)]
pub enum CpuClock {
    Process(ProcessTime),
    Thread(ThreadTime),
}

impl CpuClock {
    /// Counts from now.
    pub fn start() -> Self {
        if owns_the_process() { Self::Process(ProcessTime::now()) } else { Self::Thread(ThreadTime::now()) }
    }

    /// CPU time since the start.
    pub fn elapsed(&self) -> Duration {
        match self {
            Self::Process(start) => start.elapsed(),
            Self::Thread(start) => start.elapsed(),
        }
    }
}
