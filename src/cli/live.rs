//! Start and end of the live view.

use durometer::live::{Board, Listener, LiveError, Relay, Served};
use durometer::scene::Run;
use durometer::solve::Status;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Time that the process waits for pages to fetch the last states after all results have been written.
const FAREWELL: Duration = Duration::from_secs(3);

/// Opens the port of a requested live view, before anything is computed.
pub fn listen(is_asked: bool, port: u16) -> Result<Option<Listener>, LiveError> {
    if is_asked { Listener::open(port).map(Some) } else { Ok(None) }
}

/// Prints the address of the live view, or that there is none because the system cannot start another thread.
fn announce(address: &str, is_served: bool) {
    match is_served {
        true => tell!("live:    {address} (open it in a browser on this machine)"),
        false => tell!("note: there is no live view: the system starts no more threads"),
    }
}

/// Serves the cases of a study at one address, until the second value is dropped.
pub fn relay(listener: Listener) -> Option<(Arc<Relay>, Served)> {
    let address = listener.access().address();
    let relay = Relay::serve(listener);
    announce(&address, relay.is_some());
    relay
}

/// Serves a board, until the returned value is dropped.
pub fn serve(listener: Listener, board: Arc<Board>) -> Option<Served> {
    let address = listener.access().address();
    let served = listener.serve(board);
    announce(&address, served.is_some());
    served
}

/// Tells the pages how the run has ended, and gives them time to fetch the last states.
pub fn end(board: Option<&Board>, run: &Run, stop: &AtomicBool) {
    let Some(board) = board else { return };
    let status = || (run.status != Status::Converged).then(|| run.status.to_string());
    board.end(run.status.name(), run.failure.as_ref().map(ToString::to_string).or_else(status));
    board.farewell(FAREWELL, stop);
}
