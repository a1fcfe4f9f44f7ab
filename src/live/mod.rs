//! The live view: a page of the viewer that follows a run while it goes on, pauses it, and sets its controlled signals.
//!
//! ```text
//! run ──► board ──► server ──► page        states, rows, iterations: the board has the newest, a client takes it when it can
//! run ◄── board ◄── server ◄── page        commands: pause, one step, values of signals, taken at the next point of the time grid
//! ```
//!
//! The thread that computes holds the lock of the board for as long as it takes to copy a pointer, and waits for no client, except where somebody has
//! paused the run. The server listens on the loopback interface alone and answers under a path with a random token.

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
