//! A measured and a recorded curve, and their distance.

use crate::scene::Measured;
use serde::{Deserialize, Serialize};

/// Distance of a recorded curve from a measured one.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Distance {
    pub column: String,
    pub over: String,
    /// File of the measured curve
    pub file: String,
    /// Measured points in the range of both
    pub points: usize,
    /// The common range of `over`, in its unit
    pub from: f64,
    pub to: f64,
    /// ‖d‖₂/‖m‖₂ \[–\]
    pub l2: f64,
    /// max |d|/max |m| \[–\]
    pub largest: f64,
    /// Points with |d| within the uncertainty of the measured value, where that was given
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<usize>,
}

impl Distance {
    /// `12 of 15 points within the uncertainty`, where that was given
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
    /// Rows of the marker within the run
    pub rows: usize,
    /// Time of the run that these cover \[s\]
    pub from_s: f64,
    pub to_s: f64,
    pub rms_m: f64,
    pub largest_m: f64,
    /// Time of the run of the largest distance \[s\]
    pub largest_at_s: f64,
}

/// Both curves whole, for a figure, and their distance; none where they have less than two points in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    pub measured: Measured,
    /// \[rows\]
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub distance: Option<Distance>,
}
