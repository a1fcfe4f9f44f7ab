//! A test piece with what is known of the errors of its test.

use super::accuracy::{Accuracy, SharedError};
use super::dimensions::Dimensions;
use crate::calibrate::Mode;
use crate::calibrate::sample::Test;

/// A test piece.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    pub dimensions: Dimensions,
    /// 95 % half-widths of the errors that its data points share, from its card
    pub accuracy: Accuracy,
    /// Errors of the corrections of its curves
    pub corrections: Vec<CorrectionError>,
}

/// Error that a correction leaves in all data points of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectionError {
    pub error: SharedError,
    pub mode: Mode,
    /// The correction is of one side of rest alone: tension (`true`) or compression (`false`)
    pub tension: Option<bool>,
    /// Half-width of the 95 % interval \[SI\], infinite if the curve does not determine it
    pub half_width: f64,
    /// For a zero from a single data point: the error is bounded by the scatter of the curve about the law
    pub bounded: bool,
    /// For a toe: shift of the strain that an error of the stress causes \[1/Pa\]
    pub strain_per_stress: f64,
    /// For a toe: strains of the data points of its line, without the toe
    pub line: Vec<f64>,
}

impl CorrectionError {
    /// The error of a correction of one curve, with defaults for all that depends on the correction.
    pub fn of(error: SharedError, mode: Mode, half_width: f64) -> Self {
        Self { error, mode, tension: None, half_width, bounded: false, strain_per_stress: 0.0, line: vec![] }
    }

    fn is_of(&self, test: Test) -> bool {
        self.mode == test.mode && self.tension.is_none_or(|tension| tension != test.compression)
    }
}

impl Piece {
    /// The errors that data points of a test share, with their half-widths \[SI\]; requested errors take precedence over those of the card. An error
    /// of the zero in the card does not apply to a curve whose zero was corrected.
    pub fn errors(&self, test: Test, asked: &Accuracy) -> Accuracy {
        let made = || self.corrections.iter().filter(|c| c.is_of(test));
        let mut card = self.accuracy.clone();
        for zero in made().flat_map(|c| c.error.taken_off()) {
            card.0.remove(zero);
        }
        let mut all = asked.or(&card);
        all.0.extend(made().map(|c| (c.error, c.half_width)));
        all
    }

    /// The correction of the curve of a test that leaves this error.
    pub fn correction(&self, error: SharedError, test: Test) -> Option<&CorrectionError> {
        self.corrections.iter().find(|c| c.error == error && c.is_of(test))
    }
}
