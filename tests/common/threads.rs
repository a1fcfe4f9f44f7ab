//! The number of threads, which is that of the whole test program.

use durometer::math::threads::{count, locked, use_threads};
use std::sync::Mutex;

/// Does work whose loops use this many threads; other work that is done by this function waits meanwhile.
pub fn on<R>(threads: usize, work: impl FnOnce() -> R) -> R {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = locked(&ONE_AT_A_TIME);
    use_threads(threads);
    let result = work();
    assert_eq!(count(), threads, "the number of threads was changed meanwhile");
    result
}
