//! A measured and a recorded curve, and the distance between them.

use crate::report::numbers::significant;
use crate::scene::Measured;
use crate::scene::column::words;
use serde::{Deserialize, Serialize};

/// Distance of a recorded curve from a measured one.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Distance {
    pub column: String,
    pub over: String,
    /// File of the measured curve
    pub file: String,
    /// Columns of the file, as in [`Measured`]
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub columns: String,
    /// Measured points within the range of both curves
    pub points: usize,
    /// Measured points on the branch that is compared
    #[serde(default)]
    pub on_branch: usize,
    /// All measured points; 0 in records of earlier versions
    #[serde(default)]
    pub in_table: usize,
    /// The common range of `over`, in its unit
    pub from: f64,
    pub to: f64,
    /// ‖d‖₂/‖m‖₂ \[–\]
    pub l2: f64,
    /// max |d|/max |m| \[–\]
    pub largest: f64,
    /// Points with |d| within the uncertainty of the measured value, if that is given
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<usize>,
}

/// File of a measured curve with its columns if they are known: `two.csv, F over t`
pub(super) fn origin(file: &str, columns: &str) -> String {
    if columns.is_empty() { file.into() } else { format!("{file}, {columns}") }
}

impl Distance {
    /// Whether this is the distance from a measured curve.
    pub(super) fn is_from(&self, m: &Measured) -> bool {
        [&self.column, &self.over, &self.file, &self.columns] == [&m.column, &m.over, &m.source, &m.columns]
    }

    /// File and columns of the measured curve
    pub fn origin_words(&self) -> String {
        origin(&self.file, &self.columns)
    }

    /// Number of compared points and of all points in the table: `34 of 600`
    pub fn share_words(&self) -> String {
        match self.in_table {
            0 => self.points.to_string(),
            all => format!("{} of {all}", self.points),
        }
    }

    /// The common range in words: `0 to 59.0 °`
    pub fn range_words(&self) -> String {
        let [from, to] = [self.from, self.to].map(|x| significant(x, 3));
        format!("{from} to {to} {}", words(&self.over).1).trim_end().into()
    }

    /// Points within the uncertainty, if that is given: `12 of 15 points within the uncertainty`
    pub fn inside_words(&self) -> Option<String> {
        self.inside.map(|inside| format!("{inside} of {} points within the uncertainty", self.points))
    }
}

/// Distance of a recorded point from a measured marker.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct MarkerDistance {
    pub marker: String,
    /// Recorded point
    pub point: String,
    /// File of the tracks
    pub file: String,
    /// Number of rows of the marker within the run
    pub rows: usize,
    /// Times of the run that these rows cover \[s\]
    pub from_s: f64,
    pub to_s: f64,
    pub rms_m: f64,
    pub largest_m: f64,
    /// Time at which the distance is largest \[s\]
    pub largest_at_s: f64,
}

/// Both curves in full, for a figure, and their distance; `None` if they have fewer than two points in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    pub measured: Measured,
    /// \[rows\]
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub distance: Option<Distance>,
}
