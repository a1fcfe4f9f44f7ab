//! The files in the program itself: their list, and how they are unpacked.

use super::error::CatalogueError;
use crate::storage::{self, DATA_LIMIT};
use flate2::read::GzDecoder;
use std::path::Path;

/// Written by `build.rs`.
const PACKED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/files.tar.gz"));
const LIST: &str = include_str!(concat!(env!("OUT_DIR"), "/files.txt"));

/// A file that the program brings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entry {
    /// Path below the root of a project, with slashes
    pub name: &'static str,
    pub bytes: u64,
    pub sha256: &'static str,
}

/// The files that the program brings, sorted by their names.
pub fn entries() -> impl Iterator<Item = Entry> {
    LIST.lines().filter_map(|line| {
        let mut words = line.splitn(3, ' ');
        let (sha256, bytes, name) = (words.next()?, words.next()?, words.next()?);
        Some(Entry { name, bytes: bytes.parse().ok()?, sha256 })
    })
}

/// SHA-256 of the list of all files, with their own digests.
pub fn digest() -> &'static str {
    env!("DUROMETER_FILES_SHA256")
}

/// Writes all files below a folder. Each reaches the disk.
pub(super) fn unpack(folder: &Path) -> Result<(), CatalogueError> {
    let io = |e: std::io::Error| not_unpacked(folder, &e);
    let mut archive = tar::Archive::new(GzDecoder::new(PACKED));
    let mut listed = entries();
    for packed in archive.entries().map_err(io)? {
        let Some(entry) = listed.next() else { break };
        let damaged = || CatalogueError::Damaged { file: entry.name.into() };
        let bytes = packed.and_then(|packed| storage::limited(packed, DATA_LIMIT)).map_err(|_| damaged())?;
        if storage::sha256(&bytes) != entry.sha256 {
            return Err(damaged());
        }
        let path = path_of(folder, entry);
        std::fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(io)?;
        storage::write(&path, &bytes).map_err(io)?;
    }
    match listed.next() {
        Some(missing) => Err(CatalogueError::Damaged { file: missing.name.into() }),
        None => Ok(()),
    }
}

/// The error of a folder that the files cannot be written into.
pub(super) fn not_unpacked(folder: &Path, error: &std::io::Error) -> CatalogueError {
    let bytes = entries().map(|entry| entry.bytes).sum();
    CatalogueError::Unpack { folder: folder.to_path_buf(), bytes, reason: error.to_string() }
}

/// Where a file is below a folder.
pub(super) fn path_of(folder: &Path, entry: Entry) -> std::path::PathBuf {
    entry.name.split('/').fold(folder.to_path_buf(), |path, part| path.join(part))
}
