//! Errors of a fit of a Prony series: the fact, the place and the remedy.

use crate::calibrate::constant_format::number_text;
use crate::calibrate::intake::roles::ColumnError;
use crate::calibrate::{FitError, stretch_text};
use crate::material::LawSpecError;
use crate::math::units::UnitError;
use crate::wording::first;
use std::path::PathBuf;

/// Reasons why no Prony series was fitted.
#[derive(Debug, thiserror::Error)]
pub enum RelaxationError {
    #[error("{}: cannot be written: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{file}: the times do not increase in {} lines: {}; a test is one run in the order of time", lines.len(), first(lines))]
    Times { file: String, lines: Vec<u64> },
    #[error("{file}: the frequency is not positive in {} lines: {}; remove them", lines.len(), first(lines))]
    Frequency { file: String, lines: Vec<u64> },
    #[error(
        "{file}: the table holds several tests: one frequency has {first} and {second} in column \"{column}\", with other moduli; divide it into one file for each, and fit them one by one"
    )]
    Conditions { file: String, column: String, first: f64, second: f64 },
    #[error("{file}: the {what} is not positive in {} lines: {}; {remedy}", lines.len(), first(lines))]
    Sign { file: String, what: &'static str, lines: Vec<u64>, remedy: &'static str },
    #[error(
        "{file}: the duration of the loading is not known, and the early relaxation depends on it; pass --ramp \"0.5 s\", or \"0 s\" for an ideal step"
    )]
    NoRamp { file: String },
    #[error(
        "{file}: the loading lasts {} s and the data end at {} s, so that no data point is of the held state; check --ramp, --start and the unit of time, or measure longer",
        number_text(*ramp), number_text(*last)
    )]
    LongRamp { file: String, ramp: f64, last: f64 },
    #[error(
        "{file}: the data begin at {} s in steps of {} s, long after a loading that lasts {} s: the time seems to be that of a logger, or the beginning is missing; pass --start with the time of the table at which the loading begins, \"0 s\" if it is its zero",
        number_text(*first), number_text(*step), number_text(*ramp)
    )]
    LateData { file: String, first: f64, step: f64, ramp: f64 },
    #[error("{flag} = {value}: {remedy}")]
    Flag { flag: &'static str, value: String, remedy: &'static str },
    #[error("{flag} does not go with --experiment {experiment}: {remedy}")]
    Contradiction { flag: &'static str, experiment: &'static str, remedy: &'static str },
    #[error(
        "{file}: {rows} data points for {constants} constants; a fit needs at least two more than constants: take fewer terms, or measure more"
    )]
    TooFewRows { file: String, rows: usize, constants: usize },
    #[error(
        "{file}: no relaxation is seen: an elastic response describes the data as well (criterion {elastic:.1}, {series:.1} with a relaxing term); {remedy}"
    )]
    Elastic { file: String, elastic: f64, series: f64, remedy: &'static str },
    #[error(
        "{file}: the strain begins at zero, so that the data do not give the instantaneous compliance; pass a longer --ramp, or leave out the beginning by --start"
    )]
    NoInstant { file: String },
    #[error("{first} and {second} hold the same numbers, and would count as two specimens; give each specimen once")]
    SameData { first: String, second: String },
    #[error("{first} is in \"{}\" and {second} in \"{}\": specimens of one test have one unit; pass --unit", units[0], units[1])]
    Units { first: String, second: String, units: [String; 2] },
    #[error("{file}: every value is zero; check the column and its unit")]
    Zero { file: String },
    #[error("clarabel did not finish ({status}) on a problem with one minimum; please report the data file")]
    Solver { status: String },
    #[error(
        "the law {law} has no isochoric part, and only that part relaxes; take a law with one, such as neo_hookean_split or yeoh"
    )]
    NotIsochoric { law: &'static str },
    #[error("the law is not defined at the stretch {} of line {line}: {reason}", stretch_text(*stretch))]
    LawStress { stretch: f64, line: u64, reason: String },
    #[error(
        "{file}: column \"{column}\" in \"{unit}\" is no stress, and that of the law is one in pascals: divide a force by the undeformed cross-section, or leave out --law"
    )]
    NoStress { file: String, column: String, unit: String },
    #[error(
        "{file}: column \"{stress}\" has the sign against \"{strain}\": the law has positive stresses in tension and negative ones in compression; turn the sign of one of them, or, where both count compression as positive, call them compressive"
    )]
    Against { file: String, strain: String, stress: String },
    #[error(transparent)]
    Column(#[from] ColumnError),
    #[error(transparent)]
    LawFile(#[from] FitError),
    #[error(transparent)]
    Law(#[from] LawSpecError),
    #[error(transparent)]
    Quantity(#[from] UnitError),
}
