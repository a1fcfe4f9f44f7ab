//! Files of a report, read and written as a whole.

use crate::report::error::ReportError;
use crate::storage::{self, DATA_LIMIT};
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads a JSON file; `None` if the file does not exist.
pub fn json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, ReportError> {
    read_with(path, |bytes| serde_json::from_slice(bytes))
}

/// Reads a file and parses its content with `parse`; `None` if the file does not exist.
pub fn read_with<T>(
    path: &Path,
    parse: impl Fn(&[u8]) -> Result<T, serde_json::Error>,
) -> Result<Option<T>, ReportError> {
    match storage::read(path, DATA_LIMIT) {
        Ok(bytes) => {
            parse(&bytes).map(Some).map_err(|source| ReportError::Malformed { path: path.to_path_buf(), source })
        }
        Err(e) if storage::is_absent(&e) => Ok(None),
        Err(source) => Err(ReportError::Unreadable { path: path.to_path_buf(), source }),
    }
}

/// Writes a file whole or not at all, so that a full disk never leaves half a report.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    storage::write(path, bytes).map_err(|source| ReportError::Unwritable { path: path.to_path_buf(), source })
}

/// Creates a folder with its parents.
pub fn folder(path: &Path) -> Result<(), ReportError> {
    std::fs::create_dir_all(path).map_err(|source| ReportError::Unwritable { path: path.to_path_buf(), source })
}
