//! The live view: a page of the viewer that follows a run while it computes, pauses it, and sets its controlled signals.
//!
//! ```text
//! run ──► board ──► server ──► page        states, rows, iterations: the board has the newest, a client fetches it when it can
//! run ◄── board ◄── server ◄── page        commands: pause, one step, values of signals, executed at the next point of the time grid
//! ```
//!
//! The computing thread holds the lock of the board only as long as it takes to copy a pointer, and never waits for a client unless somebody has
//! paused the run. The server listens only on the loopback interface and answers under a path with a random token.

mod board;
mod hand;
mod news;
mod relay;
mod request;
mod response;
mod server;
mod thinned;
mod view;

pub use board::{Board, Opening};
pub use hand::HandControl;
pub use news::SignalState;
pub use relay::Relay;
pub use server::{Access, Listener, LiveError, Served};
pub use view::{Shown, board, iterations};
