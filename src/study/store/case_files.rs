//! The files of a case in a folder of results: which there are, and whether they are those that were stored together.

use crate::scene::FileDigest;
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::store::other_build::explain;
use crate::study::store::record::{CaseRecord, StudyRecord};
use crate::study::store::seal;
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// End of the file with the best values so far of a search that has no record yet.
pub const SEARCH: &str = "search.json";
/// Ends of the names of the files of a case, `<id>.<end>`. The record is the last: it is written last.
pub const ENDS: [&str; 9] =
    ["csv", "fit.json", SEARCH, "sensitivities.csv", "skin.json", "skin.json.gz", PAGE, STATES, "json"];
/// End of the file with the motion of a case: a page that shows it.
pub const PAGE: &str = "view.html";
/// End of the file with the states of a case.
pub const STATES: &str = "states.cbor";
/// Name of the folder with the cases whose results are of other inputs than the study has now.
pub const OUTDATED: &str = "outdated";

/// A folder that holds no results of a study, or cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("{}: there is no such file; give a folder that `durometer run STUDY` has written", path.display())]
    NotAStudy { path: PathBuf },
    #[error("{}: it cannot be read: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    #[error("{}: it is not the record of a study: {reason}; run the study again to write it, results are kept", path.display())]
    Malformed { path: PathBuf, reason: String },
}

/// A file that is not the one that was stored, and why.
#[derive(serde::Serialize, Clone, Debug, PartialEq, Eq)]
pub struct Unsound {
    /// Relative to the folder of the results
    pub file: String,
    pub fact: String,
}

/// Name of a file of a case: id and end. `known` tells names apart that several ids fit to, `a.fit` with `json` and `a` with `fit.json`.
pub fn parts_of<'a>(name: &'a str, known: &BTreeSet<&str>) -> Option<(&'a str, &'static str)> {
    let fits = |end: &'static str| Some((name.strip_suffix(end)?.strip_suffix('.')?, end));
    let mut all = ENDS.into_iter().filter_map(fits).filter(|(id, _)| !id.is_empty() && !id.starts_with('.'));
    let found: Vec<(&str, &str)> = all.by_ref().collect();
    let of_study = found.iter().find(|(id, _)| known.contains(id));
    of_study.or_else(|| found.iter().min_by_key(|(id, _)| id.len())).copied()
}

/// Whether the files of a case with this id would be taken for files of another case, such as those of `b.fit` and `b`.
pub fn is_ambiguous(id: &str) -> bool {
    let is_shorter = |name: &str| parts_of(name, &BTreeSet::new()).is_some_and(|(found, _)| found.len() < id.len());
    let is_set_aside = id.rsplit_once(".damaged-").is_some_and(|(_, n)| n.chars().all(|c| c.is_ascii_digit()));
    is_set_aside || is_shorter(id) || ENDS.iter().any(|end| is_shorter(&format!("{id}.{end}")))
}

/// The study of a folder of results.
pub fn study(dir: &Path) -> Result<StudyRecord, FolderError> {
    let path = dir.join("study.json");
    let text = match storage::read(&path, DATA_LIMIT) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => return Err(FolderError::NotAStudy { path }),
        Err(e) => return Err(FolderError::Unreadable { path, reason: e.to_string() }),
    };
    serde_json::from_slice(&text).map_err(|e| FolderError::Malformed { path, reason: e.to_string() })
}

/// The ids of all cases of a study.
pub fn ids(study: &StudyRecord) -> BTreeSet<&str> {
    study.families.iter().flat_map(|f| &f.cases).map(String::as_str).collect()
}

/// The files in the folder of the cases, by id and then end, and the names of all others.
#[derive(Default)]
pub struct CaseFiles {
    pub of_cases: BTreeMap<String, BTreeSet<&'static str>>,
    pub others: Vec<String>,
}

impl CaseFiles {
    pub fn read(dir: &Path, known: &BTreeSet<&str>) -> Result<Self, FolderError> {
        let path = dir.join("cases");
        let unreadable = |e: std::io::Error| FolderError::Unreadable { path: path.clone(), reason: e.to_string() };
        let mut out = Self::default();
        for entry in std::fs::read_dir(&path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            // A link counts as the file that it leads to
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

/// The record of a case among files that are given by their ends, where all of them are sound.
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

/// The same for a case in a folder of results.
pub fn check_in(dir: &Path, id: &str) -> Result<CaseRecord, Vec<Unsound>> {
    check(id, &|end| storage::read(&dir.join("cases").join(format!("{id}.{end}")), DATA_LIMIT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_belongs_to_the_case_that_exists() {
        let none = BTreeSet::new();
        assert_eq!(parts_of("a-b-1.5.csv", &none), Some(("a-b-1.5", "csv")));
        assert_eq!(parts_of("a.skin.json.gz", &none), Some(("a", "skin.json.gz")));
        assert_eq!(parts_of("a.fit.json", &none), Some(("a", "fit.json")));
        assert_eq!(parts_of("a.view.html", &none), Some(("a", PAGE)));
        assert_eq!(parts_of("a.fit.json", &BTreeSet::from(["a.fit"])), Some(("a.fit", "json")));
        for id in ["b.fit", "b.search", "b.skin", "b.skin.json", "b.sensitivities", "b.csv", "b.json", "b.damaged-1"] {
            assert!(is_ambiguous(id), "{id}");
        }
        for id in ["b", "a-b-1.5", "b.view", "b.fitted", "skin", "b.damaged-x"] {
            assert!(!is_ambiguous(id), "{id}");
        }
        for other in ["notes.txt", ".x.part", "json", ".json", "a.json.damaged"] {
            assert_eq!(parts_of(other, &none), None, "{other}");
        }
    }
}
