//! Flags of the live view, and its beginning and end.

use durometer::live::{Board, Listener, LiveError, Relay, Served};
use durometer::scene::Run;
use durometer::solve::Status;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Time that the process waits for pages to take the last states, when all results are written.
const FAREWELL: Duration = Duration::from_secs(3);

/// Opens the port of a live view that is asked for, before anything is computed.
pub fn listen(is_asked: bool, port: u16) -> Result<Option<Listener>, LiveError> {
    if is_asked { Listener::open(port).map(Some) } else { Ok(None) }
}

/// Says where a live view is; or that there is none, because the system starts no more threads.
fn announce(address: &str, is_served: bool) {
    match is_served {
        true => tell!("live:    {address} (open it in a browser on this machine)"),
        false => tell!("note: there is no live view: the system starts no more threads"),
    }
}

/// Serves the cases of a study at one address, as long as the second value lives.
pub fn relay(listener: Listener) -> Option<(Arc<Relay>, Served)> {
    let address = listener.access().address();
    let relay = Relay::serve(listener);
    announce(&address, relay.is_some());
    relay
}

/// Serves a board, as long as what it returns lives.
pub fn serve(listener: Listener, board: Arc<Board>) -> Option<Served> {
    let address = listener.access().address();
    let served = listener.serve(board);
    announce(&address, served.is_some());
    served
}

/// Tells the pages how the run has ended, and gives them time to take the last states.
pub fn end(board: Option<&Board>, run: &Run, stop: &AtomicBool) {
    let Some(board) = board else { return };
    let status = || (run.status != Status::Converged).then(|| run.status.to_string());
    board.end(run.status.name(), run.failure.as_ref().map(ToString::to_string).or_else(status));
    board.farewell(FAREWELL, stop);
}
