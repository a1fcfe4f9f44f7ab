//! The live view of a run of a scene: its page, its states and its iterations.

use super::board::{Board, Opening};
use super::news::SignalState;
use crate::report::viewer::film::Film;
use crate::report::viewer::footage::About;
use crate::report::viewer::page::live_page;
use crate::scene::{Checkpoint, Scene, column};
use crate::solve::OnIteration;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// How a run is shown in the live view.
pub struct Shown<'a> {
    /// Distinguishes runs that are shown at the same address
    pub run: &'a str,
    /// The run is a case of a study: the page names it, and another case may follow at this address
    pub case: bool,
    /// The state that the run continues from
    pub from: Option<&'a Checkpoint>,
    /// The signals are set by the page, and recorded in this file
    pub recording: Option<&'a Path>,
    /// Wait at the first point of the time grid until a page starts the run
    pub paused: bool,
}

/// Creates a board with the page of a run that begins.
pub fn board(scene: &Scene, film: &Film, mut about: About, shown: &Shown) -> Arc<Board> {
    let Shown { run, case, from, recording, paused } = *shown;
    let initial = || scene.controls.values_from_outside(&scene.controls.memory());
    let values = from.map_or_else(initial, |checkpoint| checkpoint.controlled(scene));
    let controlled = scene.controls.controlled().into_iter().zip(values).zip(scene.controls.ranges());
    let signals = controlled.map(|((name, value), range)| {
        let (words, unit) = column::words(&name);
        SignalState { name, words, unit, value, range }
    });
    let board = Arc::new(Board::new(Opening {
        run: run.into(),
        end: scene.spans.last().map_or(0.0, |span| span.end),
        signals: signals.filter(|_| recording.is_some()).collect(),
        paused,
    }));
    let file = recording.and_then(Path::file_name).map(|name| name.to_string_lossy());
    if case {
        about.facts.insert(0, ("case".into(), run.into()));
        about.title = if about.title == run { about.title } else { format!("{run}: {}", about.title) };
    }
    let (title, settings) = (about.title.clone(), json!({ "run": run, "case": case, "recorded": file }));
    board.open(live_page(&title, &film.opening(scene, about), &settings));
    from.iter().for_each(|checkpoint| board.state(film, scene, &checkpoint.state));
    board
}

/// Returns the observer that publishes the iterations of a run on its board.
pub fn iterations(board: Arc<Board>) -> OnIteration {
    Arc::new(move |report| board.iteration(report))
}
