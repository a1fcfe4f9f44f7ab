//! `report.json`: the files of a report and its sources. The next report removes those files that it does not write again.

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
/// Files and folders next to a report that do not belong to it.
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
    /// Digest of the study, without the parts that do not affect its report
    pub study_sha256: String,
    /// Case → digest of the identity of the result that counted
    pub identities: BTreeMap<String, String>,
    /// Files that were made once for all reports of these results, such as models, relative to the folder
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub derived: BTreeSet<String>,
    /// All other files, relative to the folder
    pub files: BTreeSet<String>,
}

impl ReportFiles {
    /// The files of the last report in a folder; `None` if there was no report, or one of an earlier version.
    pub fn read(dir: &Path) -> Option<Self> {
        let bytes = storage::read(&dir.join(FILE), DATA_LIMIT).ok()?;
        serde_json::from_slice(&bytes).ok()
    }

    /// Records the sources of a report.
    pub fn of<'a>(study: &StudyRecord, cases: impl Iterator<Item = &'a CaseRecord>) -> Self {
        let identities = cases.map(|r| (r.id.clone(), r.provenance.identity.sha256.clone())).collect();
        Self { kind: study.kind.clone(), study_sha256: digest(study), identities, ..Self::default() }
    }

    /// Stores the list, and removes the files of an earlier report that it no longer contains. A file that cannot be removed stays.
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

    /// Removes the files that were made once for all reports of these results. A file that cannot be removed stays.
    pub fn remove_derived(&self, dir: &Path) {
        self.derived.iter().for_each(|file| remove(dir, file));
    }

    /// Whether the study has changed since, apart from the inputs of its cases.
    pub fn is_of_other_study(&self, study: &StudyRecord) -> bool {
        self.study_sha256 != digest(study)
    }

    /// Whether a case now has other inputs in this study, or a result with other inputs.
    pub fn is_of_other_inputs(&self, dir: &Path, study: &StudyRecord) -> bool {
        let is_other = |(id, identity): (&String, &String)| {
            stored_identity(dir, id).is_some_and(|stored| {
                stored != *identity || check_in(dir, id).is_ok_and(|record| is_outdated(dir, study, &record))
            })
        };
        self.identities.iter().any(is_other)
    }
}

/// Removes a file of a report, if possible.
fn remove(dir: &Path, file: &str) {
    if is_inside(Path::new(file)) {
        std::fs::remove_file(dir.join(file)).ok();
    }
}

/// The names of files below a folder, with slashes, except those that cannot belong to a report.
pub fn names(files: BTreeSet<PathBuf>, dir: &Path) -> BTreeSet<String> {
    let inside = files.iter().filter_map(|file| file.strip_prefix(dir).ok()).filter(|file| is_inside(file));
    inside.map(|file| file.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")).collect()
}

/// Whether a path leads to a file that can belong to a report.
fn is_inside(path: &Path) -> bool {
    let mut parts = path.components();
    let first = parts.clone().next();
    first.is_some_and(|first| !OTHERS.iter().any(|other| first.as_os_str() == *other))
        && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// Digest of a study without its version and its inputs, which the identities of its cases cover.
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
