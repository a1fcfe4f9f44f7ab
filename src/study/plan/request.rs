//! The request for a plan, and who follows its progress.

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
    /// Budget for meshes, pilots and the run together, by the clock \[s\]
    pub budget_s: f64,
    /// Columns; those of a convergence study if empty
    pub quantities: Vec<String>,
    /// Set to stop
    pub stop: &'a Arc<AtomicBool>,
}

impl Request<'_> {
    /// Whether the plan is to end with what is known.
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
