//! Progress bars, one per running case, with the time left.

use durometer::live::{Access, Relay};
use durometer::math::threads::locked;
use durometer::scene::Progress;
use durometer::study::run::runner::Watch;
use durometer::study::store::record::CaseRecord;
use durometer::study::time_left::TimeLeft;
use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressStyle};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

const TICKS: u64 = 1000;

/// Bars on a terminal, plain lines elsewhere; silent with `--json`.
pub struct Bars {
    multi: MultiProgress,
    bars: Mutex<HashMap<String, ProgressBar>>,
    /// The line of the finished cases of a study, below the running ones
    total: Option<Total>,
    silent: bool,
    /// Shows a running case in a browser
    pub relay: Option<Arc<Relay>>,
}

/// The line for all cases together.
struct Total {
    bar: ProgressBar,
    left: Mutex<Left>,
}

/// The remaining time of all cases. It is known once their meshes exist, that is, when the first case begins or is taken from the store.
enum Left {
    Unknown(Box<dyn FnOnce() -> TimeLeft + Send>),
    Known {
        left: TimeLeft,
        shown: Instant,
    },
    /// Placeholder while the estimate is being made
    Begins,
}

impl Total {
    fn begin(&self) {
        let mut left = locked(&self.left);
        *left = match std::mem::replace(&mut *left, Left::Begins) {
            Left::Unknown(make) => Left::Known { left: make(), shown: Instant::now() },
            known => known,
        };
    }

    /// Applies a change to the estimate, and shows the time at most once a second.
    fn change(&self, change: impl FnOnce(&mut TimeLeft)) {
        if let Left::Known { left, shown } = &mut *locked(&self.left) {
            change(left);
            if shown.elapsed() >= Duration::from_secs(1) {
                *shown = Instant::now();
                let words = |s: f64| format!("about {} left", HumanDuration(Duration::from_secs_f64(s.ceil())));
                self.bar.set_message(left.seconds().map_or_else(String::new, words));
            }
        }
    }
}

impl Bars {
    pub fn new(silent: bool) -> Self {
        Self { multi: MultiProgress::new(), bars: Mutex::new(HashMap::new()), total: None, silent, relay: None }
    }

    /// Creates bars with a line for all cases; `left` is called only on a terminal.
    pub fn of(cases: usize, silent: bool, left: impl FnOnce() -> TimeLeft + Send + 'static) -> Self {
        let mut bars = Self::new(silent);
        if !silent && !bars.multi.is_hidden() {
            let style = ProgressStyle::with_template("{prefix:32} {bar:30} {pos}/{len} cases  {elapsed} so far  {msg}");
            let bar = bars.multi.add(ProgressBar::new(cases as u64)).with_prefix("all");
            bar.set_style(style.expect("the template is valid"));
            bars.total = Some(Total { bar, left: Mutex::new(Left::Unknown(Box::new(left))) });
        }
        bars
    }

    fn line(&self, text: &str) {
        if self.silent {
            return;
        }
        if self.multi.is_hidden() {
            tell!("{text}");
        } else {
            self.multi.println(text).ok();
        }
    }

    fn bars(&self) -> MutexGuard<'_, HashMap<String, ProgressBar>> {
        locked(&self.bars)
    }
}

impl Watch for Bars {
    fn live(&self) -> Option<Access> {
        self.relay.as_ref().map(|relay| relay.access().clone())
    }

    fn serves(&self, case: &str, port: Option<u16>) {
        self.relay.iter().for_each(|relay| relay.follow(case, port));
    }

    fn meshing(&self, case: &str, line: &str) {
        self.line(&format!("{case}: mesher: {line}"));
    }

    fn note(&self, case: &str, text: &str) {
        self.line(&format!("{case}: {text}"));
    }

    fn started(&self, case: &str) {
        if self.silent {
            return;
        }
        let style = ProgressStyle::with_template("{prefix:32} {bar:30} {percent:>3} %  {eta:>4} left  {msg}");
        let bar = self.multi.insert(0, ProgressBar::new(TICKS)).with_prefix(case.to_string());
        bar.set_style(style.expect("the template is valid"));
        self.bars().insert(case.into(), bar);
        if let Some(total) = &self.total {
            total.begin();
        }
    }

    fn progress(&self, case: &str, progress: Progress) {
        if let Some(bar) = self.bars().get(case) {
            bar.set_position((TICKS as f64 * progress.t / progress.end) as u64);
            bar.set_message(format!("t = {:.3} s", progress.t));
        }
        if let Some(total) = &self.total {
            total.change(|left| left.progress(case, progress.t / progress.end));
        }
    }

    fn finished(&self, record: &CaseRecord, skipped: bool) {
        if let Some(bar) = self.bars().remove(&record.id) {
            bar.finish_and_clear();
        }
        if let Some(total) = &self.total {
            total.begin();
            total.change(|left| left.finish(record, skipped));
            total.bar.inc(1);
            if total.bar.length() == Some(total.bar.position()) {
                total.bar.finish_and_clear();
            }
        }
        let how = if skipped { "kept" } else { "done" };
        self.line(&format!(
            "{how} {:32} {:>7} cells {:6} {:>8.2} s  {:>4} steps {:>5} iterations  {}",
            record.id,
            record.mesh.cells,
            record.formulation,
            record.wall_s,
            record.steps,
            record.all_iterations(),
            record.status
        ));
        if let Some(detail) = &record.status_detail {
            self.line(&format!("     {detail}"));
        }
    }
}
