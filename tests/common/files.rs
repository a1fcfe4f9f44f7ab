//! The files below a folder, for all test programs.

use std::path::{Path, PathBuf};

/// All files below a folder in the order of their paths; the file itself if the path is one.
pub fn files_below(path: &Path) -> Vec<PathBuf> {
    kept_below(path, &|_| true)
}

/// The same without the files and folders that are not kept.
pub fn kept_below(path: &Path, keep: &dyn Fn(&Path) -> bool) -> Vec<PathBuf> {
    assert!(path.exists(), "no {}", path.display());
    let mut found = vec![];
    let mut open = vec![path.to_path_buf()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let inside = std::fs::read_dir(&path).into_iter().flatten().flatten().map(|entry| entry.path());
            open.extend(inside.filter(|path| keep(path)));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}
