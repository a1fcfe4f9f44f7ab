//! A single track, the result of a file reader, and the options that complete a file.

use std::collections::HashSet;

/// Statements about a file that override or complete its content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the coordinates, such as `mm`
    pub unit: Option<String>,
    /// Unit of the times of a table, such as `ms`
    pub time_unit: Option<String>,
    /// Frames per second, if the file has no times or wrong ones
    pub rate_hz: Option<f64>,
    /// Record to read from a table that contains several
    pub record: Option<String>,
}

/// The track of one marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    pub name: String,
    /// Position at each time \[m\]; `None` where the marker was not visible
    pub points: Vec<Option<[f64; 3]>>,
}

/// Contents of a file before they are checked; lengths are in the unit of the file.
pub(super) struct Raw {
    pub format: &'static str,
    pub unit: Option<String>,
    pub time_s: Vec<f64>,
    pub samples: Vec<f64>,
    pub markers: Vec<Track>,
    pub log: Vec<String>,
}

/// Returns the first name that occurs a second time.
pub(super) fn twice<'a>(mut names: impl Iterator<Item = &'a String>) -> Option<&'a String> {
    let mut known = HashSet::new();
    names.find(|name| !known.insert(*name))
}
