//! The user's cache: the bundled files, unpacked, and the meshes that were made.

use super::embedded::{Archive, Entry, archive, path_of};
use super::error::CatalogueError;
use crate::storage;
use etcetera::BaseStrategy;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Prefix of the name of a folder with the bundled files of one version.
const PREFIX: &str = "files-";
/// Prefix of the name of a folder that is being written.
const UNFINISHED: &str = ".files-";
/// Age after which no process is still writing such a folder.
const FORGOTTEN: Duration = Duration::from_secs(3600);

/// The cache folder: DUROMETER_CACHE, otherwise `durometer` in the system's folder for caches.
pub fn folder() -> Result<PathBuf, CatalogueError> {
    if let Some(given) = std::env::var_os("DUROMETER_CACHE").filter(|given| !given.is_empty()) {
        return std::path::absolute(&given).map_err(|_| CatalogueError::NoCache);
    }
    let system = etcetera::base_strategy::choose_native_strategy().map_err(|_| CatalogueError::NoCache)?;
    Ok(system.cache_dir().join("durometer"))
}

/// The folder of the bundled files in a cache; they are unpacked unless they are complete there. The folder is named after its contents, so that
/// several versions of the program can share a cache.
pub fn unpacked(cache: &Path) -> Result<PathBuf, CatalogueError> {
    static WHOLE: Mutex<Vec<PathBuf>> = Mutex::new(vec![]);
    let archive = archive()?;
    let folder = cache.join(name_of(&archive));
    // Other threads wait for the one that unpacks
    let mut whole = WHOLE.lock().unwrap_or_else(PoisonError::into_inner);
    if !whole.contains(&folder) {
        if !is_whole(&archive, &folder) {
            unpack(&archive, cache, &folder)?;
        }
        whole.push(folder.clone());
    }
    Ok(folder)
}

/// The name of the folder with the files of an archive.
fn name_of(archive: &Archive) -> String {
    format!("{PREFIX}{}", &archive.digest[..16])
}

/// Whether every file is there with its full length: systems that clean up may remove single files.
fn is_whole(archive: &Archive, folder: &Path) -> bool {
    let is_there = |entry: Entry| path_of(folder, entry).metadata().is_ok_and(|found| found.len() == entry.bytes);
    folder.is_dir() && archive.entries().all(is_there)
}

/// Unpacks into a folder of a temporary name, which is renamed when it is complete. Another process may be faster.
fn unpack(archive: &Archive, cache: &Path, folder: &Path) -> Result<(), CatalogueError> {
    let io = |e: std::io::Error| archive.not_unpacked(cache, &e);
    std::fs::create_dir_all(cache).map_err(io)?;
    remove_left_over(cache);
    let part = tempfile::Builder::new().prefix(UNFINISHED).suffix(".part").tempdir_in(cache).map_err(io)?;
    let (new, old) = (part.path().join("new"), part.path().join("old"));
    archive.unpack(&new).map_err(|e| match e {
        CatalogueError::Unpack { bytes, reason, .. } => CatalogueError::Unpack { folder: cache.into(), bytes, reason },
        other => other,
    })?;
    for _ in 0..3 {
        // A damaged folder is moved into the temporary one, and removed with it
        if folder.exists() && !is_whole(archive, folder) {
            std::fs::rename(folder, &old).ok();
        }
        let named = std::fs::rename(&new, folder);
        if named.is_ok() || is_whole(archive, folder) {
            return Ok(());
        }
    }
    std::fs::rename(&new, folder).map_err(io)
}

/// Removes folders that killed processes have left.
fn remove_left_over(cache: &Path) {
    let is_old = |path: &Path| {
        let changed = path.metadata().and_then(|found| found.modified());
        changed.is_ok_and(|changed| changed.elapsed().is_ok_and(|age| age > FORGOTTEN))
    };
    for entry in std::fs::read_dir(cache).into_iter().flatten().flatten() {
        let is_unfinished = entry.file_name().to_str().is_some_and(|name| name.starts_with(UNFINISHED));
        if is_unfinished && is_old(&entry.path()) {
            std::fs::remove_dir_all(entry.path()).ok();
        }
    }
}

/// Bundled files whose content below a folder is missing or differs from that of the program.
pub fn altered(archive: &Archive, folder: &Path) -> Vec<&'static str> {
    let is_same = |entry: &Entry| {
        storage::read(&path_of(folder, *entry), entry.bytes).is_ok_and(|bytes| storage::sha256(bytes) == entry.sha256)
    };
    archive.entries().filter(|entry| !is_same(entry)).map(|entry| entry.name).collect()
}

/// Folders with the bundled files of other versions of the program.
pub fn others(archive: &Archive, cache: &Path) -> Vec<PathBuf> {
    let own = name_of(archive);
    let entries = std::fs::read_dir(cache).into_iter().flatten().flatten();
    let of_version = |name: &str| name.starts_with(PREFIX) && name != own;
    let named = entries.filter(|entry| entry.file_name().to_str().is_some_and(of_version));
    let mut folders: Vec<PathBuf> = named.map(|entry| entry.path()).collect();
    folders.sort();
    folders
}
