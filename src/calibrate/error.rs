//! Errors of a fit: the fact and the remedy.

use super::constant_format::stretch_text;
use super::{Mode, UnknownMode};
use crate::storage::columns::TableError;
use crate::wording::{either, hint, joined, lines};
use std::path::PathBuf;

/// Reasons why a fit could not be made, each with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    #[error(
        "law {law} needs Poisson's ratio: a column of lateral strain next to the strain, or --nu (0 of a foam that does not spread); {reason}"
    )]
    NoPoisson { law: &'static str, reason: String },
    #[error(
        "the interval of Poisson's ratio by the lateral strain is {low:.4} and above, up to 0.5: the material keeps its volume, and is none for law {law}; fit ogden"
    )]
    NoFoam { law: &'static str, low: f64 },
    #[error("--slack yes: {reason}; pass --slack no")]
    Slack { reason: &'static str },
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: cannot be written: {source}; choose another place", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{}: {message}", path.display())]
    Card { path: PathBuf, message: String },
    #[error(
        "{file}: no column of {missing} found; the columns are: {}; name the right ones with --strain-column and \
         --stress-column, or in card.toml under [columns]",
        joined(found)
    )]
    Columns { file: String, missing: String, found: Vec<String> },
    #[error(
        "{file}: line {line} holds numbers, and no line above names the columns; choose them by their numbers, with what they hold, for example \
         --strain-column \"#1\" --strain-kind stretch --stress-column \"#2\" --stress-unit MPa, or write a line of names above"
    )]
    NoNames { file: String, line: u64 },
    #[error(
        "{file}: {what} may be any of: {}; name the right one with --{flag}, by its name or by its number such as \"#2\"",
        joined(candidates)
    )]
    AmbiguousColumn { file: String, what: &'static str, flag: &'static str, candidates: Vec<String> },
    #[error(
        "{file}: column \"{column}\" is neither stretch nor engineering strain by its name; say which with --strain-kind stretch, engineering, true or displacement"
    )]
    StrainKind { file: String, column: String },
    #[error("{file}: column \"{column}\" has no unit; pass --{flag}, for example --{flag} {example}")]
    NoUnit { file: String, column: String, flag: &'static str, example: &'static str },
    #[error(
        "{file}: {} tests stand side by side ({}); choose one with --test 1 to --test {}",
        tests.len(), joined(tests), tests.len()
    )]
    SideBySide { file: String, tests: Vec<String> },
    #[error("{file}: --test {asked} asks for a test that is not there: {found} stand side by side")]
    NoTest { file: String, asked: usize, found: usize },
    #[error("{table}{}", if table.is_of_mark() { ", or pass --decimal comma or --decimal point" } else { "" })]
    Table {
        #[from]
        table: TableError,
    },
    #[error("{file}: column \"{column}\" {fact}: {remedy}")]
    Meaning { file: String, column: String, fact: String, remedy: String },
    #[error(
        "{file}: {said}, but the data points are in tension; pass --positive compression where the \
         machine counts it as positive, or --positive tension"
    )]
    Compression { file: String, said: String },
    #[error(
        "{file}: line {line} names columns of strain and stress again, and differently; divide the file into one table for each specimen"
    )]
    OtherNames { file: String, line: u64 },
    #[error(
        "{file}: the table of line {line} has other dimensions of the test piece than the first one; divide the file into one table for each \
         specimen"
    )]
    OtherDimensions { file: String, line: u64 },
    #[error(
        "{file}: time and stretch start again in {}: the file holds several tests; divide it, add a column \"specimen\", or choose a \
         loading with --cycle",
        lines(restarts)
    )]
    Restarts { file: String, restarts: Vec<u64> },
    #[error(
        "{file}: a biaxial test needs two columns of {what}, found: {}; name them with --{flag} and --{flag}-2",
        joined(candidates)
    )]
    TwoColumns { file: String, what: &'static str, flag: &'static str, candidates: Vec<String> },
    #[error(
        "{file}: line {line}: biaxial data points need --mode biaxial for the whole table, and two columns each of strain and stress"
    )]
    BiaxialRow { file: String, line: u64 },
    #[error(
        "{file}: column \"{column}\" has no unit and makes a stretch of {largest:.4}: is this {kind} in percent? Pass --strain-unit %, or \
         --strain-unit 1 if it is not"
    )]
    Percent { file: String, column: String, largest: f64, kind: &'static str },
    #[error("{key} = \"{text}\": {reason}")]
    Dimension { key: &'static str, text: String, reason: String },
    #[error(
        "[specimen] of the card has `{key}`, which is no dimension of a test piece; write `{meant}`, or rename it if it is something else"
    )]
    Misspelt { key: String, meant: String },
    #[error("--accuracy {key} = \"{text}\": {reason}")]
    Accuracy { key: String, text: String, reason: String },
    #[error(
        "the error of the {error} cannot be judged without {what} of the test piece; pass --{flag}, or give it in card.toml under [specimen]"
    )]
    ErrorNeeds { error: &'static str, what: &'static str, flag: &'static str },
    #[error(
        "{file}: --compliance corrects the travel of the crosshead, but the strain was measured with \"{instrument}\"; leave it out"
    )]
    Compliance { file: String, instrument: String },
    #[error(
        "{file}: column \"{column}\" is a force: give the undeformed cross-section with --width and --thickness, --diameter or --area, or \
         under [specimen] of a card.toml with name, file and status"
    )]
    NoSection { file: String, column: String },
    #[error(
        "{file}: the cross-section is {first:.4} mm² from one set of dimensions and {second:.4} mm² from another; give one of them"
    )]
    Sections { file: String, first: f64, second: f64 },
    #[error(
        "{file}: column \"{column}\" is a true stress, which a law with a change of volume takes with the lateral strain, and {}; name that column with --lateral-column, or give the nominal stress",
        if candidates.is_empty() { "no column holds it".into() } else { format!("any of these may hold it: {}", joined(candidates)) }
    )]
    TrueStress { file: String, column: String, candidates: Vec<String> },
    #[error(
        "{file}: column \"{column}\" is a displacement: give the length that it stretches with --gauge-length, or gauge_length under \
         [specimen] of a card.toml with name, file and status"
    )]
    NoLength { file: String, column: String },
    #[error(
        "{file}: several lines above the table may give the {} of the test piece: {}; pass --{}, or give {key} in card.toml under [specimen]",
        key.replace('_', " "),
        joined(lines),
        key.replace('_', "-")
    )]
    UnclearDimension { file: String, key: &'static str, lines: Vec<String> },
    #[error("{file}: --cycle {asked} asks for a loading that is not there: the table has {found}")]
    NoCycle { file: String, asked: usize, found: usize },
    #[error("{file}: --zero {asked}: the {mode} test has {rows} data points; give a number from 1 to half of them")]
    Zero { file: String, mode: Mode, asked: usize, rows: usize },
    #[error("{file}: --toe \"{level}\": {reason}")]
    Toe { file: String, level: String, reason: String },
    #[error(
        "the {mode} data points do not give a noise level ({rows} of different stretch that vary about a smooth curve; 5 are needed): pass \
         --noise with the standard deviation of the stress, such as --noise \"2 kPa\""
    )]
    NoNoise { mode: Mode, rows: usize },
    #[error(
        "--noise {std_pa} Pa is no standard deviation that can be divided by; give a positive one, such as --noise \"2 kPa\", or leave it out to \
         estimate it from the data"
    )]
    Noise { std_pa: f64 },
    #[error("--noise has no effect without --weight noise; pass both, or neither")]
    IdleNoise,
    #[error(
        "{file}: the largest strain is {strain:.3e}, below {least:.0e}: the answer would be the rounding of the stretches; check the strain column \
         and its unit, or widen --range"
    )]
    TinyStrain { file: String, strain: f64, least: f64 },
    #[error(
        "{file}: column \"{column}\": unit \"{unit}\" is not one of {wanted}; write it as in \"{example}\", or pass --{flag}"
    )]
    Unit { file: String, column: String, unit: String, wanted: &'static str, example: &'static str, flag: &'static str },
    #[error("{file}: no line holds both a stretch and a stress; the first line left out: {reason}")]
    NoRows { file: String, reason: String },
    #[error(transparent)]
    Mode(#[from] UnknownMode),
    #[error(
        "{file}: does not say how the test piece was stretched; pass --mode uniaxial, equibiaxial, planar, simple_shear or biaxial"
    )]
    NoMode { file: String },
    #[error(
        "{file}: holds several modes ({}); pass --mode with the one to fit, or several to fit them together",
        joined(present)
    )]
    ChooseMode { file: String, present: Vec<Mode> },
    #[error(
        "{file}: no column says which data points are {}; add one called \"mode\", or give each mode a table and fit it by itself",
        either(modes)
    )]
    NoModeColumn { file: String, modes: Vec<Mode> },
    #[error("--{flag} has no effect here: {why}; leave it out")]
    Idle { flag: &'static str, why: &'static str },
    #[error("{file}: holds no {mode} data; present: {}", joined(present))]
    AbsentMode { file: String, mode: Mode, present: Vec<Mode> },
    #[error("law \"{name}\" cannot be fitted; {}", hint(name, known))]
    UnknownLaw { name: String, known: Vec<&'static str> },
    #[error("range \"{text}\": {reason}; write two stretches such as --range 1..1.6")]
    Range { text: String, reason: &'static str },
    #[error(
        "stretch {} to {} holds {rows} data points that carry information on the law, {needed} are needed; the data \
         reach from {} to {}: widen --range",
        stretch_text(*from),
        stretch_text(*to),
        stretch_text(*data_from),
        stretch_text(*data_to)
    )]
    TooFewRows { from: f64, to: f64, rows: usize, needed: usize, data_from: f64, data_to: f64 },
    #[error(
        "every stress in the fitted range is zero: any law would get zero stiffness; check the stress column and its unit"
    )]
    ZeroStress,
    #[error(
        "the stresses point against the stretch (cosine between data and law {cosine:.3}): no positive stiffness fits \
         them; where the machine counts a force in tension as negative, pass --stress-positive compression, and check whether \
         strain was read as stretch"
    )]
    NotPositive { cosine: f64 },
    #[error("the fit was stopped; run it again")]
    Interrupted,
    #[error("{solver} did not finish ({status}) on a problem with one minimum; please report the data file")]
    Solver { solver: &'static str, status: String },
    #[error(
        "clarabel and least squares disagree: their stresses differ by {difference:e} of the data, above {tolerance:e}; please report \
         the data file"
    )]
    Disagree { difference: f64, tolerance: f64 },
    #[error("law {law} cannot be fitted with {terms} terms; pass --terms with one of {}", joined(known))]
    Terms { law: &'static str, terms: usize, known: &'static [usize] },
    #[error("volumetric = \"{option}\": {remedy}")]
    Volumetric { option: String, remedy: String },
    #[error("{name} = {value}: must lie {allowed}; {remedy}")]
    Partner { name: &'static str, value: f64, allowed: &'static str, remedy: &'static str },
    #[error("{first} and {second} hold the same numbers, and would count as two specimens; give each specimen once")]
    SameData { first: String, second: String },
    #[error(
        "{file}: only {rows} of its data points take part, fewer than the law has constants; leave the file out, or widen --range"
    )]
    ShortSpecimen { file: String, rows: usize },
    #[error("{}: {message}", path.display())]
    LawFile { path: PathBuf, message: String },
    #[error(
        "{}: holds no law file that can be listed; give a folder with law files as `durometer fit` or `durometer laws import` writes them{}{skipped}",
        path.display(),
        if skipped.is_empty() { "" } else { "\n" }
    )]
    NoLaws { path: PathBuf, skipped: String },
}

/// A dimension for which several lines of a header give different values.
#[derive(Clone, Debug)]
pub struct Unclear {
    pub key: &'static str,
    pub lines: Vec<String>,
}

impl FitError {
    /// This error, or, if it is about a missing dimension that the lines above the table give differently, the error that names these lines.
    pub(super) fn with_unclear(self, file: &str, unclear: &[Unclear]) -> Self {
        let is_missed = |u: &&Unclear| match self {
            Self::NoLength { .. } | Self::ErrorNeeds { flag: "gauge-length", .. } => u.key == "gauge_length",
            Self::NoSection { .. } | Self::ErrorNeeds { flag: "area", .. } => u.key != "gauge_length",
            _ => false,
        };
        match unclear.iter().find(is_missed) {
            Some(Unclear { key, lines }) => Self::UnclearDimension { file: file.into(), key, lines: lines.clone() },
            None => self,
        }
    }
}
