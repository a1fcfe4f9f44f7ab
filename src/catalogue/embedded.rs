//! The files embedded in the program: their list, and how they are unpacked.

use super::error::CatalogueError;
use crate::storage::{self, DATA_LIMIT};
use flate2::read::GzDecoder;
use std::path::Path;
use std::sync::OnceLock;

/// Files that are bundled with a program, packed when it was built.
#[derive(Clone, Copy, Debug)]
pub struct Archive {
    /// The files in the order of the list, as a gzipped tar archive
    pub packed: &'static [u8],
    /// A line for each file: digest, length in bytes, and path below the root of a project
    pub list: &'static str,
    /// SHA-256 of the list
    pub digest: &'static str,
}

static ARCHIVE: OnceLock<Archive> = OnceLock::new();

/// Registers the bundled files of this program, before any is looked up; only the first call has an effect. A program without bundled files finds
/// them in the checkout that it was built in, or in the folder that DUROMETER_HOME names.
pub fn bring(archive: Archive) {
    ARCHIVE.get_or_init(|| archive);
}

/// The bundled files of this program.
pub fn archive() -> Result<Archive, CatalogueError> {
    ARCHIVE.get().copied().ok_or(CatalogueError::Empty)
}

/// A file that is bundled with the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Entry {
    /// Path below the root of a project, with slashes
    pub name: &'static str,
    pub bytes: u64,
    pub sha256: &'static str,
}

impl Archive {
    /// The files, sorted by their names.
    pub fn entries(&self) -> impl Iterator<Item = Entry> + use<> {
        self.list.lines().filter_map(|line| {
            let mut words = line.splitn(3, ' ');
            let (sha256, bytes, name) = (words.next()?, words.next()?, words.next()?);
            Some(Entry { name, bytes: bytes.parse().ok()?, sha256 })
        })
    }

    /// Total length of the unpacked files.
    pub(super) fn bytes(&self) -> u64 {
        self.entries().map(|entry| entry.bytes).sum()
    }

    /// Writes all files below a folder and flushes each of them to the disk.
    pub(super) fn unpack(&self, folder: &Path) -> Result<(), CatalogueError> {
        let io = |e: std::io::Error| self.not_unpacked(folder, &e);
        let mut files = tar::Archive::new(GzDecoder::new(self.packed));
        let mut listed = self.entries();
        for packed in files.entries().map_err(io)? {
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

    /// The error for a folder that the files cannot be written into.
    pub(super) fn not_unpacked(&self, folder: &Path, error: &std::io::Error) -> CatalogueError {
        CatalogueError::Unpack { folder: folder.to_path_buf(), bytes: self.bytes(), reason: error.to_string() }
    }
}

/// The path of a bundled file below a folder.
pub(super) fn path_of(folder: &Path, entry: Entry) -> std::path::PathBuf {
    entry.name.split('/').fold(folder.to_path_buf(), |path, part| path.join(part))
}
