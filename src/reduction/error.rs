//! Reasons why a scene has no reduced model, or a reduced model cannot be used.

use crate::material::LawSpecError;
use crate::solve::Failure;
use std::path::PathBuf;

/// Reason why no reduced model can be made from a scene.
#[derive(Debug, thiserror::Error)]
pub enum ReductionError {
    #[error("{what} has no reduced form: {why}; {remedy}")]
    Unsupported { what: String, why: String, remedy: String },
    #[error("{0} states are too few: {1} or more are needed; take more training points")]
    TooFewStates(usize, usize),
    #[error(
        "a reduced model gives no \"{name}\"; of this scene it gives {}",
        if known.is_empty() { "no column: add a probe of the mean position of a region, or of an angle (markers and other probes have no reduced form)" } else { known }
    )]
    Quantity { name: String, known: String },
    #[error("the states of the training runs belong to another mesh or scene: {0}; run the study again")]
    OtherScene(String),
    #[error("the law is not defined at a state of the training runs: {0}")]
    Law(String),
    #[error("the equations of a training state cannot be solved for the error estimate: {0}")]
    Adjoint(Failure),
    #[error(
        "the model finds no equilibrium at {failed} of {states} states that were held back; take more modes, or more training states"
    )]
    NoEquilibrium { failed: usize, states: usize },
    #[error("the model cannot be used: {0}; take other numbers of modes, or more training states")]
    Faulty(&'static str),
    #[error(transparent)]
    LawSpec(#[from] LawSpecError),
    #[error(
        "no weights of points reproduce the forces of the training states: the best have an error of {:.1} %, and {:.0} % is the most that is of use; \
         take a smaller `sampling`, or fewer modes",
        100.0 * reached,
        100.0 * most
    )]
    Sampling { reached: f64, most: f64 },
}

/// Reason why the file of a reduced model cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    #[error("{}: cannot be read: {reason}; check the path", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: cannot be written: {reason}; choose another folder, or make room", file.display())]
    Unwritable { file: PathBuf, reason: String },
    #[error("{}: the model is not written: {fact}; make it again with other numbers of modes, or more training states", file.display())]
    Faulty { file: PathBuf, fact: &'static str },
    #[error("{}: this is no reduced model: {fact}; take a .durom file of a study of kind \"reduction\"", file.display())]
    NotAModel { file: PathBuf, fact: String },
    #[error("{}: it has format {found}, and this program reads format {known}; make it again with this program", file.display())]
    OtherFormat { file: PathBuf, found: String, known: String },
    #[error("{}: the file is damaged: {fact}; make it again", file.display())]
    Damaged { file: PathBuf, fact: String },
}
