//! Threads within one case: their number, and the only loop that uses them.
//!
//! A program that owns its process can set the number of threads at any time ([`use_threads`]); without such a call there is one thread. Results do
//! not depend on the number: the work of a loop, and the order of its results, depend only on its items.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::process;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Number of threads in use from now on; 0 until it has been set.
static WANTED: AtomicUsize = AtomicUsize::new(0);
static POOLS: Mutex<BTreeMap<usize, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
/// The process that has started the threads; 0 as long as no process has.
static OWNER: AtomicU32 = AtomicU32::new(0);

thread_local! {
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Lets the loops of this process use `count` threads, but at least one; the process must compute nothing else.
pub fn use_threads(count: usize) {
    WANTED.store(count.max(1), Ordering::Relaxed);
}

/// Number of cores that this process may use.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, Into::into)
}

/// Number of threads in use.
pub fn count() -> usize {
    WANTED.load(Ordering::Relaxed).max(1)
}

/// Whether the program has set the number of threads, and so owns its process.
pub(super) fn owns_the_process() -> bool {
    WANTED.load(Ordering::Relaxed) > 0
}

/// Does work whose loops run in this thread alone. Use it for work that another thread waits for: all threads of the pool may be waiting in the same
/// way.
pub fn alone<R>(work: impl FnOnce() -> R) -> R {
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            ALONE.set(self.0);
        }
    }
    let _before = Before(ALONE.replace(true));
    work()
}

/// Whether this thread does work within [`alone`].
pub fn is_alone() -> bool {
    ALONE.get()
}

/// Whether this process was forked after another one had started the threads: it has none of them, and its loops run in the calling thread.
pub fn are_left_behind() -> bool {
    let owner = OWNER.load(Ordering::Relaxed);
    owner != 0 && owner != process::id()
}

/// Applies f to each item on the threads in use; the results are in the order of the items.
pub fn map<T: Send, R: Send>(items: Vec<T>, f: impl Fn(T) -> R + Sync) -> Vec<R> {
    let pool = if items.len() < 2 { None } else { pool(count()) };
    match pool {
        // Each item is worth a task of its own
        Some(pool) => pool.install(|| items.into_par_iter().with_max_len(1).map(&f).collect()),
        None => items.into_iter().map(f).collect(),
    }
}

/// Runs f on one of the threads if there are several, so that its loops begin at once, without first waking another thread.
pub fn inside<R: Send>(f: impl FnOnce() -> R + Send) -> R {
    match pool(count()) {
        Some(pool) => pool.install(f),
        None => f(),
    }
}

/// Ranges of items of about equal weight, which is at least `least` unless there is only one range; there are at most `most` of them. `ends[i + 1] −
/// ends[i]` is the weight of item i.
pub fn divide(ends: &[u32], least: usize, most: usize) -> Vec<Range<usize>> {
    let (items, total) = (ends.len() - 1, ends[ends.len() - 1] as usize);
    let parts = (total / least).clamp(1, most);
    let end = |part: usize| match part {
        _ if part == parts => items,
        _ => ends.partition_point(|&end| (end as usize) < total * part / parts).min(items),
    };
    (0..parts).map(|part| end(part)..end(part + 1)).collect()
}

/// Locks a mutex, even if a thread that held it has panicked.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The pool of this many threads; `None` for one thread, if the system refuses to start threads, in a process that was forked without them, and
/// within [`alone`].
fn pool(count: usize) -> Option<Arc<ThreadPool>> {
    if count < 2 || is_alone() || are_left_behind() {
        return None;
    }
    let mut pools = locked(&POOLS);
    if let Some(pool) = pools.get(&count) {
        return Some(pool.clone());
    }
    let pool = Arc::new(ThreadPoolBuilder::new().num_threads(count).build().ok()?);
    OWNER.store(process::id(), Ordering::Relaxed);
    pools.insert(count, pool.clone());
    Some(pool)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_contiguous_and_of_equal_weight() {
        let ends: Vec<u32> = (0..=1000).map(|i| 3 * i).collect();
        let parts = divide(&ends, 400, 5);
        assert_eq!(parts.len(), 5);
        assert!(parts.iter().all(|p| p.len().abs_diff(200) <= 1));
        assert!(parts[0].start == 0 && parts[4].end == 1000 && parts.windows(2).all(|w| w[0].end == w[1].start));
        assert!(divide(&ends, 5000, 5).into_iter().eq(std::iter::once(0..1000)));
        assert!(divide(&[0], 1, 5).into_iter().eq(std::iter::once(0..0)));
        // One heavy item leaves some parts empty
        let parts = divide(&[0, 0, 900, 901], 100, 4);
        assert_eq!(parts.iter().map(Range::len).sum::<usize>(), 3);
    }

    #[test]
    fn work_that_is_done_alone_stays_in_its_thread() {
        use_threads(3);
        let own = std::thread::current().id();
        let loops = || map(vec![(); 50], |()| inside(|| std::thread::current().id()));
        assert!(alone(|| alone(loops).into_iter().chain(loops()).all(|thread| thread == own)));
        assert!(!is_alone());
    }

    #[test]
    fn results_are_in_the_order_of_the_items_and_loops_may_be_nested() {
        for threads in [1, 2, 3, 8] {
            use_threads(threads);
            let sum = |n: u64| map((0..n).collect(), |i| i * i).into_iter().sum::<u64>();
            let found = map((0..50).collect(), sum);
            assert!(found.into_iter().eq((0..50).map(|n| (0..n).map(|i| i * i).sum::<u64>())), "{threads} threads");
        }
    }
}
