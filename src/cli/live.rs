//! The live view of `durometer simulate` and `durometer run`: its flags, and the run that it shows.

use durometer::live::{Board, Listener, LiveError, Opening, SignalState};
use durometer::report::viewer::film::Film;
use durometer::report::viewer::page::live_page;
use durometer::scene::{Checkpoint, Run, Scene};
use durometer::solve::{OnIteration, Status};
use durometer::study::view;
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Time that the process waits for pages to take the last states, when all results are written.
const FAREWELL: Duration = Duration::from_secs(3);

/// Flags of the live view.
#[derive(clap::Args)]
pub struct LiveArgs {
    /// Show the run in a browser while it goes on: serves a page on this machine alone (127.0.0.1), at an address with a token that is printed.
    /// The page pauses the run, takes single steps, and sets the `controlled` signals of the scene, which <name>.control.csv records
    #[arg(long)]
    live: bool,
    /// Port of the live view; 0 is a free one
    #[arg(long, value_name = "N", default_value_t = 0, requires = "live")]
    port: u16,
    /// Wait at the first state until a page lets the run go on
    #[arg(long, requires = "live")]
    paused: bool,
}

impl LiveArgs {
    /// Opens the port, before anything is computed.
    pub fn listen(&self) -> Result<Option<Listener>, LiveError> {
        if self.live { Listener::open(self.port).map(Some) } else { Ok(None) }
    }

    /// Serves a page for a run of the scene; `by_hand`: its signals are those that a page may set.
    pub fn serve(
        &self,
        listener: Listener,
        run: (&Scene, Option<&Checkpoint>, &str),
        film: &Film,
        by_hand: bool,
    ) -> Arc<Board> {
        let (scene, from, name) = run;
        let initial = || scene.controls.values_from_outside(&scene.controls.memory());
        let values = from.map_or_else(initial, |checkpoint| checkpoint.controlled(scene));
        let controlled = scene.controls.controlled().into_iter().zip(values).zip(scene.controls.ranges());
        let signals = controlled.map(|((name, value), range)| SignalState { name, value, range });
        let board = Arc::new(Board::new(Opening {
            end: scene.spans.last().map_or(0.0, |span| span.end),
            signals: signals.filter(|_| by_hand).collect(),
            paused: self.paused,
        }));
        let about = view::about_before(scene, name);
        let title = about.title.clone();
        let settings = json!({ "pauses": true, "recorded": by_hand.then(|| format!("{name}.control.csv")) });
        board.open(live_page(&title, &film.opening(scene, about), &settings));
        from.iter().for_each(|checkpoint| board.state(film, scene, &checkpoint.state));
        let serving = listener.serve(board.clone());
        if serving.is_served {
            eprintln!("live:    {} (open it in a browser on this machine)", serving.address);
        } else {
            eprintln!("note: there is no live view: the system starts no more threads");
        }
        board
    }
}

/// Tells a board the iterations of a run.
pub fn iterations(board: Arc<Board>) -> OnIteration {
    Arc::new(move |report| board.iteration(report))
}

/// Tells the pages how the run has ended, and gives them time to take the last states.
pub fn end(board: Option<&Board>, run: &Run, stop: &AtomicBool) {
    let Some(board) = board else { return };
    let why = run.failure.as_ref().map(ToString::to_string);
    board.end(run.status.name(), why.or_else(|| (run.status != Status::Converged).then(|| run.status.to_string())));
    board.farewell(FAREWELL, stop);
}
