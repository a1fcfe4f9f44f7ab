//! Stored results that no longer count, because they have other inputs than the study has now; later runs leave them in their place.
//!
//! `study.json` states the inputs of the cases, apart from the mesh. In addition `outdated/<id>` holds the digest of the identity of a record that does
//! not count. It does not affect other records of this case, so that a new result counts without the file being removed first, and an old one counts
//! again when a run finds its inputs again.

use crate::report::error::ReportError;
use crate::report::files::json;
use crate::storage::{self, DATA_LIMIT, TEXT_LIMIT};
use crate::study::store::case_files::{OUTDATED, check_in, ids};
use crate::study::store::folder::{Store, StoreError, unwritable};
use crate::study::store::record::{CaseRecord, StudyRecord};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

impl Store {
    /// Records whether the stored result of a case counts, which it does if its identity has the digest `now`. Without a digest no stored result
    /// counts.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn compare_inputs(&self, id: &str, now: Option<&str>) -> Result<(), StoreError> {
        let Some(stored) = stored_identity(&self.dir, id) else { return Ok(()) };
        let path = self.dir.join(OUTDATED).join(id);
        let done = if now == Some(stored.as_str()) {
            forget_note(&self.dir, id)
        } else {
            std::fs::create_dir_all(self.dir.join(OUTDATED)).and_then(|()| storage::write(&path, stored.as_bytes()))
        };
        done.map_err(|e| unwritable(&path, &e))
    }
}

/// Removes the mark of a case, if there is one.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn forget_note(dir: &Path, id: &str) -> std::io::Result<()> {
    match std::fs::remove_file(dir.join(OUTDATED).join(id)) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Whether a result has other inputs than the study, or was found to have.
pub fn is_outdated(dir: &Path, study: &StudyRecord, record: &CaseRecord) -> bool {
    study.is_of_others(record) || is_noted(dir, &record.id, &record.provenance.identity.sha256)
}

/// Whether the result with this identity was found to have other inputs.
fn is_noted(dir: &Path, id: &str, identity_sha256: &str) -> bool {
    storage::read_text(&dir.join(OUTDATED).join(id), TEXT_LIMIT).is_ok_and(|noted| noted == identity_sha256)
}

/// Digest of the identity in the record of a case; `None` without a record that contains one.
pub fn stored_identity(dir: &Path, id: &str) -> Option<String> {
    let bytes = storage::read(&dir.join("cases").join(format!("{id}.json")), DATA_LIMIT).ok()?;
    let record: WithIdentity = serde_json::from_slice(&bytes).ok()?;
    Some(record.provenance.identity.sha256)
}

/// Refuses a summary of results other than the present ones in the folder. Records that were removed to save space, and summaries of earlier versions,
/// are not checked.
///
/// # Errors
///
/// A case that was computed since, or whose result no longer counts.
pub fn check_summary(dir: &Path, study: &StudyRecord) -> Result<(), ReportError> {
    let path = dir.join("summary.json");
    let Some(summary) = json::<Summarised>(&path)? else { return Ok(()) };
    let listed: BTreeMap<&str, &str> =
        summary.cases.iter().map(|c| (c.id.as_str(), c.record_sha256.as_str())).collect();
    if listed.values().all(|digest| digest.is_empty()) {
        return Ok(());
    }
    let is_other = |id: &&str| match (check_in(dir, id), listed.get(id)) {
        (Ok(record), Some(of)) => *of != record.provenance.record_sha256 || is_outdated(dir, study, &record),
        (Ok(record), None) => !is_outdated(dir, study, &record),
        (Err(_), _) => false,
    };
    match ids(study).into_iter().find(is_other) {
        Some(case) => Err(ReportError::OutdatedSummary { path, dir: dir.into(), case: case.into() }),
        None => Ok(()),
    }
}

/// The part of a summary that says from which records it was made.
#[derive(Deserialize)]
struct Summarised {
    cases: Vec<SummarisedCase>,
}

#[derive(Deserialize)]
struct SummarisedCase {
    id: String,
    #[serde(default)]
    record_sha256: String,
}

/// The part of a record that identifies its inputs.
#[derive(Deserialize)]
struct WithIdentity {
    provenance: OnlyIdentity,
}

#[derive(Deserialize)]
struct OnlyIdentity {
    #[serde(default)]
    identity: OnlyDigest,
}

#[derive(Deserialize, Default)]
struct OnlyDigest {
    sha256: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_about_one_result_only() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let dir = folder.path();
        let store = Store::open(dir).unwrap_or_else(|e| panic!("{e}"));
        let compare = |now| store.compare_inputs("a", now).unwrap_or_else(|e| panic!("{e}"));
        compare(None);
        assert!(!is_noted(dir, "a", "1"), "there is no result");
        let record = r#"{ "provenance": { "identity": { "sha256": "1" } } }"#;
        std::fs::write(dir.join("cases/a.json"), record).expect("writable");
        assert_eq!(stored_identity(dir, "a"), Some("1".into()));
        compare(Some("2"));
        assert!(is_noted(dir, "a", "1") && !is_noted(dir, "a", "2") && !is_noted(dir, "b", "1"));
        compare(Some("1"));
        assert!(!is_noted(dir, "a", "1"));
        compare(None);
        assert!(is_noted(dir, "a", "1"));
    }
}
