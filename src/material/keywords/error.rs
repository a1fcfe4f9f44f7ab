//! Errors of laws in the files of other programs.

use super::program::Program;
use crate::material::LawSpecError;
use crate::math::units::UnitError;

/// Reason why a law could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum KeywordError {
    #[error("{} has no law with the energy of `{law}`{why}; choose another program or another law", program.name())]
    NoForm { program: Program, law: String, why: &'static str },
    #[error("the text has no law of {}: {what}", program.name())]
    Unreadable { program: Program, what: String },
    #[error(transparent)]
    Unit(#[from] UnitError),
    #[error(transparent)]
    Law(#[from] LawSpecError),
}
