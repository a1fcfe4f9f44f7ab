//! `report.json`: the files of a report, and what it was made of. The next report removes those that it does not write again.

use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::store::case_files::check_in;
use crate::study::store::names::{NEXT, OUTDATED};
use crate::study::store::origin;
use crate::study::store::outdated::{is_outdated, stored_identity};
use crate::study::store::record::{CaseRecord, StudyRecord};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Name of the file.
pub const FILE: &str = "report.json";
/// Files and folders next to a report that are none of it.
const OTHERS: [&str; 11] = [
    FILE,
    origin::FILE,
    "study.json",
    "extension.toml",
    "growth.json",
    "cases",
    "runs",
    "locks",
    "engine",
    OUTDATED,
    NEXT,
];

/// The files of a report and its sources.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct ReportFiles {
    /// Kind of the study
    pub kind: String,
    /// Digest of the study, without what does not change its report
    pub study_sha256: String,
    /// Case → digest of the identity of the result that counted
    pub identities: BTreeMap<String, String>,
    /// Files that were made once for all reports of these results, as models are, relative to the folder
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub derived: BTreeSet<String>,
    /// All others
    pub files: BTreeSet<String>,
}

impl ReportFiles {
    /// The files of the last report in a folder; none where there was none, or one of an earlier version.
    pub fn read(dir: &Path) -> Option<Self> {
        let bytes = storage::read(&dir.join(FILE), DATA_LIMIT).ok()?;
        serde_json::from_slice(&bytes).ok()
    }

    /// Notes the sources of a report.
    pub fn of<'a>(study: &StudyRecord, cases: impl Iterator<Item = &'a CaseRecord>) -> Self {
        let identities = cases.map(|r| (r.id.clone(), r.provenance.identity.sha256.clone())).collect();
        Self { kind: study.kind.clone(), study_sha256: digest(study), identities, ..Self::default() }
    }

    /// Keeps the list, and removes the files of an earlier report that are in it no more. One that cannot be removed stays.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn replace(&self, earlier: Option<&Self>, dir: &Path) -> std::io::Result<()> {
        let before = earlier.iter().flat_map(|earlier| earlier.files.union(&earlier.derived)).collect::<BTreeSet<_>>();
        for file in before.into_iter().filter(|file| !self.files.contains(*file) && !self.derived.contains(*file)) {
            remove(dir, file);
        }
        let text = serde_json::to_string_pretty(self).expect("strings only") + "\n";
        storage::write(&dir.join(FILE), text.as_bytes())
    }

    /// Removes what was made once for all reports of these results. A file that cannot be removed stays.
    pub fn remove_derived(&self, dir: &Path) {
        self.derived.iter().for_each(|file| remove(dir, file));
    }

    /// Whether the study has changed since, apart from the inputs of its cases.
    pub fn is_of_other_study(&self, study: &StudyRecord) -> bool {
        self.study_sha256 != digest(study)
    }

    /// Whether a case has other inputs in this study, or a result of others.
    pub fn is_of_other_inputs(&self, dir: &Path, study: &StudyRecord) -> bool {
        let is_other = |(id, identity): (&String, &String)| {
            stored_identity(dir, id).is_some_and(|stored| {
                stored != *identity || check_in(dir, id).is_ok_and(|record| is_outdated(dir, study, &record))
            })
        };
        self.identities.iter().any(is_other)
    }
}

/// Removes a file of a report, where it can be removed.
fn remove(dir: &Path, file: &str) {
    if is_inside(Path::new(file)) {
        std::fs::remove_file(dir.join(file)).ok();
    }
}

/// The names of files below a folder with slashes, without those that belong to no report.
pub fn names(files: BTreeSet<PathBuf>, dir: &Path) -> BTreeSet<String> {
    let inside = files.iter().filter_map(|file| file.strip_prefix(dir).ok()).filter(|file| is_inside(file));
    inside.map(|file| file.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")).collect()
}

/// Whether a path leads to a file that a report may have.
fn is_inside(path: &Path) -> bool {
    let mut parts = path.components();
    let first = parts.clone().next();
    first.is_some_and(|first| !OTHERS.iter().any(|other| first.as_os_str() == *other))
        && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// Digest of a study without its version and its inputs, which the identities of its cases tell.
fn digest(study: &StudyRecord) -> String {
    let own = StudyRecord { schema: 0, version: String::new(), inputs_sha256: BTreeMap::new(), ..study.clone() };
    sha256(serde_json::to_string(&own).expect("numbers and string keys only"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_a_report_are_removed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let dir = folder.path().join("r");
        let all = ["law.toml", "figures/time.svg", "figures/mine.svg", "cases/a.csv", "study.json", "../outside"];
        for name in all {
            let path = dir.join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("room");
            std::fs::write(path, "x").expect("room");
        }
        let of = |files: &[&str]| ReportFiles {
            files: files.iter().map(ToString::to_string).collect(),
            ..ReportFiles::default()
        };
        let earlier = of(&["law.toml", "figures/time.svg", "cases/a.csv", "study.json", "../outside"]);
        of(&["law.toml"]).replace(Some(&earlier), &dir).expect("writable");
        let left: Vec<&str> = all.into_iter().filter(|name| dir.join(name).is_file()).collect();
        assert_eq!(left, ["law.toml", "figures/mine.svg", "cases/a.csv", "study.json", "../outside"]);
        assert_eq!(ReportFiles::read(&dir), Some(of(&["law.toml"])));
    }
}
