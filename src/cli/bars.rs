//! Progress bars, one per running case, with the time left.

use durometer::scene::Progress;
use durometer::study::run::runner::Watch;
use durometer::study::store::record::CaseRecord;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::collections::HashMap;
use std::io::Write;
use std::sync::{Mutex, PoisonError};

const TICKS: u64 = 1000;

/// Bars on a terminal, plain lines elsewhere; silent with `--json`.
pub struct Bars {
    multi: MultiProgress,
    bars: Mutex<HashMap<String, ProgressBar>>,
    /// Finished cases of a study, below the running ones
    total: Option<ProgressBar>,
    silent: bool,
}

impl Bars {
    pub fn new(silent: bool) -> Self {
        Self { multi: MultiProgress::new(), bars: Mutex::new(HashMap::new()), total: None, silent }
    }

    /// Bars with a line for all cases.
    pub fn of(cases: usize, silent: bool) -> Self {
        let mut bars = Self::new(silent);
        if !silent {
            let style = ProgressStyle::with_template("{prefix:32} {bar:30} {pos}/{len} cases  {elapsed} so far");
            let total = bars.multi.add(ProgressBar::new(cases as u64)).with_prefix("all");
            total.set_style(style.expect("the template is valid"));
            bars.total = Some(total);
        }
        bars
    }

    fn line(&self, text: &str) {
        if self.silent {
            return;
        }
        if self.multi.is_hidden() {
            writeln!(std::io::stderr(), "{text}").ok();
        } else {
            self.multi.println(text).ok();
        }
    }

    fn bars(&self) -> std::sync::MutexGuard<'_, HashMap<String, ProgressBar>> {
        self.bars.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Watch for Bars {
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
    }

    fn progress(&self, case: &str, progress: Progress) {
        if let Some(bar) = self.bars().get(case) {
            bar.set_position((TICKS as f64 * progress.t / progress.end) as u64);
            bar.set_message(format!("t = {:.3} s", progress.t));
        }
    }

    fn finished(&self, record: &CaseRecord, skipped: bool) {
        if let Some(bar) = self.bars().remove(&record.id) {
            bar.finish_and_clear();
        }
        if let Some(total) = &self.total {
            total.inc(1);
            if total.length() == Some(total.position()) {
                total.finish_and_clear();
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
            record.newton_iterations,
            record.status
        ));
        if let Some(detail) = &record.status_detail {
            self.line(&format!("     {detail}"));
        }
    }
}
