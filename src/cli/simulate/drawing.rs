//! Pictures of a run of `durometer simulate`: fields for ParaView, and the page that shows the motion.

use super::earlier::is_of_run;
use durometer::live::{self, Board, Listener, Served, Shown};
use durometer::math::stopwatch::{Spent, Stopwatch};
use durometer::report::files;
use durometer::report::viewer::film::Film;
use durometer::report::viewer::page::page;
use durometer::report::viewer::shape::Limits;
use durometer::scene::column::words;
use durometer::scene::output::ScheduleSpec;
use durometer::scene::{Checkpoint, ErrorEstimate, Run, Scene};
use durometer::study::store::fields::{Fields, USUAL};
use durometer::study::store::record::CaseRecord;
use durometer::study::view;
use durometer::system::State;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The fields that a run writes at the scheduled points of the time grid, and the states for its page.
pub struct Drawing {
    fields: Option<Fields>,
    schedule: ScheduleSpec,
    film: Option<Film>,
    /// The film is written as a page at the end
    shown: bool,
    /// Receives every state as it is computed
    board: Option<Arc<Board>>,
    /// `<name>.html`
    page: PathBuf,
    /// Points of the grid so far
    number: usize,
    /// Time of the last point \[s\]
    past: Option<f64>,
    /// Time that the page has taken so far
    spent: Spent,
}

impl Drawing {
    /// Sets up the fields that the scene or `--vtu` asks for; a continued run continues their numbering and collections.
    pub fn new(
        (out, name): (&Path, &str),
        (vtu, shown, live): (bool, bool, bool),
        scene: &Scene,
        from: Option<&Checkpoint>,
    ) -> Self {
        let chosen = scene.spec.output.fields.as_ref();
        let (what, schedule) = match chosen {
            Some(chosen) => (chosen.what.as_slice(), chosen.schedule()),
            None => (&USUAL[..], ScheduleSpec::default()),
        };
        let mut fields = (vtu || chosen.is_some()).then(|| Fields::new(out, name, what));
        let before = from.filter(|from| is_of_run(out, name, scene, from));
        if let (Some(fields), Some(checkpoint)) = (&mut fields, before) {
            fields.go_on(scene, checkpoint.state.t);
        }
        let (number, past) = from.map_or((0, None), |c| (c.recorded(), Some(c.state.t)));
        let mut film = (shown || live).then(|| Film::new(scene, what, &Limits::USUAL));
        if let (Some(film), Some(checkpoint)) = (&mut film, from) {
            film.add(scene, &checkpoint.state);
        }
        Self {
            fields,
            schedule,
            film,
            shown,
            board: None,
            page: out.join(format!("{name}.html")),
            number,
            past,
            spent: Spent::default(),
        }
    }

    /// Also shows the states in a live view, which is served until the second value is dropped.
    pub fn follow(&mut self, scene: &Scene, listener: Listener, shown: &Shown) -> Option<(Arc<Board>, Option<Served>)> {
        let film = self.film.as_ref()?;
        let board = live::board(scene, film, view::about_before(scene, shown.run), shown);
        self.board = Some(board.clone());
        Some((board.clone(), crate::live::serve(listener, board)))
    }

    pub fn add(&mut self, scene: &Scene, state: &State) {
        if let Some(fields) = self.fields.as_mut().filter(|_| self.schedule.due(self.past, state.t)) {
            fields.add(scene, state, self.number);
        }
        let stopwatch = Stopwatch::start();
        if let Some(film) = &mut self.film {
            film.add(scene, state);
            self.board.iter().for_each(|board| board.state(film, scene, state));
        }
        self.spent += stopwatch.spent();
        (self.number, self.past) = (self.number + 1, Some(state.t));
    }

    /// Finishes the fields and returns the film.
    pub fn finish(self) -> (Drawn, Option<Film>) {
        let fields = self.fields.map(|fields| (fields.collection(), fields.finish()));
        let mut drawn = Drawn { page: self.page, shown: false, collection: None, failure: None, spent: self.spent };
        match fields {
            Some((collection, Ok(spent))) => {
                drawn.collection = Some(collection);
                drawn.spent += spent;
            }
            Some((_, Err(why))) => drawn.failure = Some(why.into()),
            None => {}
        }
        (drawn, self.film.filter(|_| self.shown))
    }
}

/// The pictures of a run that has ended.
pub struct Drawn {
    page: PathBuf,
    shown: bool,
    collection: Option<PathBuf>,
    pub failure: Option<Box<dyn std::error::Error>>,
    /// Time that drawing took during the run
    pub spent: Spent,
}

impl Drawn {
    /// Writes the page, with the shares of the cells in the estimated errors.
    pub fn show(
        &mut self,
        film: Option<Film>,
        scene: &Scene,
        (run, record): (&Run, &CaseRecord),
        errors: Option<&ErrorEstimate>,
    ) {
        let Some(mut film) = film else { return };
        let mut about = view::about(scene, run, record);
        for shares in errors.iter().flat_map(|found| &found.cells) {
            let (words, unit) = words(&shares.column);
            film.add_of_cells(&format!("share in the error of the {words}"), unit, &shares.size);
        }
        if errors.is_none_or(|found| found.cells.is_empty()) {
            about.absent.push(("share of each cell in an error".into(), "--error COLUMN --error-cells".into()));
        }
        let title = about.title.clone();
        let html = page(&title, &[film.finish(scene, about)]);
        match files::write(&self.page, html.as_bytes()) {
            Ok(()) => self.shown = true,
            Err(why) => self.failure = self.failure.take().or(Some(why.into())),
        }
    }

    pub fn print(&self) {
        if self.shown {
            say!("view:    {} (open it in a browser)", self.page.display());
        }
        if let Some(collection) = &self.collection {
            say!("fields:  {} (open it in ParaView)", collection.display());
        }
    }
}
