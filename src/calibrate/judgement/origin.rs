//! Specimen, test and curve of each data point.

use super::curve_errors::curves;
use super::repeats::Repeats;
use crate::calibrate::Sample;
use crate::calibrate::sample::tests;

/// Where the data points come from.
#[derive(Clone, PartialEq, Debug)]
pub struct Origin {
    /// Specimen of each data point
    pub specimen: Vec<usize>,
    /// Test of each data point; several specimens of one test are repeats
    pub test: Vec<usize>,
    /// Data points of each curve, in order of loading
    pub curves: Vec<Vec<usize>>,
}

impl Origin {
    /// The origin of samples; the number of a test is only a label.
    pub fn of(samples: &[Sample]) -> Self {
        Self {
            specimen: samples.iter().map(|s| s.specimen).collect(),
            test: tests(samples).iter().map(|t| 2 * t.mode as usize + usize::from(t.compression)).collect(),
            curves: curves(samples),
        }
    }

    /// The tests, grouped by the number of their specimens.
    pub fn repeats(&self) -> Repeats<usize> {
        Repeats::of(self.test.iter().copied().zip(self.specimen.iter().copied()))
    }
}
