//! Resolution of a name on the command line to its file.

use durometer::catalogue::{self, Home};
use durometer::scene::{self, read_table};
use durometer::wording::{first, nearest};
use std::path::{Path, PathBuf};

/// A scene or study file, found by path, by folder, or by the name of a folder in `studies/`, of the current folder or else of the catalogue.
pub fn find(name: &Path, file: &str) -> Result<PathBuf, String> {
    // Joined with a file it would be the one of the current folder
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

/// A file or folder of the user, or else the one of the program that a path `studies/…` or `data/…` names.
pub fn brought(path: &Path) -> Result<PathBuf, String> {
    catalogue::brought(path).map_err(|e| e.to_string())
}

/// Several of them.
pub fn all_brought(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    paths.iter().map(|path| brought(path)).collect()
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
    read_table(file).is_ok_and(|(_, table)| scene::is_study(&table))
}

/// A study, or else a scene, of this name, for `check` and `mesh`.
pub fn find_any(name: &Path) -> Result<PathBuf, String> {
    find(name, "study.toml").or_else(|e| find(name, "scene.toml").map_err(|_| e))
}

/// Makes the folder of the results.
pub fn make_folder(dir: &Path) -> Result<(), String> {
    let remedy = "choose another folder with --out";
    std::fs::create_dir_all(dir).map_err(|e| format!("{}: cannot be made: {e}; {remedy}", dir.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a folder with a scene it would be that one.
    #[test]
    fn an_empty_name_is_refused() {
        for found in [find(Path::new(""), "scene.toml"), find_any(Path::new(""))] {
            assert!(found.as_ref().is_err_and(|why| why.contains("is empty; give its path")), "{found:?}");
        }
    }
}
