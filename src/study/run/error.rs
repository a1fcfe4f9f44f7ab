//! Reasons why a case has no result, not even a status.

use crate::calibrate::inverse::InverseError;
use crate::mesh::error::MeshError;
use crate::scene::{RefineError, SceneError};
use crate::study::run::task::TaskError;
use crate::study::store::folder::StoreError;
use crate::wording::few;

/// Why a case has no result, not even a status.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Fields(#[from] MeshError),
    #[error(transparent)]
    Inverse(#[from] InverseError),
    #[error("case {case}: {why}")]
    Refine { case: String, why: Box<RefineError> },
    #[error(transparent)]
    Task(#[from] TaskError),
    #[error(
        "{} was read with other contents than when the run began, and the result would be of both; run the study again",
        few(files)
    )]
    Changed { files: Vec<String> },
}
