//! Judgement of a fit: errors and intervals of its constants, predictions, range of validity, warnings.
//!
//! | Subject | File |
//! |---|---|
//! | Where a data point is from: its specimen, test and curve | `origin`, `repeats` |
//! | Misfit, and the slack that is fitted with the law | `misfit`, `slack` |
//! | Constants with their intervals, and directions that the data leave open | `estimate`, `identify`, `directions`, `determined`, `profile` |
//! | Errors of the data points, and the model of them that the data show | `errors`, `error_model` |
//! | Models within one specimen: correlated errors, errors of unequal size | `curve_errors`, `correlated`, `correlation`, `unequal` |
//! | Models of several specimens | `clusters`, `levels`, `specimen` |
//! | Errors that all data points share | `measurement` |
//! | Other answers: of shorter ranges, of constants with the other sign | `ranges`, `mirrored` |
//! | What the law gives elsewhere, and where it holds | `predictions`, `validity`, `certificate`, `compressibility` |
//! | Warnings | `warning`, `warnings` |

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
