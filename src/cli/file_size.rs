//! Limits on the size of files (`ulimit -f`, batch systems).

/// Makes a write beyond the limit fail, so that the reason can be reported. By default the system ends the process with SIGXFSZ.
pub fn let_writes_fail() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigHandler, Signal, signal};
        // SAFETY: no handler is set that could run in the middle of other code.
        unsafe { signal(Signal::SIGXFSZ, SigHandler::SigIgn) }.ok();
    }
}
