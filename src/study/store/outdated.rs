//! Stored results that no longer count: those of other inputs than the study has now, which a later run leaves in their place.
//!
//! `outdated/<id>` holds the digest of the identity of the record that does not count. It says nothing about another record of this case, so
//! that a new result counts without it being taken away first, and an old one counts again when a run finds its inputs again.

use crate::storage::{self, DATA_LIMIT, TEXT_LIMIT};
use crate::study::store::case_files::OUTDATED;
use crate::study::store::folder::{Store, StoreError, unwritable};
use serde::Deserialize;
use std::io::ErrorKind;
use std::path::Path;

impl Store {
    /// Notes whether the stored result of a case counts: that is the one of the identity with this digest. Without a digest no stored result does.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn compare_inputs(&self, id: &str, now: Option<&str>) -> Result<(), StoreError> {
        let Some(stored) = stored_identity(&self.dir, id) else { return Ok(()) };
        let path = self.dir.join(OUTDATED).join(id);
        let done = if now == Some(stored.as_str()) {
            std::fs::remove_file(&path).or_else(|e| if e.kind() == ErrorKind::NotFound { Ok(()) } else { Err(e) })
        } else {
            std::fs::create_dir_all(self.dir.join(OUTDATED)).and_then(|()| storage::write(&path, stored.as_bytes()))
        };
        done.map_err(|e| unwritable(&path, &e))
    }
}

/// Whether the result of this identity was found to be one of other inputs than the study has.
pub fn is_outdated(dir: &Path, id: &str, identity_sha256: &str) -> bool {
    storage::read_text(&dir.join(OUTDATED).join(id), TEXT_LIMIT).is_ok_and(|noted| noted == identity_sha256)
}

/// Digest of the identity that the record of a case has; none without a record that says so.
pub fn stored_identity(dir: &Path, id: &str) -> Option<String> {
    let bytes = storage::read(&dir.join("cases").join(format!("{id}.json")), DATA_LIMIT).ok()?;
    let record: WithIdentity = serde_json::from_slice(&bytes).ok()?;
    Some(record.provenance.identity.sha256)
}

/// The part of a record that says what it was computed from.
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
        assert!(!is_outdated(dir, "a", "1"), "there is no result");
        let record = r#"{ "provenance": { "identity": { "sha256": "1" } } }"#;
        std::fs::write(dir.join("cases/a.json"), record).expect("writable");
        assert_eq!(stored_identity(dir, "a"), Some("1".into()));
        compare(Some("2"));
        assert!(is_outdated(dir, "a", "1") && !is_outdated(dir, "a", "2") && !is_outdated(dir, "b", "1"));
        compare(Some("1"));
        assert!(!is_outdated(dir, "a", "1"));
        compare(None);
        assert!(is_outdated(dir, "a", "1"));
    }
}
