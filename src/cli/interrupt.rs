//! Ctrl-C and SIGTERM.

use super::outcome::{Outcome, exit_code};
use durometer::mesh::generate::end_meshers;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once, OnceLock};

static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
static LISTENING: Once = Once::new();
/// Set while a command has nothing to keep and does not look at the flag
static SETS_UP: AtomicBool = AtomicBool::new(false);

/// Set by Ctrl-C and by SIGTERM: what is finished is kept, what runs is dropped. A second one ends the program at once.
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

/// The same flag, without a thread that waits for signals: who calls the program as a function may set it.
pub fn flag() -> &'static Arc<AtomicBool> {
    STOP.get_or_init(Arc::default)
}

/// Says that a run is set up from here on, or that this is done. A signal ends the program at once until then: the order of the equations, for
/// example, is found in a library that looks at nothing else.
pub fn set_up(goes_on: bool) {
    SETS_UP.store(goes_on, Ordering::SeqCst);
}

/// Whether a signal has asked a command that listens to stop.
pub fn was_stopped() -> bool {
    flag().load(Ordering::SeqCst)
}

/// Calls `handler` for every such signal. They are blocked in this thread and in those that it starts later, and one thread waits for them: METIS
/// replaces the handler of SIGTERM while it runs, by one that ends the process where another thread receives it.
#[cfg(unix)]
fn listen(handler: impl Fn() + Send + 'static) {
    use nix::sys::signal::{SigSet, Signal};
    let signals: SigSet = [Signal::SIGINT, Signal::SIGTERM].into_iter().collect();
    // Where they cannot be blocked they still end the program; finished cases are on disk in any case.
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
