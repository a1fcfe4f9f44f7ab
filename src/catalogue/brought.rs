//! Catalogue files that a user names by their paths in a project: `studies/…` and `data/…`.

use super::error::CatalogueError;
use super::home::Home;
use crate::wording::{first, nearest};
use std::path::{Component, Path, PathBuf};

/// Folders of the catalogue whose files a user can name.
const FOLDERS: [&str; 2] = ["studies", "data"];

/// Whether a path is `studies/…` or `data/…` as in a project, and does not leave these folders.
pub fn is_of_catalogue(path: &Path) -> bool {
    let is_name = |part| matches!(part, Component::Normal(_));
    FOLDERS.iter().any(|folder| path.starts_with(folder)) && path.components().all(is_name)
}

/// The user's path if it exists, otherwise the path of the catalogue file or folder that it names. All other paths are returned unchanged.
pub fn brought(path: &Path) -> Result<PathBuf, CatalogueError> {
    if path.exists() || !is_of_catalogue(path) {
        return Ok(path.into());
    }
    let home = Home::find()?.path;
    let found = home.join(path);
    match found.exists() {
        true => Ok(found),
        false => Err(CatalogueError::Unknown { path: path.into(), remedy: remedy(&home, path) }),
    }
}

/// The user's command, with words that name catalogue files replaced by the paths of these files. Other words may be files that the command will
/// write.
pub fn brought_command(command: &str) -> String {
    let words = shlex::split(command).unwrap_or_default();
    let known: Vec<String> = words
        .iter()
        .map(|word| brought(Path::new(word)).map_or_else(|_| word.clone(), |path| path.to_string_lossy().into_owned()))
        .collect();
    if known == words {
        command.into()
    } else {
        shlex::try_join(known.iter().map(String::as_str)).unwrap_or(command.into())
    }
}

/// Names the catalogue entry that a path may mean, in its deepest folder that exists.
fn remedy(home: &Path, path: &Path) -> String {
    let folder = path.ancestors().skip(1).find(|folder| home.join(folder).is_dir()).unwrap_or(Path::new(""));
    let next = path.components().nth(folder.components().count());
    let word = next.map_or_else(String::new, |part| part.as_os_str().to_string_lossy().into_owned());
    let entries = std::fs::read_dir(home.join(folder)).into_iter().flatten().flatten();
    let mut known: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    known.sort();
    match nearest(&word, &known) {
        Some(near) => format!("did you mean `{}`?", folder.join(near).display()),
        None => format!("{} has {}", folder.display(), first(&known)),
    }
}
