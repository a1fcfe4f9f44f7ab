//! Files of the catalogue that a user names by their paths in a project: `studies/…` and `data/…`.

use super::error::CatalogueError;
use super::home::Home;
use crate::wording::{first, nearest};
use std::path::{Component, Path, PathBuf};

/// Folders of the catalogue whose files a user names.
const FOLDERS: [&str; 2] = ["studies", "data"];

/// Whether a path is that of a file of a project, `studies/…` or `data/…`, and does not leave it.
pub fn is_of_catalogue(path: &Path) -> bool {
    let is_name = |part| matches!(part, Component::Normal(_));
    FOLDERS.iter().any(|folder| path.starts_with(folder)) && path.components().all(is_name)
}

/// The path of the user where it exists, else that of the file or folder of the catalogue which it names. Other paths stay as they are.
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

/// The command of a user, in which words that name files of the catalogue have the paths of these. Others may be files that it will write.
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

/// Names the entry of the catalogue that a path may mean, in its deepest folder that is there.
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
