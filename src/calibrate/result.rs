//! The answer of a fit and what is said about it.

use super::{Audit, FitCurves, FitError, Misfit, Mode, Partner, Residual, SolverCheck, StretchRange};
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// A parameter with its 95 % interval [SI].
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Estimate {
    pub name: &'static str,
    pub symbol: &'static str,
    /// SI unit
    pub unit: &'static str,
    pub value: f64,
    pub std_error: f64,
    pub interval: [f64; 2],
}

/// What the interval takes for granted.
pub const INTERVAL_ASSUMPTION: &str = "95 %, Student's t: exact stretches, independent normal stress errors of one size, \
                                       and a law that describes the range; it does not cover misfit of the law";

/// Rows that were not fitted.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictionKind {
    /// A fitted mode outside the fitted range
    OutsideRange,
    /// Another mode, same range of λ
    OtherModeInRange,
    /// Another mode, every row
    OtherMode,
}

/// Error of the law on rows that were not fitted.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Prediction {
    pub kind: PredictionKind,
    pub mode: Mode,
    /// Smallest and largest λ of these rows [–]
    pub stretch: [f64; 2],
    pub misfit: Misfit,
}

/// The same fit over a range that ends earlier or later.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RangeRow {
    /// Largest λ [–]
    pub to: f64,
    pub rows: usize,
    pub parameters: Vec<Estimate>,
    pub rms_pa: f64,
    pub rms_relative: f64,
}

/// Largest range around λ = 1 in which √(Σr²/ΣP²) of the fitted modes stays within the tolerance.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Validity {
    pub tolerance: f64,
    /// `None`: nowhere, or no rows on that side
    pub compression_to: Option<f64>,
    pub tension_to: Option<f64>,
}

/// Reasons not to take the answer at its word.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FitWarning {
    /// Residuals have a pattern. p-values [–] of the two tests; one of them is below 2.5 %.
    Systematic { runs: Option<usize>, runs_p: Option<f64>, departure_p: Option<f64>, rms_relative: f64 },
    /// Rms misfit in the fitted range above the tolerance
    Misfit { rms_relative: f64, tolerance: f64 },
    /// Another mode is predicted with more than the tolerance
    CrossMode { mode: Mode, bias_relative: f64, rms_relative: f64 },
    /// Stiffness outside 1 kPa to 10 MPa; `instead`: the unit that would make it a rubber
    Stiffness { mu_pa: f64, unit: String, instead: Option<&'static str> },
    /// From the audit log
    Data { message: String },
    /// The compressible law is softer (or stiffer) in small tension than the data
    Compressible { nu: f64, slope_relative: f64 },
    /// The law file lacks a constant
    NoPartner,
}

impl fmt::Display for FitWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Systematic { runs, runs_p, departure_p, rms_relative } => {
                write!(f, "the law does not describe this range: its residuals have a pattern (")?;
                if let (Some(runs), Some(p)) = (runs, runs_p) {
                    write!(f, "{runs} runs of sign, p = {p:.2e}; ")?;
                }
                if let Some(p) = departure_p {
                    write!(f, "stiffness changes with stretch, p = {p:.2e}; ")?;
                }
                write!(
                    f,
                    "rms {:.2} %): the interval is too narrow and the constant depends on the range",
                    100.0 * rms_relative
                )
            }
            Self::Misfit { rms_relative, tolerance } => write!(
                f,
                "misfit {:.1} % rms in the fitted range is above {:.1} %: narrow --range to the stretches of the use, \
                 or take a richer law",
                100.0 * rms_relative,
                100.0 * tolerance
            ),
            Self::CrossMode { mode, bias_relative, rms_relative } => {
                let side = if *bias_relative < 0.0 { "low" } else { "high" };
                write!(
                    f,
                    "{mode} rows in the same range are predicted {:.1} % too {side} (rms {:.1} %)",
                    100.0 * bias_relative.abs(),
                    100.0 * rms_relative
                )
            }
            Self::Stiffness { mu_pa, unit, instead } => {
                write!(f, "μ = {mu_pa:.4e} Pa is outside 1 kPa to 10 MPa, the range of rubbers")?;
                match instead {
                    Some(other) => write!(f, "; are the stresses in {other} rather than {unit}? Pass --stress-unit"),
                    None => write!(f, "; check the stress column and its unit ({unit})"),
                }
            }
            Self::Data { message } => f.write_str(message),
            Self::Compressible { nu, slope_relative } => write!(
                f,
                "with nu = {nu:.4} a compressible law has the slope 2(1 + nu)mu in small tension, {:.1} % off the 3 mu of \
                 the data, which were taken as incompressible",
                100.0 * slope_relative
            ),
            Self::NoPartner => f.write_str(
                "tests of an incompressible material do not give nu or kappa: the law file has neither, pass --nu or \
                 add one in the scene",
            ),
        }
    }
}

