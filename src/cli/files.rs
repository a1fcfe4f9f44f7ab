//! Resolution of a name on the command line to its file.

use durometer::mesh::generate::MeshStore;
use durometer::scene::{hint, read_table};
use std::path::{Path, PathBuf};

/// A scene or study file, found by path, by folder, or by the name of a folder in `studies/`.
pub fn find(name: &Path, file: &str) -> Result<PathBuf, String> {
    if name.is_file() {
        return Ok(name.into());
    }
    if name.join(file).is_file() {
        return Ok(name.join(file));
    }
    let studies = MeshStore::find().map(|w| w.home.join("studies")).unwrap_or_else(|_| "studies".into());
    let known = studies.join(name).join(file);
    if known.is_file() {
        return Ok(known);
    }
    if name.is_dir() || studies.join(name).is_dir() {
        return Err(format!("{}: this folder has no {file}", name.display()));
    }
    let word = name.to_string_lossy();
    let hint = hint(&word, &names(&studies, file));
    Err(format!("{word}: there is no such file, and no folder studies/{word}; {hint}"))
}

/// Folders of `studies/` that have this file, sorted.
fn names(studies: &Path, file: &str) -> Vec<String> {
    let entries = std::fs::read_dir(studies).into_iter().flatten().flatten();
    let with = entries.filter(|e| e.path().join(file).is_file());
    let mut names: Vec<String> = with.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    names
}

/// A study or a scene, by what the file says. One that cannot be read is taken for a scene, whose reader says why.
pub fn is_study(file: &Path) -> bool {
    read_table(file).is_ok_and(|(_, table)| table.contains_key("scene") || table.contains_key("family"))
}

/// For `check` and `mesh`: a study, or else a scene, of this name.
pub fn find_any(name: &Path) -> Result<PathBuf, String> {
    find(name, "study.toml").or_else(|e| find(name, "scene.toml").map_err(|_| e))
}

/// Makes the folder of the results.
pub fn make_folder(dir: &Path) -> Result<(), String> {
    let remedy = "choose another folder with --out";
    std::fs::create_dir_all(dir).map_err(|e| format!("{}: cannot be made: {e}; {remedy}", dir.display()))
}
