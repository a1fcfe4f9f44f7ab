//! The kinds of study, one folder each. A new kind is one folder and one line in [`KINDS`].

pub mod calibration;
pub mod comparison;
pub mod convergence;
pub mod cost;
pub mod coverage;
pub mod reduction;
pub mod robustness;
pub mod sweep;
pub mod validation;

use crate::study::kind::Kind;

/// Registry of the kinds.
pub const KINDS: [Kind; 9] = [
    Kind::of::<convergence::ConvergenceStudy>(),
    Kind::of::<comparison::ComparisonStudy>(),
    Kind::of::<sweep::SweepStudy>(),
    Kind::of::<cost::CostStudy>(),
    Kind::of::<calibration::CalibrationStudy>(),
    Kind::of::<coverage::CoverageStudy>(),
    Kind::of::<robustness::RobustnessStudy>(),
    Kind::of::<validation::ValidationStudy>(),
    Kind::of::<reduction::spec::ReductionStudy>(),
];

/// Returns the kind with this name.
pub fn find(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}
