//! The part of `summary.json` that two results are compared by.

use crate::report::{ReportError, files};
use crate::study::claim::Claim;
use crate::study::store::record::{Quantity, StudyRecord};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A result as it was stored.
#[derive(Clone, Debug, Deserialize)]
pub struct StoredSummary {
    pub study: String,
    pub kind: String,
    pub tolerance: f64,
    pub cases: Vec<StoredCase>,
    pub verdict: String,
    pub version: String,
    /// Absent in results of earlier versions
    #[serde(default)]
    pub claims: Vec<Claim>,
    /// Variant → judged quantities, of `study.json`
    #[serde(skip)]
    pub quantities: BTreeMap<String, Vec<Quantity>>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredCase {
    pub id: String,
    #[serde(default)]
    pub variant: String,
    pub status: String,
    pub mesh: StoredMesh,
    #[serde(default)]
    pub cpu_s: f64,
    #[serde(default)]
    pub probes: BTreeMap<String, StoredPeak>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredMesh {
    pub cells: usize,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredPeak {
    pub peak: f64,
}

impl StoredSummary {
    /// Reads `summary.json` and the quantities of `study.json` in a folder.
    ///
    /// # Errors
    /// Files that are missing, cannot be read, or are no results of a study.
    pub fn read(dir: &Path) -> Result<Self, ReportError> {
        let path = dir.join("summary.json");
        let mut summary: Self = files::json(&path)?.ok_or(ReportError::NotAStudy { path })?;
        let study: Option<StudyRecord> = files::json(&dir.join("study.json"))?;
        summary.quantities = study.map(|s| s.quantities).unwrap_or_default();
        Ok(summary)
    }

    /// The quantity in a column of a case, where the study judges it.
    pub fn judged(&self, case: &StoredCase, column: &str) -> Option<&Quantity> {
        self.quantities.get(&case.variant)?.iter().find(|q| q.name == column)
    }
}
