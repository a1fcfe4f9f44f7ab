//! The files of a case in a folder of results: which of them exist, and whether they are those that were stored together.

use crate::scene::FileDigest;
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::store::other_build::explain;
use crate::study::store::placing::{settle, settle_all};
use crate::study::store::record::{CaseRecord, StudyRecord};
use crate::study::store::seal;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub use crate::study::store::names::{ENDS, MOST_BYTES, OUTDATED, PAGE, SEARCH, STATES, is_ambiguous, parts_of};

/// A folder that does not hold results of a study, or cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("{}: there is no such file; give a folder that `durometer run STUDY` has written", path.display())]
    NotAStudy { path: PathBuf },
    #[error("{}: it cannot be read: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    #[error("{}: it is not the record of a study: {reason}; run the study again to write it, results are kept", path.display())]
    Malformed { path: PathBuf, reason: String },
}

/// A file that differs from the stored one, and the reason.
#[derive(serde::Serialize, Clone, Debug, PartialEq, Eq)]
pub struct Unsound {
    /// Path relative to the folder of the results
    pub file: String,
    pub fact: String,
}

/// Reads the study of a folder of results.
pub fn study(dir: &Path) -> Result<StudyRecord, FolderError> {
    let path = dir.join("study.json");
    let text = match storage::read(&path, DATA_LIMIT) {
        Ok(text) => text,
        Err(e) if storage::is_absent(&e) => return Err(FolderError::NotAStudy { path }),
        Err(e) => return Err(FolderError::Unreadable { path, reason: e.to_string() }),
    };
    serde_json::from_slice(&text).map_err(|e| FolderError::Malformed { path, reason: e.to_string() })
}

/// The ids of all cases of a study.
pub fn ids(study: &StudyRecord) -> BTreeSet<&str> {
    study.families.iter().flat_map(|f| &f.cases).map(String::as_str).collect()
}

/// The files in the folder of the cases, by id and then suffix, and the names of all other files.
#[derive(Default)]
pub struct CaseFiles {
    pub of_cases: BTreeMap<String, BTreeSet<&'static str>>,
    pub others: Vec<String>,
}

impl CaseFiles {
    pub fn read(dir: &Path, known: &BTreeSet<&str>) -> Result<Self, FolderError> {
        settle_all(dir);
        let path = dir.join("cases");
        let unreadable = |e: std::io::Error| FolderError::Unreadable { path: path.clone(), reason: e.to_string() };
        let mut out = Self::default();
        for entry in std::fs::read_dir(&path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            // A symbolic link counts as the file to which it leads
            let is_file = std::fs::metadata(entry.path()).is_ok_and(|kind| kind.is_file());
            match parts_of(&name, known).filter(|_| is_file) {
                Some((id, end)) => drop(out.of_cases.entry(id.into()).or_default().insert(end)),
                None => out.others.push(name),
            }
        }
        out.others.sort();
        Ok(out)
    }
}

/// Reads the record of a case from files given by their suffixes, if all of them are intact.
pub fn check(id: &str, read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>) -> Result<CaseRecord, Vec<Unsound>> {
    let unsound = |end: &str, fact: String| Unsound { file: format!("cases/{id}.{end}"), fact };
    let record = read("json").map_err(|e| e.to_string()).and_then(|bytes| {
        let record: CaseRecord = serde_json::from_slice(&bytes).map_err(|e| explain(&bytes, &e))?;
        match String::from_utf8_lossy(&bytes) {
            _ if record.id != id => Err(format!("it is the record of the case {}", record.id)),
            text if !seal::is_intact(&text) => Err("its contents are not those that were stored".into()),
            _ => Ok(record),
        }
    });
    let record = record.map_err(|fact| vec![unsound("json", fact)])?;
    let wrong = |FileDigest { file, sha256: stored }: &FileDigest| {
        let end = file.strip_prefix(id).and_then(|rest| rest.strip_prefix('.'));
        let Some(end) = end.filter(|end| ENDS.contains(end)) else {
            return Some(unsound("json", format!("it names the file {file}, which is none of this case")));
        };
        match read(end).map(sha256) {
            Ok(found) if found == *stored => None,
            Ok(_) => Some(unsound(end, "its contents are not those that were stored with the record".into())),
            Err(e) => Some(unsound(end, e.to_string())),
        }
    };
    let wrong: Vec<Unsound> = record.provenance.results.iter().filter_map(wrong).collect();
    if wrong.is_empty() { Ok(record) } else { Err(wrong) }
}

/// Reads the record of a case in a folder of results, if all of its files are intact.
pub fn check_in(dir: &Path, id: &str) -> Result<CaseRecord, Vec<Unsound>> {
    settle(dir, id);
    check(id, &|end| storage::read(&dir.join("cases").join(format!("{id}.{end}")), DATA_LIMIT))
}

/// The record of a case as it was stored, whatever has happened to its other files; `None` if there is no intact record of this case.
pub fn sealed_record(dir: &Path, id: &str) -> Option<CaseRecord> {
    let bytes = storage::read(&dir.join("cases").join(format!("{id}.json")), DATA_LIMIT).ok()?;
    let record: CaseRecord = serde_json::from_slice(&bytes).ok()?;
    (record.id == id && seal::is_intact(&String::from_utf8_lossy(&bytes))).then_some(record)
}
