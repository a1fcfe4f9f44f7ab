//! Wall and CPU times of computations.

use super::threads::owns_the_process;
use cpu_time::{ProcessTime, ThreadTime};
use std::ops::{Add, AddAssign, Sub};
use std::time::Instant;

/// Wall and CPU time of a computation \[s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    pub wall_s: f64,
    pub cpu_s: f64,
}

impl Add for Spent {
    type Output = Self;

    fn add(self, o: Self) -> Self {
        Self { wall_s: self.wall_s + o.wall_s, cpu_s: self.cpu_s + o.cpu_s }
    }
}

impl AddAssign for Spent {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Spent {
    type Output = Self;

    fn sub(self, o: Self) -> Self {
        Self { wall_s: self.wall_s - o.wall_s, cpu_s: self.cpu_s - o.cpu_s }
    }
}

/// Measures a computation from its start on. The CPU time includes all threads if the process computes nothing else, otherwise only the calling
/// thread.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: CpuClock,
}

#[derive(Clone, Copy, Debug)]
enum CpuClock {
    Process(ProcessTime),
    Thread(ThreadTime),
}

impl Stopwatch {
    /// Starts the measurement.
    pub fn start() -> Self {
        let wall = Instant::now();
        let cpu = match owns_the_process() {
            true => CpuClock::Process(ProcessTime::now()),
            false => CpuClock::Thread(ThreadTime::now()),
        };
        Self { wall, cpu }
    }

    /// Time since the start.
    pub fn spent(&self) -> Spent {
        let cpu = match &self.cpu {
            CpuClock::Process(start) => start.elapsed(),
            CpuClock::Thread(start) => start.elapsed(),
        };
        Spent { wall_s: self.wall.elapsed().as_secs_f64(), cpu_s: cpu.as_secs_f64() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Waiting takes no CPU time: the two times are not exchanged, whatever is added and subtracted.
    #[test]
    fn waiting_is_wall_time_alone() {
        let stopwatch = Stopwatch { wall: Instant::now(), cpu: CpuClock::Thread(ThreadTime::now()) };
        std::thread::sleep(Duration::from_millis(200));
        let waited = stopwatch.spent();
        assert!(waited.wall_s >= 0.2 && waited.cpu_s < 0.1, "{waited:?}");
        let (mut sum, own) = (Spent { wall_s: 5.0, cpu_s: 2.0 }, Spent { wall_s: 3.0, cpu_s: 0.5 });
        sum += own;
        assert_eq!((sum, sum - own - own), (Spent { wall_s: 8.0, cpu_s: 2.5 }, Spent { wall_s: 2.0, cpu_s: 1.5 }));
    }
}
