//! Errors of a fit of softening: the fact, the place and the remedy.

use crate::calibrate::{FitError, Mode, fittable_laws, stretch_text};
use crate::material::LawSpecError;
use std::path::PathBuf;

/// Reasons why no softening was fitted.
#[derive(Debug, thiserror::Error)]
pub enum SofteningFitError {
    #[error("{}: cannot be written: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error(
        "{file}: {rows} data points of the modes and the range that are fitted are below the largest stretch before them, {needed} are needed: the table has no unloading there; leave out --softening, or give the whole cyclic test"
    )]
    NoUnloading { file: String, rows: usize, needed: usize },
    #[error(
        "{file}: holds {mode} data on both sides of the undeformed state; the largest energy of one side says nothing about the other here: give them in two tables"
    )]
    BothSides { file: String, mode: Mode },
    #[error(
        "{file}: softening is fitted to the rows as they are, and {what} is asked for by a flag or the card; treat the data before, or leave it out"
    )]
    Treated { file: String, what: &'static str },
    #[error("{file}: biaxial data have no single stretch; softening is fitted to the other modes")]
    Biaxial { file: String },
    #[error(
        "{file}: no softening is seen: unloading follows the law of the first loading as well (criterion {elastic:.1}, {softening:.1} with softening); the effect mullins is not needed"
    )]
    None { file: String, elastic: f64, softening: f64 },
    #[error(
        "the law {law} has no isochoric part, and only that part softens; take one of {}",
        fitted_and_isochoric().join(", ")
    )]
    NotIsochoric { law: &'static str },
    #[error(
        "the fitted law is not defined at the stretch {} of line {line}; fit a law without a limit, or leave out the data beyond by --range",
        stretch_text(*stretch)
    )]
    Undefined { stretch: f64, line: u64 },
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Law(#[from] LawSpecError),
}

/// Names of the laws that can be fitted and have an isochoric part.
fn fitted_and_isochoric() -> Vec<&'static str> {
    fittable_laws().into_iter().map(|law| law.info).filter(|info| info.isochoric).map(|info| info.name).collect()
}
