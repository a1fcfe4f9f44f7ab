//! Why a fit was refused: the fact and the remedy.

use super::Mode;
use std::path::PathBuf;

fn list<T: std::fmt::Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

fn at_line(line: &Option<u64>) -> String {
    line.map(|l| format!("line {l}: ")).unwrap_or_default()
}

#[derive(Debug, thiserror::Error)]
pub enum FitError {
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: cannot be written: {source}; choose another place", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{}: {message}", path.display())]
    Card { path: PathBuf, message: String },
    #[error(
        "{file}: no column of {missing} found; the columns are: {}; name the right ones with --strain-column and \
         --stress-column, or in card.toml under [columns]",
        list(found)
    )]
    Columns { file: String, missing: String, found: Vec<String> },
    #[error("{file}: {what} may be any of: {}; name the right one with --{flag}", list(candidates))]
    AmbiguousColumn { file: String, what: &'static str, flag: &'static str, candidates: Vec<String> },
    #[error(
        "{file}: column \"{column}\" is neither stretch nor engineering strain by its name; say which with --strain-kind stretch or --strain-kind engineering"
    )]
    StrainKind { file: String, column: String },
    #[error("{file}: column \"{column}\" has no unit; pass --stress-unit, for example --stress-unit MPa")]
    NoUnit { file: String, column: String },
    #[error(
        "{file}: column \"{column}\": unit \"{unit}\" is not one of {wanted}; write it as in \"{example}\", or pass --{flag}"
    )]
    Unit { file: String, column: String, unit: String, wanted: &'static str, example: &'static str, flag: &'static str },
    #[error("{file}: no row holds both a stretch and a stress; the first row left out: {reason}")]
    NoRows { file: String, reason: String },
    #[error(
        "{}\"{word}\" is not a mode of deformation; known: uniaxial, equibiaxial, planar (pure_shear)",
        at_line(line)
    )]
    ModeWord { line: Option<u64>, word: String },
    #[error("{file}: does not say how the test piece was stretched; pass --mode uniaxial, equibiaxial or planar")]
    NoMode { file: String },
    #[error(
        "{file}: holds several modes ({}); pass --mode with the one to fit, or several to fit them together",
        list(present)
    )]
    ChooseMode { file: String, present: Vec<Mode> },
    #[error("{file}: holds no {mode} rows; present: {}", list(present))]
    AbsentMode { file: String, mode: Mode, present: Vec<Mode> },
    #[error("law \"{name}\" cannot be fitted; did you mean \"{nearest}\"? Known: {}", list(known))]
    UnknownLaw { name: String, nearest: &'static str, known: Vec<&'static str> },
    #[error("range \"{text}\": {reason}; write two stretches such as --range 1..1.6")]
    Range { text: String, reason: &'static str },
    #[error(
        "stretch {from} to {to} holds {rows} rows that say something about the law, {needed} are needed; the data \
         reach from {data_from} to {data_to}: widen --range"
    )]
    TooFewRows { from: f64, to: f64, rows: usize, needed: usize, data_from: f64, data_to: f64 },
    #[error(
        "every stress in the fitted rows is zero: any law would get zero stiffness; check the stress column and its unit"
    )]
    ZeroStress,
    #[error(
        "the stresses point against the stretch (cosine between data and law {cosine:.3}): no positive stiffness fits \
         them; check the sign of the stress column and whether strain was read as stretch"
    )]
    NotPositive { cosine: f64 },
    #[error("{solver} did not finish ({status}) on a problem with one minimum; please report the data file")]
    Solver { solver: &'static str, status: String },
    #[error(
        "clarabel and least squares disagree: their stresses differ by {difference:e} of the data, above {tolerance:e}; please report \
         the data file"
    )]
    Disagree { difference: f64, tolerance: f64 },
    #[error("law {law} cannot be fitted with {terms} terms; pass --terms with one of {}", list(known))]
    Terms { law: &'static str, terms: usize, known: &'static [usize] },
    #[error("volumetric = \"{option}\": {remedy}")]
    Volumetric { option: String, remedy: String },
    #[error("{name} = {value}: must lie {allowed}; {remedy}")]
    Partner { name: &'static str, value: f64, allowed: &'static str, remedy: &'static str },
    #[error("{first} and {second} hold the same bytes; give each specimen once")]
    SameFile { first: String, second: String },
    #[error(
        "{file}: only {rows} of its rows take part, fewer than the law has constants; leave the file out, or widen --range"
    )]
    ShortSpecimen { file: String, rows: usize },
    #[error("{}: {message}", path.display())]
    LawFile { path: PathBuf, message: String },
}
