//! The kinds of study, one folder each. A new kind is one folder and one line in [`KINDS`].

pub mod calibration;
pub mod comparison;
pub mod convergence;
pub mod cost;
pub mod robustness;
pub mod sweep;

use crate::study::kind::Kind;

/// Registry of the kinds.
pub const KINDS: [Kind; 6] = [
    Kind::of::<convergence::ConvergenceStudy>(),
    Kind::of::<comparison::ComparisonStudy>(),
    Kind::of::<sweep::SweepStudy>(),
    Kind::of::<cost::CostStudy>(),
    Kind::of::<calibration::CalibrationStudy>(),
    Kind::of::<robustness::RobustnessStudy>(),
];
