//! The request for a plan, and the observer of its progress.

use crate::scene::Progress;
use crate::study::store::record::CaseRecord;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Request for a plan.
pub struct Request<'a> {
    pub file: PathBuf,
    pub changes: Vec<(String, toml::Value)>,
    /// Largest error of a peak \[–\]
    pub tolerance: f64,
    /// Wall-time budget for meshes, pilots and the run together \[s\]
    pub budget_s: f64,
    /// Columns; if empty, those of a convergence study
    pub quantities: Vec<String>,
    /// Flag that stops the plan when set
    pub stop: &'a Arc<AtomicBool>,
}

impl Request<'_> {
    /// Whether the plan has to end with what is known.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Observer of a plan in progress.
pub trait PlanWatch {
    fn line(&self, line: &str);
    fn started(&self, name: &str);
    fn progress(&self, name: &str, progress: Progress);
    fn finished(&self, record: &CaseRecord);
}
