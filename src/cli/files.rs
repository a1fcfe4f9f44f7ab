//! Resolution of a name on the command line to its file.

use durometer::catalogue::{self, Home};
use durometer::scene::{self, read_table};
use durometer::wording::{first, nearest};
use std::path::{Path, PathBuf};

/// Finds a scene or study file by its path, its folder, or the name of a folder in `studies/` of the current folder or of the catalogue.
pub fn find(name: &Path, file: &str) -> Result<PathBuf, String> {
    // An empty path joined with a file name would be a file of the current folder
    if name.as_os_str().is_empty() {
        return Err(format!(
            "the name of a {file} is empty; give its path, or the name of a folder, such as . of the current one"
        ));
    }
    let own = PathBuf::from("studies");
    let here = [name.into(), name.join(file), own.join(name).join(file)];
    if let Some(found) = here.into_iter().find(|path| path.is_file()) {
        return Ok(found);
    }
    if catalogue::is_of_catalogue(name) {
        let path = brought(name)?;
        let inside = path.join(file);
        let found = [path, inside].into_iter().find(|path| path.is_file());
        return found.ok_or_else(|| format!("{}: this folder has no {file}", name.display()));
    }
    let home = Home::find().map_err(|e| format!("{}: there is no such file; {e}", name.display()))?;
    let known = home.studies().join(name).join(file);
    if known.is_file() {
        return Ok(known);
    }
    if [Path::new(""), &own, &home.studies()].iter().any(|folder| folder.join(name).is_dir()) {
        return Err(format!("{}: this folder has no {file}", name.display()));
    }
    let word = name.to_string_lossy();
    let mut known = [names(&own, file), names(&home.studies(), file)].concat();
    known.sort();
    known.dedup();
    let hint = match nearest(&word, &known) {
        Some(near) => format!("did you mean `{near}`? (known: {})", first(&known)),
        None => format!("known: {}", first(&known)),
    };
    Err(format!("{word}: there is no such file, and no folder studies/{word}; {hint}"))
}

/// Returns a file or folder of the user, or else the one of the program that a path `studies/…` or `data/…` names.
pub fn brought(path: &Path) -> Result<PathBuf, String> {
    catalogue::brought(path).map_err(|e| e.to_string())
}

/// Resolves each of several paths as [`brought`] does.
pub fn all_brought(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    paths.iter().map(|path| brought(path)).collect()
}

/// Returns the sorted names of the folders in `studies/` that contain this file.
fn names(studies: &Path, file: &str) -> Vec<String> {
    let entries = std::fs::read_dir(studies).into_iter().flatten().flatten();
    let with = entries.filter(|e| e.path().join(file).is_file());
    let mut names: Vec<String> = with.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    names
}

/// Whether the content of a file is that of a study. A file that cannot be read counts as a scene, whose reader reports the reason.
pub fn is_study(file: &Path) -> bool {
    read_table(file).is_ok_and(|(_, table)| scene::is_study(&table))
}

/// Finds a study of this name, or else a scene, for `check` and `mesh`.
pub fn find_any(name: &Path) -> Result<PathBuf, String> {
    find(name, "study.toml").or_else(|e| find(name, "scene.toml").map_err(|_| e))
}

/// Creates the folder of the results.
pub fn make_folder(dir: &Path) -> Result<(), String> {
    let remedy = "choose another folder with --out";
    std::fs::create_dir_all(dir).map_err(|e| format!("{}: cannot be made: {e}; {remedy}", dir.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a folder with a scene, an empty name would otherwise find that scene.
    #[test]
    fn an_empty_name_is_refused() {
        for found in [find(Path::new(""), "scene.toml"), find_any(Path::new(""))] {
            assert!(found.as_ref().is_err_and(|why| why.contains("is empty; give its path")), "{found:?}");
        }
    }
}
