//! Calibration: from a tensile table to the constants of a law, with an interval and a judgement.
//!
//! [`fit()`] is the entry point: it reads a table ([`Experiment`]), fits one of the [`fittable_laws`] to closed-form stresses and returns a
//! [`FitResult`]. Nothing here prints or draws; [`FitCurves`] is what a figure needs, [`FitResult::write_json`] and
//! [`FitResult::write_law`] store the answer.

mod audit;
mod card;
mod certificate;
mod columns;
mod compare;
mod constant_format;
mod curves;
mod cycle;
mod dimensions;
mod error;
mod errors;
mod estimate;
mod experiment;
mod fit;
mod identify;
mod intake;
pub mod inverse;
mod judgement;
mod law_file;
mod linear;
mod misfit;
mod mode;
mod model;
mod names;
mod noise;
mod nonnegative;
mod offset;
mod prepare;
mod profile;
mod request;
mod result;
mod rows;
mod sample;
mod separable;
mod slack;
mod solve;
mod solver_check;
mod specimen;
pub(crate) mod statistics;
mod table;
mod treatment;
mod unusual;
mod warning;

pub use audit::{Audit, AuditEntry, AuditKind};
pub use card::{Card, Source};
pub use certificate::StableRange;
pub use columns::ColumnChoice;
pub use compare::{Compared, Comparison, compare, compare_experiment};
pub use constant_format::{stress_unit, stretch_text, within};
pub use curves::{FitCurves, ModeCurves};
pub use cycle::Cycle;
pub use dimensions::Dimensions;
pub use error::FitError;
pub use errors::ErrorModel;
pub use estimate::{Direction, Estimate};
pub use experiment::Experiment;
pub use fit::{fit, fit_experiment};
pub use law_file::{read_law_file, read_law_table};
pub use misfit::{Misfit, Residual};
pub use mode::{Mode, UnknownMode};
pub use model::{Model, fittable_laws};
pub use names::{StrainKind, StressKind};
pub use offset::SlackChoice;
pub use request::{FitOptions, FitRequest, Loss, Partner, StretchRange, Weighting};
pub use result::{FitResult, Otherwise, Prediction, PredictionKind, RangeRow, Validity};
pub use sample::{RawRow, Sample};
pub use slack::Slack;
pub use solver_check::SolverCheck;
pub use specimen::{Band, Scatter, Specimen};
pub use table::Decimal;
pub use treatment::{Alternative, Preparation, Treatment};
pub use warning::FitWarning;
