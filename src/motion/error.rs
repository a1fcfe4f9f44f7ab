//! Refusals of measured motion, each with place, fact and remedy.

use crate::calibrate::within;
use crate::math::units::shown;
use crate::storage::columns::TableError;
use crate::wording::{all, count, first};
use std::fmt;
use std::path::PathBuf;

/// Reason why measured motion was not read, registered or evaluated.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: cannot be written: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{file}: {what}; export the data as C3D, TRC or a table of text (CSV)")]
    NotText { file: String, what: String },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("{file}: the C3D file is damaged: {what}; export it again")]
    Damaged { file: String, what: String },
    #[error("{file}: the header announces {told} frames of {markers} markers, the file holds {found}; export it again")]
    Truncated { file: String, told: usize, markers: usize, found: usize },
    #[error("{file}: it holds no marker; export the trajectories of labelled markers")]
    NoMarkers { file: String },
    #[error(
        "{file}: no line names columns of markers; the nearest one has {}. Known are names such as t_s,tip_x_mm,tip_y_mm,tip_z_mm, or marker,t_s,x_mm,y_mm,z_mm in one row per marker", found.join(", ")
    )]
    Columns { file: String, found: Vec<String> },
    #[error("{file}: {} without a coordinate: {}; a marker has three columns", count(markers.len(), "marker"), first(markers))]
    Incomplete { file: String, markers: Vec<String> },
    #[error("{file}: it holds {} records: {}; choose one with --record NAME", records.len(), first(records))]
    Records { file: String, records: Vec<String> },
    #[error("{file}: there is no record \"{asked}\"; known: {}", first(known))]
    NoRecord { file: String, asked: String, known: Vec<String> },
    #[error("{file}: {fact}, so that {option} has no meaning; leave it out")]
    Unused { file: String, option: &'static str, fact: &'static str },
    #[error("{file}: the unit of the coordinates is not stated; pass --unit mm, or the unit that it is")]
    NoUnit { file: String },
    #[error("{file}: \"{unit}\" is no unit of {of}; wanted is one such as {example}")]
    Unit { file: String, unit: String, of: &'static str, example: &'static str },
    #[error("{file}: columns of different units: {}; state one unit for all, or pass --unit", first(units))]
    Units { file: String, units: Vec<String> },
    #[error("{file}: the rate is {rate} Hz, so that no frame has a time; pass --rate with the frames per second")]
    Rate { file: String, rate: f64 },
    #[error("{file}: {} cells are no numbers: {}; write numbers, or leave all three cells of a marker empty where it was not seen", cells.len(), first(cells))]
    Cells { file: String, cells: Vec<String> },
    #[error("{file}: {} positions have one or two coordinates of three: {}; complete them, or leave all three cells empty where the marker was not seen", at.len(), first(at))]
    Partial { file: String, at: Vec<String> },
    #[error("{file}: {} times are no numbers: {}; write them in seconds, or pass --rate with the frames per second", cells.len(), first(cells))]
    Clock { file: String, cells: Vec<String> },
    #[error("{file}: column \"{name}\" occurs twice; give one of the two another name, or remove it")]
    Column { file: String, name: String },
    #[error(
        "{file}: marker {name} is at exactly 0, 0, 0 in {found} of {rows} rows, to which it jumps from elsewhere: a program wrote zeros where it was not seen; export these rows as gaps, in a table as three empty cells"
    )]
    Zeros { file: String, name: String, found: usize, rows: usize },
    #[error("{file}: the {what} do not increase in {} lines: {}; a record is one run in the order of time", lines.len(), first(lines))]
    Times { file: String, what: &'static str, lines: Vec<u64> },
    #[error("{file}: marker \"{name}\" occurs twice{}; every marker needs a name of its own", at.as_ref().map_or(String::new(), |at| format!(" {at}")))]
    Twice { file: String, name: String, at: Option<String> },
    #[error(
        "{file}: {} lines are means of another number of samples than the first row of their time: {}; the rows of one time need one number, so average all markers over the same samples, or remove the column",
        lines.len(), first(lines)
    )]
    Uneven { file: String, lines: Vec<u64> },
    #[error(
        "{file}: the markers have different numbers of rows ({}), so that --rate gives them no times; write a row with three empty cells where a marker was not seen, or a column \"frame\" with the numbers of the frames",
        first(counts)
    )]
    Frames { file: String, counts: Vec<String> },
    #[error(
        "{file}: coordinates reach {largest_m} m, which no tracked body has ({samples} samples are above {limit_m} m); the unit is probably off by 1000: pass --unit, or remove samples that are no markers"
    )]
    Large { file: String, largest_m: f64, samples: usize, limit_m: f64 },
    #[error(
        "{file}: every coordinate is below {limit_m} m ({largest_m} m at most); the unit is probably off by 1000: pass --unit"
    )]
    Small { file: String, largest_m: f64, limit_m: f64 },
    #[error(
        "the points to register are {ratio:.4} times as large as the measured ones: {meaning}; state the right unit"
    )]
    Size { ratio: f64, meaning: String },
    #[error(
        "the held state fits {reference} as its mirror image (rms {:.4} mm), and not as it is (rms {:.4} mm): one of the two is in a left-handed frame, or names of markers are exchanged; change the sign of one coordinate of the record, of which any will do since the registration turns the rest, or correct the names",
        1e3 * mirrored_rms, 1e3 * rms
    )]
    Mirrored { reference: String, rms: f64, mirrored_rms: f64 },
    #[error("there are no markers {}; known: {}", asked.join(", "), known.join(", "))]
    UnknownMarkers { asked: Vec<String>, known: Vec<String> },
    #[error("a rigid group needs three points or more, {found} are given: {}; name more markers that move with the body", names.join(", "))]
    TooFew { found: usize, names: Vec<String> },
    #[error(
        "the points lie on one line (their extent across it is {across_m:.3e} m, along it {along_m:.3e} m), so that the rotation about it is not determined; name a marker off the line"
    )]
    Collinear { along_m: f64, across_m: f64 },
    #[error("{first} and {second} hold the same positions, which are no repeats; name each record once")]
    SameRecord { first: String, second: String },
    #[error("{what} is not a finite number; remove it")]
    NotFinite { what: String },
    #[error("{} lists of {what} have different lengths: {}", lengths.len(), lengths.iter().map(usize::to_string).collect::<Vec<_>>().join(", "))]
    Lengths { what: &'static str, lengths: Vec<usize> },
    #[error("{} of markers: {}; name the tracks anew in the recording program from these frames on", count(swaps.len(), "exchange"), first(swaps))]
    Swapped { swaps: Vec<Swap> },
    #[error("markers {} are never seen at the same time; a rigid motion needs three of them at once", names.join(", "))]
    NeverSeen { names: Vec<String> },
    #[error(
        "the curve has {found} samples in {from_s} s to {to_s} s, and {needed} are needed{}", recorded(*.step_s)
    )]
    TooShort { found: usize, needed: usize, from_s: f64, to_s: f64, step_s: f64 },
    #[error(
        "no state is held: the curve neither begins nor ends within ±{} of one level for {} s; take a record that is at rest before or after the motion, or state the window of the held state",
        in_unit(.tolerance, .curve),
        shown(*.least_s)
    )]
    NoPlateau { curve: String, least_s: f64, tolerance: f64 },
    #[error("the curve never leaves the held plateau by more than {}; take a smaller threshold", in_unit(.limit, .curve))]
    NoRelease { curve: String, limit: f64 },
    #[error(
        "there was no release, from which the window of a ring-down counts; state the window of the held state with --held"
    )]
    Unreleased,
    #[error("the window {from_s} s to {to_s} s {fact}; {remedy}")]
    Window { from_s: f64, to_s: f64, fact: &'static str, remedy: &'static str },
    #[error("no ring-down in {from_s} s to {to_s} s: {fact}; {remedy}")]
    NoRingDown { from_s: f64, to_s: f64, fact: String, remedy: &'static str },
    #[error("there is no curve \"{asked}\"; known: {}", known.join(", "))]
    NoCurve { asked: String, known: Vec<String> },
}

/// The remedy for a window with too few rows, which are `step_s` \[s\] apart.
fn recorded(step_s: f64) -> String {
    // No motion-capture camera records less than one frame per second
    if step_s >= 1.0 {
        format!(
            ": its rows are {} s apart; state the unit of the times with --time-unit if they are no seconds",
            shown(step_s)
        )
    } else {
        "; take a longer window, or record faster".into()
    }
}

/// Formats a length or an angle of a curve whose name ends with its unit.
fn in_unit(value: &f64, curve: &str) -> String {
    let (factor, unit) = if curve.ends_with("_m") { (1e3, "mm") } else { (1.0, "deg") };
    within(factor * value, unit, None).text(factor * value)
}

/// A cyclic exchange of tracks.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// Names of the markers: from this time on each carries the name of the next, and the last one that of the first
    pub names: Vec<String>,
    /// Time of the first row with exchanged names \[s\]
    pub time_s: f64,
}

impl fmt::Display for Swap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {} s", all(&self.names), self.time_s)
    }
}
