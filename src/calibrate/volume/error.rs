//! Errors of a fit of the change of volume: the fact, the place and the remedy.

use crate::calibrate::intake::roles::ColumnError;
use crate::wording::first;
use std::path::PathBuf;

/// Reasons why neither Poisson's ratio nor the bulk modulus was fitted.
#[derive(Debug, thiserror::Error)]
pub enum VolumeError {
    #[error(transparent)]
    Column(#[from] ColumnError),
    #[error("{}: cannot be written: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{file}: {rows} data points, and a fit needs at least 4; measure more")]
    TooFewRows { file: String, rows: usize },
    #[error("{file}: the {what} is not above −100 % in {} lines: {}; check its kind and unit", lines.len(), first(lines))]
    Impossible { file: String, what: &'static str, lines: Vec<u64> },
    #[error(
        "{file}: column \"{column}\" has no volume near the undeformed one: the nearest V/V0 is {nearest:.4}; check its unit; {remedy}"
    )]
    FarVolume { file: String, column: String, nearest: f64, remedy: &'static str },
    #[error("{file}: the {what} does not vary, so that nothing follows from it; check the column")]
    Constant { file: String, what: &'static str },
    #[error("{file}: {fact}; {remedy}")]
    Sign { file: String, fact: String, remedy: &'static str },
    #[error("{first} and {second} hold the same numbers, and would count as two specimens; give each specimen once")]
    SameData { first: String, second: String },
    #[error("volumetric = \"{name}\" is no volumetric part; take one of quadratic, logarithmic, simo_taylor")]
    Part { name: String },
    #[error(
        "--volumetric does not go with --experiment lateral: a lateral strain gives Poisson's ratio, not the form of U(J)"
    )]
    Contradiction,
    #[error("--{flag} has no effect with --experiment bulk, whose table has no strain along a load; leave it out")]
    Idle { flag: &'static str },
}