/// Everything about one fit. Stresses and stiffnesses in Pa, stretches [–].
#[derive(Clone, Debug, Serialize)]
pub struct FitResult {
    pub law: &'static str,
    pub formula: &'static str,
    pub law_source: &'static str,
    /// File name of the table
    pub data: String,
    pub data_sha256: String,
    /// Authors, journal, year of the card
    pub data_source: Option<String>,
    pub version: &'static str,
    pub modes: Vec<Mode>,
    /// As asked; `None`: every row
    pub asked_range: Option<StretchRange>,
    /// Smallest and largest fitted λ
    pub stretch: [f64; 2],
    /// Rows that take part; rows at λ = 1 with zero stress say nothing and are not counted
    pub rows: usize,
    pub parameters: Vec<Estimate>,
    pub interval_assumption: &'static str,
    pub partner: Option<Partner>,
    pub misfit: Misfit,
    pub validity: Validity,
    pub predictions: Vec<Prediction>,
    pub range_dependence: Vec<RangeRow>,
    /// Smallest and largest value of each parameter over ranges that end within the fitted one: what the choice of the
    /// range does to the answer
    pub range_spread: Vec<[f64; 2]>,
    pub solver_check: SolverCheck,
    pub warnings: Vec<FitWarning>,
    pub residuals: Vec<Residual>,
    pub curves: FitCurves,
    pub audit: Audit,
}

impl FitResult {
    /// `fit.json`: all of this value, and `messages`, the warnings as text
    pub fn write_json(&self, path: &Path) -> Result<(), FitError> {
        let mut value = serde_json::to_value(self).expect("the result has string keys and serialisable values");
        value["messages"] = self.warnings.iter().map(ToString::to_string).collect();
        let text = serde_json::to_string_pretty(&value).expect("a JSON value can be written");
        std::fs::write(path, text + "\n").map_err(|source| FitError::Write { path: path.into(), source })
    }

    /// `μ = … Pa [… , …]`, one per parameter
    pub fn answer(&self) -> String {
        let one = |e: &Estimate| {
            format!(
                "{} = {:.5e} {} (95 % interval {:.5e} to {:.5e})",
                e.symbol, e.value, e.unit, e.interval[0], e.interval[1]
            )
        };
        self.parameters.iter().map(one).collect::<Vec<_>>().join("\n")
    }
}

impl fmt::Display for FitResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let modes: Vec<_> = self.modes.iter().map(|m| m.name()).collect();
        writeln!(
            f,
            "{} on {} ({}), stretch {} to {}, {} rows",
            self.law,
            self.data,
            modes.join(" + "),
            self.stretch[0],
            self.stretch[1],
            self.rows
        )?;
        writeln!(f, "{}", self.answer())?;
        writeln!(f, "misfit {:.2} % rms, {:.4e} Pa", 100.0 * self.misfit.rms_relative, self.misfit.rms_pa)?;
        for (e, [low, high]) in self.parameters.iter().zip(&self.range_spread) {
            writeln!(f, "ranges that end earlier give {} from {low:.5e} to {high:.5e} {}", e.symbol, e.unit)?;
        }
        let percent = 100.0 * self.validity.tolerance;
        match self.validity.tension_to {
            Some(to) => writeln!(f, "within {percent:.0} % rms of the data from stretch 1 to {to}")?,
            None => writeln!(f, "nowhere in tension within {percent:.0} % rms of the data")?,
        }
        for p in &self.predictions {
            let what = match p.kind {
                PredictionKind::OutsideRange => "outside the range",
                PredictionKind::OtherModeInRange => "not fitted, same range",
                PredictionKind::OtherMode => "not fitted, every row",
            };
            writeln!(
                f,
                "{} {what} ({} rows, stretch {} to {}): {:.1} % rms",
                p.mode,
                p.misfit.rows,
                p.stretch[0],
                p.stretch[1],
                100.0 * p.misfit.rms_relative
            )?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}
