//! Calibration: from a tensile table to the constants of a law, with an interval and a judgement.
//!
//! [`fit()`] is the way in: it reads a table ([`Experiment`]), fits a law of [`FITS`] in closed form and answers with
//! [`FitResult`]. Nothing here prints or draws; [`FitCurves`] is what a figure needs, [`FitResult::write_json`] and
//! [`FitResult::write_law`] store the answer.

mod audit;
mod card;
mod columns;
mod curves;
mod error;
mod experiment;
mod fit;
mod law_file;
mod misfit;
mod mode;
mod neo_hookean;
mod optimise;
mod request;
mod result;
mod statistics;
mod table;

pub use audit::{Audit, AuditEntry, AuditKind};
pub use card::{Card, Source};
pub use columns::{ColumnChoice, StrainKind};
pub use curves::{FitCurves, ModeCurves};
pub use error::FitError;
pub use experiment::{Experiment, Sample};
pub use fit::{fit, fit_experiment};
pub use law_file::{read_law_file, read_law_table};
pub use misfit::{Misfit, Residual};
pub use mode::Mode;
pub use optimise::SolverCheck;
pub use request::{FitOptions, FitRequest, Partner, StretchRange};
pub use result::{Estimate, FitResult, FitWarning, Prediction, PredictionKind, RangeRow, Validity};

use crate::material::Parameter;

/// What a law's own fit answers with.
#[derive(Clone, Debug)]
pub struct LawFit {
    pub estimates: Vec<Estimate>,
    /// Agreement of the two optimisers
    pub check: SolverCheck,
    /// Two-sided p-value of a departure of the data from the law [–]; `None` with too few rows or data that the law
    /// meets to rounding
    pub departure_p: Option<f64>,
}

/// A law that can be fitted to tests with homogeneous, incompressible deformation.
#[derive(Debug)]
pub struct Fittable {
    /// Name in files
    pub name: &'static str,
    /// Nominal stress as text, one formula for each mode
    pub formula: &'static str,
    pub source: &'static str,
    pub parameters: &'static [Parameter],
    /// Nominal stress [Pa] with parameters [SI] at a stretch [–]
    pub stress: fn(&[f64], Mode, f64) -> f64,
    pub fit: fn(&[Sample]) -> Result<LawFit, FitError>,
}

/// Laws that can be fitted, one line each.
pub const FITS: &[Fittable] = &[neo_hookean::NEO_HOOKEAN];

/// The law of this name, or the error that names the nearest one.
pub fn fittable(name: &str) -> Result<&'static Fittable, FitError> {
    FITS.iter().find(|f| f.name == name).ok_or_else(|| {
        let nearest = FITS
            .iter()
            .max_by(|a, b| strsim::jaro_winkler(a.name, name).total_cmp(&strsim::jaro_winkler(b.name, name)))
            .expect("the registry is not empty")
            .name;
        FitError::UnknownLaw { name: name.into(), nearest, known: FITS.iter().map(|f| f.name).collect() }
    })
}
