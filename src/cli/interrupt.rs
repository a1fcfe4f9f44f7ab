//! Ctrl-C and SIGTERM.

use super::outcome::{Outcome, exit_code};
use durometer::mesh::generate::end_meshers;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once, OnceLock};

static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
static LISTENING: Once = Once::new();
/// Set while a command has nothing to keep and does not check the flag
static SETS_UP: AtomicBool = AtomicBool::new(false);

/// Returns the flag that Ctrl-C and SIGTERM set: finished results are kept, running work is dropped. A second signal ends the program at once.
pub fn stop_flag() -> &'static Arc<AtomicBool> {
    let handler = || {
        end_meshers();
        if SETS_UP.load(Ordering::SeqCst) {
            tell!("stopped: before the first step");
            std::process::exit(exit_code(&Ok(Outcome::Interrupted)).into());
        }
        if flag().swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    };
    LISTENING.call_once(|| listen(handler));
    flag()
}

/// Returns the stop flag without starting a thread that waits for signals; a caller that uses the program as a function may set it.
pub fn flag() -> &'static Arc<AtomicBool> {
    STOP.get_or_init(Arc::default)
}

/// Marks the beginning (true) or the end (false) of the set-up of a run. During the set-up a signal ends the program at once, because, for example, the
/// library that orders the equations does not check for a stop.
pub fn set_up(goes_on: bool) {
    SETS_UP.store(goes_on, Ordering::SeqCst);
}

/// Whether a signal has requested a stop from a command that listens for signals.
pub fn was_stopped() -> bool {
    flag().load(Ordering::SeqCst)
}

/// Calls `handler` for every SIGINT and SIGTERM. The signals are blocked in this thread and in all threads that it starts later, and one thread waits for
/// them. This is needed because METIS temporarily installs a SIGTERM handler that ends the process if another thread receives the signal.
#[cfg(unix)]
fn listen(handler: impl Fn() + Send + 'static) {
    use nix::sys::signal::{SigSet, Signal};
    let signals: SigSet = [Signal::SIGINT, Signal::SIGTERM].into_iter().collect();
    // If the signals cannot be blocked they still end the program; finished cases are on disk in any case.
    if signals.thread_block().is_ok() {
        std::thread::spawn(move || {
            while signals.wait().is_ok() {
                handler();
            }
        });
    }
}

#[cfg(not(unix))]
fn listen(handler: impl Fn() + Send + 'static) {
    ctrlc::set_handler(handler).ok();
}
