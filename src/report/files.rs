//! Files of a report: read whole, written whole.

use crate::report::error::ReportError;
use serde::de::DeserializeOwned;
use std::io::ErrorKind;
use std::path::Path;

/// `None` if the file does not exist.
pub fn json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, ReportError> {
    read_with(path, |bytes| serde_json::from_slice(bytes))
}

/// Contents of a file as read by `parse`; `None` if the file does not exist.
pub fn read_with<T>(
    path: &Path,
    parse: impl Fn(&[u8]) -> Result<T, serde_json::Error>,
) -> Result<Option<T>, ReportError> {
    match std::fs::read(path) {
        Ok(bytes) => {
            parse(&bytes).map(Some).map_err(|source| ReportError::Malformed { path: path.to_path_buf(), source })
        }
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(source) => Err(ReportError::Unreadable { path: path.to_path_buf(), source }),
    }
}

/// Writes a file, through a temporary one in the same folder: a full disk never leaves half a report.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let error = |source| ReportError::Unwritable { path: path.to_path_buf(), source };
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path)).map_err(|e| {
        let _ = std::fs::remove_file(&part);
        error(e)
    })
}

/// Makes a folder with its parents.
pub fn folder(path: &Path) -> Result<(), ReportError> {
    std::fs::create_dir_all(path).map_err(|source| ReportError::Unwritable { path: path.to_path_buf(), source })
}
