//! Reasons why a bundle is not written or not accepted.

use crate::mesh::generate::GenerateError;
use crate::report::ReportError;
use crate::scene::SceneError;
use std::io;
use std::path::{Path, PathBuf};

/// A bundle that cannot be written, or whose files differ from those that were written.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Mesh(#[from] GenerateError),
    #[error(transparent)]
    Study(#[from] SceneError),
    #[error("{}: {reason}", path.display())]
    Unreadable { path: PathBuf, reason: String },
    #[error("{}: it cannot be written: {reason}; choose another place, or make room", path.display())]
    Unwritable { path: PathBuf, reason: String },
    #[error("{}: it is not empty; give a folder that does not exist yet", path.display())]
    NotEmpty { path: PathBuf },
    #[error("{}; another machine has no such file: name it relative to the file that reads it", files.join("; "))]
    Absolute { files: Vec<String> },
    #[error("{} has results of the study {found}, not of {wanted}; give the folder of its results with --results", path.display())]
    OtherStudy { path: PathBuf, found: String, wanted: String },
    #[error(
        "{}: its results are not those of the study: {}; write changes of --set into the study, run it again, and bundle the results then",
        path.display(), facts.join("; ")
    )]
    OtherInputs { path: PathBuf, facts: Vec<String> },
    #[error(
        "{}: it adds other meshes to the study than the bundle does; choose another folder with --out", path.display()
    )]
    OtherExtension { path: PathBuf },
    #[error("{}: the study would not run in it: {reason}; name every file of the study by its path in the study, a scene or a law", path.display())]
    Incomplete { path: PathBuf, reason: String },
    #[error("{}: it is no bundle: {reason}", path.display())]
    NoBundle { path: PathBuf, reason: String },
    #[error("{}: {}; get the bundle again", path.display(), files.join("; "))]
    Damaged { path: PathBuf, files: Vec<String> },
}

impl BundleError {
    pub(super) fn unreadable(path: &Path, e: &io::Error) -> Self {
        Self::Unreadable { path: path.into(), reason: e.to_string() }
    }
}
