//! Sources of the `controlled` signals of `durometer simulate`: a program, a recording, or a page of the live view.

use durometer::catalogue::brought_command;
use durometer::live::{Board, HandControl};
use durometer::math::units::{self, Dimension};
use durometer::scene::control::process::Process;
use durometer::scene::control::recording::{Recording, Replay};
use durometer::scene::control::{
    ControlError, Controller, ControllerRecord, Observation, Opening, Reply, SignalSetting,
};
use durometer::scene::{Checkpoint, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Flags that choose what sets the `controlled` signals.
#[derive(clap::Args)]
pub struct ControlArgs {
    /// Program that sets the `controlled` signals of the scene, by JSON lines on its standard input and output
    #[arg(long, value_name = "COMMAND")]
    pub controller: Option<String>,
    /// Time limit for an answer of the controller
    #[arg(long, value_name = "TIME", default_value = "60 s", requires = "controller")]
    controller_timeout: String,
    /// Set the `controlled` signals as a page of the live view did: a file <name>.control.csv
    #[arg(long, value_name = "FILE", conflicts_with = "controller")]
    replay: Option<PathBuf>,
    /// Let --restart continue with a controller, recording or page different from that of the saved state; the record notes from which time
    #[arg(long, requires = "restart")]
    pub other_controller: bool,
}

/// The source of the values of the controlled signals.
pub enum Source {
    /// The scene has none
    None,
    Program(Process),
    Recording(Replay),
    /// Values of a page are recorded in this file
    Page(PathBuf),
}

impl ControlArgs {
    /// Returns the source of the signals. A controller is refused if the scene has no controlled signals, and its absence if the scene has some.
    pub fn source(
        &self,
        scene: &Scene,
        page: Option<PathBuf>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Source, Box<dyn std::error::Error>> {
        let signals = scene.controls.controlled();
        let is_given = self.controller.is_some() || self.replay.is_some();
        if signals.is_empty() && is_given {
            let remedy = "drive something by { kind = \"controlled\", initial = \"0 mm\" }";
            return Err(format!("the scene leaves no signal to a controller; {remedy}").into());
        }
        if let Some(command) = &self.controller {
            let patience = positive_time("--controller-timeout", &self.controller_timeout)?;
            return Ok(Source::Program(Process::start(&brought_command(command), patience, Some(stop.clone()))?));
        }
        if let Some(file) = &self.replay {
            return Ok(Source::Recording(Replay::new(Recording::read(file, &signals)?)));
        }
        match (signals.first(), page) {
            (None, _) => Ok(Source::None),
            (Some(_), Some(file)) => Ok(Source::Page(file)),
            (Some(name), None) => Err(format!(
                "the signal {name} waits for a controller; give one: --controller \"python3 ctrl.py\", or set it by hand: --live"
            )
            .into()),
        }
    }

    /// Builds the controller of a run, which asks the source unless a page has paused the run, and its note for the record. Refused for a run that
    /// continues from the state of a run with another controller.
    pub fn controller(
        &self,
        source: Source,
        scene: &Scene,
        (from, board): (Option<&Checkpoint>, Option<&Arc<Board>>),
        stop: &Arc<AtomicBool>,
    ) -> Result<(Option<String>, Option<Chosen>), ControlError> {
        let (note, controller) = (source.note(), Chosen::new(source, board, stop));
        if let (Some(from), Some(controller), false) = (from, &controller, self.other_controller) {
            from.check_controller(scene, controller)?;
        }
        Ok((note, controller))
    }
}

impl Source {
    /// Refuses derivatives and error estimates, which repeat a run, if a page sets the signals.
    pub fn check(&self, repeats: bool) -> Result<(), String> {
        match self {
            Self::Page(_) if repeats => {
                Err("--sensitivity and --error do not go with signals that a page sets; give the signals a function of time".into())
            }
            _ => Ok(()),
        }
    }

    /// Returns the note for the record on signals that are not functions in the scene.
    fn note(&self) -> Option<String> {
        match self {
            Self::None | Self::Program(_) => None,
            Self::Recording(Replay { sha256, extent, .. }) => Some(format!(
                "the controlled signals have the values of a recording of {extent}, which hold to the end (SHA-256 {sha256})"
            )),
            Self::Page(file) => {
                let file = file.display();
                Some(format!(
                    "the controlled signals could be set by hand, and what was set is recorded; --replay {file} sets them again"
                ))
            }
        }
    }

    /// Returns the file that records what a page sets.
    pub fn page(&self) -> Option<&Path> {
        match self {
            Self::Page(file) => Some(file),
            _ => None,
        }
    }
}

/// Parses the value of a flag that must be a positive time.
pub fn positive_time(flag: &str, text: &str) -> Result<Duration, String> {
    let seconds = units::parse(text, Dimension::TIME).ok().filter(|s| *s > 0.0 && *s < 1e6);
    let remedy = "write for example \"10 s\"";
    seconds.map(Duration::from_secs_f64).ok_or_else(|| format!("{flag} \"{text}\" is no time; {remedy}"))
}

/// The controller of a run: it waits while a page pauses the run, then asks the source of the signals.
pub struct Chosen {
    inner: Option<Box<dyn Controller>>,
    live: Option<(Arc<Board>, Arc<AtomicBool>)>,
    /// Time that the run has waited for answers and for pages
    pub waited: Duration,
}

impl Chosen {
    /// Builds the controller of a run; `None` if no signal is set and no page can pause the run.
    fn new(source: Source, board: Option<&Arc<Board>>, stop: &Arc<AtomicBool>) -> Option<Self> {
        let inner: Option<Box<dyn Controller>> = match (source, board) {
            (Source::Program(process), _) => Some(Box::new(process)),
            (Source::Recording(replay), _) => Some(Box::new(replay)),
            (Source::Page(file), Some(board)) => Some(Box::new(HandControl::new(board.clone(), &file))),
            (Source::None | Source::Page(_), _) => None,
        };
        let live = board.map(|board| (board.clone(), stop.clone()));
        (inner.is_some() || live.is_some()).then_some(Self { inner, live, waited: Duration::ZERO })
    }

    /// Asks the source of the signals, if there is one, and returns its answer.
    fn ask<T>(&mut self, question: impl FnOnce(&mut Box<dyn Controller>) -> T) -> Option<T> {
        let start = Instant::now();
        let answer = self.inner.as_mut().map(question);
        self.waited += start.elapsed();
        answer
    }
}

impl Controller for Chosen {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        self.ask(|inner| inner.begin(opening)).unwrap_or(Ok(()))
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        let start = Instant::now();
        if let Some((board, stop)) = &self.live {
            board.pause(stop);
        }
        self.waited += start.elapsed();
        self.ask(|inner| inner.step(observation, signals)).unwrap_or_else(|| Ok(Reply::default()))
    }

    fn identity(&self) -> Option<String> {
        self.inner.as_ref()?.identity()
    }

    fn would_set(&self, initial: &[f64], set: &[SignalSetting]) -> Option<bool> {
        self.inner.as_ref()?.would_set(initial, set)
    }

    fn end(&mut self, row: &[f64], status: &str) {
        self.inner.iter_mut().for_each(|inner| inner.end(row, status));
    }
}

/// Returns a note on what sets the signals, with the time from which on it applies if another controller set them before.
pub fn since(controllers: &[ControllerRecord], note: String) -> String {
    match controllers {
        [_, .., last] => format!("from t = {} s on {note}", last.from_t_s),
        _ => note,
    }
}

/// Returns the file in which the values of a page are recorded.
pub fn recording(out: &Path, name: &str) -> PathBuf {
    out.join(format!("{name}.control.csv"))
}
