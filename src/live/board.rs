//! The board of a live view: the newest values of a run for its clients, and their commands to the run.

use super::news::{Extent, News, Seen, SignalState};
use super::thinned::Thinned;
use crate::math::threads::locked;
use crate::math::units::within;
use crate::report::viewer::film::Film;
use crate::report::viewer::frame::Frame;
use crate::report::viewer::limits::ROWS;
use crate::scene::Scene;
use crate::solve::IterationReport;
use crate::system::State;
use serde::Deserialize;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Number of iterations that are kept for slow clients.
const ITERATIONS: usize = 256;
/// Time after which a paused run resumes once no page is open any more.
const ALONE: Duration = Duration::from_secs(10);
/// Interval between checks of the stop flag.
const LOOK: Duration = Duration::from_millis(50);
/// Time that clients are given to receive the end of a run that was stopped.
const MOMENT: Duration = Duration::from_millis(300);
/// Largest number of requested steps that may be pending.
const STEPS: usize = 1000;

/// Facts about a run before its first step.
#[derive(Default)]
pub struct Opening {
    /// Distinguishes runs that are shown at the same address
    pub run: String,
    /// End of the last stage \[s\]
    pub end: f64,
    /// Signals that a page may set
    pub signals: Vec<SignalState>,
    /// Wait at the first point of the time grid until a page starts the run
    pub paused: bool,
}

/// A command from a page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Command {
    Pause,
    Resume,
    /// Take one step of the time grid, and pause
    Step,
    Set {
        signal: String,
        value: f64,
    },
}

/// A recorded row with its number in the run.
pub(super) type Row = (usize, Arc<[f64]>);

/// The state of a run that its clients see.
struct Now {
    /// Increases with every change
    version: u64,
    page: Arc<str>,
    /// Frames with their numbers in the run: those of the final page, and the newest
    frames: Vec<(usize, Arc<Frame>)>,
    rows: Thinned<Arc<[f64]>>,
    /// Iterations, numbered from the start of the run, of which the last ones are kept
    iterations: VecDeque<(u64, IterationReport)>,
    news: News,
    /// Steps to take before the run pauses again
    steps: usize,
    clients: usize,
    /// When the last client left
    left: Option<Instant>,
}

/// Connects a run with its clients.
pub struct Board {
    now: Mutex<Now>,
    changed: Condvar,
}

impl Board {
    pub fn new(opening: Opening) -> Self {
        let Opening { run, end, signals, paused } = opening;
        let news = News { run, end, signals, paused, ..News::default() };
        let now = Now {
            version: 1,
            page: "".into(),
            frames: vec![],
            rows: Thinned::new(ROWS),
            iterations: VecDeque::new(),
            news,
            steps: 0,
            clients: 0,
            left: None,
        };
        Self { now: Mutex::new(now), changed: Condvar::new() }
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        // A panic in the thread of a client leaves nothing inconsistent
        locked(&self.now)
    }

    fn change<T>(&self, change: impl FnOnce(&mut Now) -> T) -> T {
        let mut now = self.now();
        now.version += 1;
        let out = change(&mut now);
        drop(now);
        self.changed.notify_all();
        out
    }

    /// Sets the page that a client gets first.
    pub fn open(&self, page: String) {
        self.change(|now| now.page = page.into());
    }

    /// Publishes a state of the run that has been added to the film.
    pub fn state(&self, film: &Film, scene: &Scene, state: &State) {
        let mut frames: Vec<(usize, Arc<Frame>)> = film.kept().map(|(k, frame)| (k, frame.clone())).collect();
        let number = film.count().saturating_sub(1);
        if frames.last().is_none_or(|(last, _)| *last != number) {
            frames.push((number, Arc::new(film.frame(scene, state))));
        }
        self.change(|now| {
            now.news.t = state.t;
            (now.news.states.stride, now.news.states.count) = (film.stride(), film.count());
            now.frames = frames;
        });
    }

    /// Publishes a recorded row.
    pub fn row(&self, row: &[f64]) {
        self.change(|now| {
            now.rows.push(row.into());
            (now.news.rows.stride, now.news.rows.count) = (now.rows.stride, now.rows.count);
        });
    }

    /// Publishes an iteration of Newton's method.
    pub fn iteration(&self, report: &IterationReport) {
        self.change(|now| {
            let number = now.iterations.back().map_or(0, |(number, _)| number + 1);
            now.iterations.push_back((number, *report));
            if now.iterations.len() > ITERATIONS {
                now.iterations.pop_front();
            }
        });
    }

