//! The live view of a case, from the process that computes it.

use crate::live::{Access, Board, Listener, Served, Shown, board};
use crate::report::viewer::film::Film;
use crate::report::viewer::shape::Limits;
use crate::scene::{Run, Scene};
use crate::solve::Status;
use crate::study::store::fields::USUAL;
use crate::study::view;
use crate::system::State;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Never set: a stopped case ends with its process.
static STOP: AtomicBool = AtomicBool::new(false);
/// Time that pages get to receive the last states.
const FAREWELL: Duration = Duration::from_secs(1);

/// A case that is shown while it runs.
pub(super) struct LiveCase {
    film: Film,
    board: Arc<Board>,
    _served: Served,
}

impl LiveCase {
    /// Serves the run of a case and passes on the port. `None` if the system provides no port or thread; the case is computed nevertheless.
    pub fn open(access: &Access, id: &str, scene: &Scene, serves: &mut dyn FnMut(u16)) -> Option<Self> {
        let (listener, port) = Listener::behind(access).ok()?;
        let chosen = scene.spec.output.fields.as_ref().map_or(&USUAL[..], |fields| &fields.what);
        let film = Film::new(scene, chosen, &Limits::USUAL);
        let shown = Shown { run: id, case: true, from: None, recording: None, paused: false };
        let board = board(scene, &film, view::about_before(scene, id), &shown);
        let served = listener.serve(board.clone())?;
        serves(port);
        Some(Self { film, board, _served: served })
    }

    pub fn board(&self) -> &Arc<Board> {
        &self.board
    }

    /// Shows a state at a point of the time grid, and waits there if a page has paused the run.
    pub fn add(&mut self, scene: &Scene, state: &State) {
        self.film.add(scene, state);
        self.board.state(&self.film, scene, state);
        self.board.pause(&STOP);
    }

    /// Tells the pages how the run has ended.
    pub fn end(self, run: &Run) {
        let detail = (run.status != Status::Converged).then(|| run.status.to_string());
        self.board.end(run.status.name(), detail);
        self.board.farewell(FAREWELL, &STOP);
    }
}
