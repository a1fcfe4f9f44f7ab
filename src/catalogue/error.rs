//! Reasons why the files of the catalogue cannot be used.

use std::path::PathBuf;

/// Reason why the files of the catalogue cannot be used.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CatalogueError {
    /// DUROMETER_HOME names a folder without a mesher.
    #[error("DUROMETER_HOME names {}, which has no folder meshes/meshgen; name the folder of a project, or unset it", folder.display())]
    NoProject { folder: PathBuf },
    /// The program was built on the library and has no bundled files.
    #[error("this program brings no studies and meshes; set DUROMETER_HOME to the folder of a project")]
    Empty,
    /// The system names no folder for caches.
    #[error("the system has no cache folder; set DUROMETER_CACHE to a writable folder")]
    NoCache,
    /// The files cannot be written.
    #[error(
        "{}: the files of the program cannot be unpacked there: {reason}; make it writable with {} MB free, or set DUROMETER_CACHE to another folder",
        folder.display(),
        megabytes(*bytes)
    )]
    Unpack { folder: PathBuf, bytes: u64, reason: String },
    /// Neither the current folder nor the catalogue has the file.
    #[error("{}: there is no such file or folder, here or among the files of the program; {remedy}", path.display())]
    Unknown { path: PathBuf, remedy: String },
    /// An embedded file differs from the one that was packed.
    #[error("the embedded file {file} is damaged; reinstall the program")]
    Damaged { file: String },
}

/// Converts bytes to megabytes, rounded up.
fn megabytes(bytes: u64) -> u64 {
    bytes.div_ceil(1_000_000)
}
