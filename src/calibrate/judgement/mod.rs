//! Judgement of a fit: errors and intervals of its constants, predictions, range of validity, warnings.

pub(super) mod certificate;
mod clusters;
pub(super) mod compressibility;
mod correlated;
pub(in crate::calibrate) mod correlation;
mod curve_errors;
pub(super) mod determined;
mod directions;
pub(crate) mod error_model;
pub(crate) mod errors;
pub(super) mod estimate;
pub(super) mod identify;
mod levels;
pub(super) mod measurement;
pub(super) mod mirrored;
pub(super) mod misfit;
pub(super) mod origin;
pub(super) mod outliers;
mod predictions;
pub(super) mod profile;
pub(super) mod ranges;
pub(super) mod repeats;
pub(super) mod slack;
pub(super) mod specimen;
mod unequal;
mod validity;
pub(super) mod warning;
mod warnings;

pub use predictions::predictions;
pub use validity::validity;
pub use warnings::{no_repeat, slack_hint, systematic, unequal, warnings};
