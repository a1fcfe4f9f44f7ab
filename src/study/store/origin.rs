//! `origin.json` in a folder of results: the file of their study, which distinguishes two studies of the same name.

use crate::catalogue::brought;
use crate::storage::{self, TEXT_LIMIT};
use crate::study::store::folder::{StoreError, unwritable};
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};

/// Name of the file.
pub const FILE: &str = "origin.json";

/// The file of a study as recorded with its results.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum Origin {
    /// Path among the studies of the program or of a project with bodies: the study is the same wherever these are located
    Brought(String),
    /// Path relative to the folder of the results, so that both can be moved together
    File(String),
}

impl Origin {
    fn of(dir: &Path, file: &Path) -> Option<Self> {
        let file = file.canonicalize().ok()?;
        let is_home = |studies: &&Path| {
            let is_named = studies.file_name().is_some_and(|name| name == "studies");
            is_named && studies.parent().is_some_and(|home| home.join("meshes/meshgen").is_dir())
        };
        let inside = file.ancestors().find(is_home).and_then(|studies| file.strip_prefix(studies).ok());
        let text = |path: &Path| path.to_string_lossy().into_owned();
        Some(match inside {
            Some(inside) => Self::Brought(text(inside)),
            None => Self::File(text(&relative(&dir.canonicalize().ok()?, &file))),
        })
    }

    fn read(dir: &Path) -> Option<Self> {
        serde_json::from_slice(&storage::read(&dir.join(FILE), TEXT_LIMIT).ok()?).ok()
    }
}

/// Records the file of the study whose results a folder holds.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn note(dir: &Path, file: &Path) -> Result<(), StoreError> {
    let Some(origin) = Origin::of(dir, file) else { return Ok(()) };
    if Origin::read(dir).as_ref() == Some(&origin) {
        return Ok(());
    }
    let path = dir.join(FILE);
    let text = serde_json::to_string_pretty(&origin).expect("strings only") + "\n";
    storage::write(&path, text.as_bytes()).map_err(|e| unwritable(&path, &e))
}

/// The file of another study whose results a folder holds. A study that is no longer at its recorded location counts as moved.
pub fn other(dir: &Path, file: &Path) -> Option<PathBuf> {
    let stored = Origin::read(dir)?;
    if Origin::of(dir, file)? == stored {
        return None;
    }
    match stored {
        Origin::Brought(inside) => Some(Path::new("studies").join(inside)),
        Origin::File(stored) => dir.join(stored).canonicalize().ok(),
    }
}

/// The file of the study whose results a folder holds, if it is recorded and exists. For a study of the program or of a project, the one in the project
/// that contains the folder takes precedence.
pub fn file(dir: &Path) -> Option<PathBuf> {
    let found = match Origin::read(dir)? {
        Origin::File(stored) => dir.join(stored),
        Origin::Brought(inside) => {
            let study = Path::new("studies").join(inside);
            let own =
                dir.canonicalize().ok()?.ancestors().map(|project| project.join(&study)).find(|file| file.is_file());
            own.or_else(|| brought(&study).ok())?
        }
    };
    found.is_file().then_some(found)
}

/// The path of a file relative to a folder; both are absolute and without symbolic links.
fn relative(folder: &Path, file: &Path) -> PathBuf {
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return file.into();
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(file.components().skip(shared)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_study_is_told_and_a_moved_one_is_not() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let at = folder.path();
        let file = |place: &str| {
            let path = at.join(place).join("foo/study.toml");
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("room");
            std::fs::write(&path, "").expect("room");
            path
        };
        let (a, b, dir) = (file("home/a"), file("home/b"), at.join("home/r/foo"));
        std::fs::create_dir_all(&dir).expect("room");
        assert_eq!(other(&dir, &a), None, "nothing is noted");
        note(&dir, &a).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(other(&dir, &a), None);
        assert_eq!(super::file(&dir).and_then(|found| found.canonicalize().ok()), a.canonicalize().ok());
        assert_eq!(other(&dir, &b), a.canonicalize().ok());
        std::fs::rename(at.join("home"), at.join("moved")).expect("own folder");
        let dir = at.join("moved/r/foo");
        assert_eq!(other(&dir, &at.join("moved/a/foo/study.toml")), None, "study and results were moved together");
        std::fs::rename(at.join("moved/a"), at.join("moved/c")).expect("own folder");
        assert_eq!(other(&dir, &at.join("moved/c/foo/study.toml")), None, "the study was moved");
    }
}
