//! Reasons why a new project is not created.

use crate::mesh::generate::GenerateError;
use crate::scene::SceneError;
use std::path::{Path, PathBuf};

/// Reason why a new project is not created.
#[derive(Debug, thiserror::Error)]
pub enum StarterError {
    /// Neither a starter nor a file.
    #[error("{name}: there is no such starter and no such file; {hint}")]
    Unknown { name: String, hint: String },
    /// A unit or a number of cells was given for a starter, which has its own mesh.
    #[error("{name} has a mesh of its own; leave the unit and the number of cells out")]
    OwnMesh { name: String },
    /// The folder is not empty, or is a file.
    #[error("{}: there is something of this name already; name another folder", folder.display())]
    NotEmpty { folder: PathBuf },
    /// The folder has no name that a study could use.
    #[error("{}: a project needs a folder with a name; name one", folder.display())]
    NoName { folder: PathBuf },
    #[error("{}: {reason}; check the path, its permissions and the free space", file.display())]
    Io { file: PathBuf, reason: String },
    /// The shape cannot be used.
    #[error(transparent)]
    Shape(#[from] SceneError),
    /// The files to which the shape refers cannot be copied.
    #[error(transparent)]
    Referred(#[from] GenerateError),
}

impl StarterError {
    pub(super) fn io(file: &Path, error: &std::io::Error) -> Self {
        Self::Io { file: file.to_path_buf(), reason: error.to_string() }
    }
}
