//! Calibration: from a tensile table to the constants of a law, with an interval and a judgement.
//!
//! [`fit()`] is the entry point: it reads a table ([`Experiment`]), fits one of the [`fittable_laws`] to closed-form stresses and returns a
//! [`FitResult`]. Nothing here prints or draws; [`FitCurves`] is what a figure needs, [`FitResult::write_json`] and
//! [`FitResult::write_law`] store the answer.

mod bounded;
mod compare;
mod constant_format;
mod curves;
mod error;
mod fit;
mod fittable_law;
pub(crate) mod intake;
pub mod inverse;
pub(crate) mod judgement;
mod law_file;
mod library;
mod mode;
mod partner;
mod poisson;
pub mod relaxation;
mod request;
mod result;
pub(crate) mod same_data;
mod sample;
pub mod softening;
mod solve;
mod summary;
mod treatment;
pub mod volume;

pub use bounded::Bounded;
pub use compare::{Compared, Comparison, compare, compare_experiment};
pub use constant_format::{Printed, largest_stress, stress_unit, stretch_text, within, within_size};
pub use curves::{FitCurves, ModeCurves};
pub use error::FitError;
pub use fit::{fit, fit_experiment};
pub use fittable_law::{FittableLaw, fittable_laws};
pub use intake::accuracy::{Accuracy, SharedError};
pub use intake::audit::{Audit, AuditEntry, AuditKind};
pub use intake::card::{Card, Source};
pub use intake::columns::{ColumnChoice, Sign};
pub use intake::dimensions::Dimensions;
pub use intake::experiment::Experiment;
pub use intake::names::{StrainKind, StressKind};
pub use intake::roles::{ColumnError, Role};
pub use intake::table::Decimal;
pub use judgement::certificate::StableRange;
pub use judgement::errors::ErrorModel;
pub use judgement::estimate::{Direction, Estimate};
pub use judgement::measurement::Contribution;
pub use judgement::misfit::{Misfit, Residual};
pub use judgement::slack::Slack;
pub use judgement::specimen::{Band, Scatter, Specimen};
pub use judgement::warning::FitWarning;
pub use law_file::{
    correlation_key, correlation_of, interval_at, interval_of, is_poisson_of_term, provenance_pair, read_law_file,
    read_law_table,
};
pub use library::{Library, ListedConstant, ListedLaw, library, library_text};
pub use mode::{Mode, UnknownMode};
pub use partner::Partner;
pub use request::{FitOptions, FitRequest, Loss, Poisson, StretchRange, Weighting};
pub use result::{FitResult, Otherwise, Prediction, PredictionKind, RangeRow, ValidRange, Validity};
pub use sample::{RawRow, Sample, Test};
pub use solve::offset::SlackChoice;
pub use solve::solver_check::SolverCheck;
pub use summary::{CurveSet, FitSummary, MeasuredCurves};
pub use treatment::cycle::Cycle;
pub use treatment::{Alternative, Preparation, Treatment};