    /// Publishes the time \[s\] of an accepted step.
    pub fn accepted(&self, t: f64) {
        self.change(|now| now.news.t = t);
    }

    /// Waits while the run is paused, until it resumes or `stop` is set.
    pub fn pause(&self, stop: &AtomicBool) {
        let mut now = self.now();
        while now.news.paused && !stop.load(Ordering::Relaxed) {
            if now.steps > 0 {
                now.steps -= 1;
                break;
            }
            if !now.news.waiting {
                (now.news.waiting, now.version) = (true, now.version + 1);
                self.changed.notify_all();
            }
            if now.clients == 0 && now.left.is_some_and(|left| left.elapsed() >= ALONE) {
                now.news.paused = false;
            }
            now = self.changed.wait_timeout(now, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
        (now.news.waiting, now.version) = (false, now.version + 1);
        drop(now);
        self.changed.notify_all();
    }

    /// Returns the requested values, in the order of the signals.
    pub(super) fn values(&self) -> Vec<f64> {
        self.now().news.signals.iter().map(|s| s.value).collect()
    }

    /// Publishes the end of the run.
    pub fn end(&self, status: &str, detail: Option<String>) {
        self.change(|now| {
            now.news.ended = Some((status.into(), detail));
            (now.news.paused, now.news.waiting) = (false, false);
        });
    }

    /// Waits until no client is connected any more, at most for `patience`; if `stop` is set, only for a moment, so that clients receive the end.
    pub fn farewell(&self, patience: Duration, stop: &AtomicBool) {
        let start = Instant::now();
        let patience = || if stop.load(Ordering::Relaxed) { MOMENT.min(patience) } else { patience };
        let mut now = self.now();
        while now.clients > 0 && start.elapsed() < patience() {
            now = self.changed.wait_timeout(now, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Carries out a command of a client; a refusal returns the reason.
    pub(super) fn obey(&self, command: Command) -> Result<(), String> {
        self.change(|now| {
            let News { paused, signals, ended, .. } = &mut now.news;
            if ended.is_some() {
                return Err("the run has ended".into());
            }
            match command {
                Command::Pause => (*paused, now.steps) = (true, 0),
                Command::Resume => (*paused, now.steps) = (false, 0),
                Command::Step => {
                    now.steps = if *paused { (now.steps + 1).min(STEPS) } else { 0 };
                    *paused = true;
                }
                Command::Set { signal, value } => {
                    let Some(known) = signals.iter_mut().find(|s| s.name == signal) else {
                        return Err(format!("there is no signal \"{signal}\" that a page may set"));
                    };
                    if !value.is_finite() || known.range.is_some_and(|range| !within(value, range)) {
                        return Err(format!("{value} is not within the range of {signal}"));
                    }
                    known.value = value;
                }
            }
            Ok(())
        })
    }

    pub(super) fn page(&self) -> Arc<str> {
        self.now().page.clone()
    }

    pub(super) fn frame(&self, number: usize) -> Option<Arc<Frame>> {
        let now = self.now();
        now.frames.binary_search_by_key(&number, |(k, _)| *k).ok().map(|k| now.frames[k].1.clone())
    }

    /// Returns the rows from number `first` on, each with its number, and the extent of those that can currently be requested.
    pub(super) fn rows(&self, first: usize) -> (Extent, Vec<Row>) {
        let now = self.now();
        (now.news.rows, now.rows.from(first).cloned().collect())
    }

    /// Registers a client that follows the run.
    pub(super) fn join(&self) {
        self.change(|now| now.clients += 1);
    }

    pub(super) fn leave(&self) {
        self.change(|now| (now.clients, now.left) = (now.clients.saturating_sub(1), Some(Instant::now())));
    }

    /// Waits for something that the client has not seen, at most for `patience`; `None` if nothing came.
    pub(super) fn news(&self, seen: &mut Seen, patience: Duration) -> Option<News> {
        let start = Instant::now();
        let mut now = self.now();
        while now.version == seen.version {
            let left = patience.checked_sub(start.elapsed())?;
            now = self.changed.wait_timeout(now, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        seen.version = now.version;
        let first = seen.iteration;
        let new: Vec<_> = now.iterations.iter().filter(|(number, _)| *number >= first).copied().collect();
        seen.iteration = now.iterations.back().map_or(0, |(number, _)| number + 1);
        Some(News { iterations: new, ..now.news.clone() })
    }
}
