//! Threads of cases that run side by side: the cases that are computing share the cores, and the remainder goes to the largest ones.

use crate::math::threads::locked;
use std::cmp::Reverse;
use std::sync::{Mutex, MutexGuard};

/// The cores of a run, and the cases that are computing.
pub struct Cores {
    count: usize,
    computing: Mutex<Computing>,
}

#[derive(Default)]
struct Computing {
    begun: usize,
    /// Size and number of each case, the largest first
    cases: Vec<(Reverse<usize>, usize)>,
}

/// The share of a case in the cores, which ends when it is dropped.
pub struct Share<'a> {
    cores: &'a Cores,
    case: (Reverse<usize>, usize),
}

impl Cores {
    pub fn new(count: usize) -> Self {
        Self { count, computing: Mutex::default() }
    }

    /// Registers a case of this size, e.g. in nodes, that starts computing.
    pub fn join(&self, size: usize) -> Share<'_> {
        let mut computing = self.computing();
        let case = (Reverse(size), computing.begun);
        computing.begun += 1;
        let place = computing.cases.partition_point(|other| *other < case);
        computing.cases.insert(place, case);
        Share { cores: self, case }
    }

    fn computing(&self) -> MutexGuard<'_, Computing> {
        locked(&self.computing)
    }
}

impl Share<'_> {
    /// Number of threads that the case may use at this moment.
    pub fn threads(&self) -> usize {
        let (count, computing) = (self.cores.count, self.cores.computing());
        let (cases, rank) = (computing.cases.len(), computing.cases.partition_point(|other| *other < self.case));
        (count / cases + usize::from(rank < count % cases)).max(1)
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        self.cores.computing().cases.retain(|case| *case != self.case);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_share_the_cores_and_the_last_one_has_them_all() {
        let cores = Cores::new(5);
        let small = cores.join(100);
        assert_eq!(small.threads(), 5);
        let large = cores.join(9000);
        assert_eq!([small.threads(), large.threads()], [2, 3]);
        let others: Vec<Share> = (0..6).map(|_| cores.join(100)).collect();
        assert_eq!([small.threads(), large.threads()], [1, 1]);
        drop((small, others));
        assert_eq!(large.threads(), 5);
    }
}
