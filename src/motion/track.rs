//! One track, what a reader of a file returns, and the statements that complete a file.

use std::collections::HashSet;

/// Statements on a file that override what it says, or complete it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the coordinates, `mm`
    pub unit: Option<String>,
    /// Unit of the times of a table, `ms`
    pub time_unit: Option<String>,
    /// Frames per second, where the file has no times
    pub rate_hz: Option<f64>,
    /// Record of a table that holds several
    pub record: Option<String>,
}

/// One marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    pub name: String,
    /// Position at each time \[m\]; none where the marker was not seen
    pub points: Vec<Option<[f64; 3]>>,
}

/// Contents of a file before they are checked: lengths in the unit of the file.
pub(super) struct Raw {
    pub format: &'static str,
    pub unit: Option<String>,
    pub time_s: Vec<f64>,
    pub samples: Vec<f64>,
    pub markers: Vec<Track>,
    pub log: Vec<String>,
}

/// The first name that occurs a second time.
pub(super) fn twice<'a>(mut names: impl Iterator<Item = &'a String>) -> Option<&'a String> {
    let mut known = HashSet::new();
    names.find(|name| !known.insert(*name))
}
