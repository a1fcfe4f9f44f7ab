//! Cost of accuracy: settings of mesh, element, time step and solver by cost and error.
//!
//! Pure: stored cases in, [`CostFindings`] out. Every converged case of a variant is a setting, except those that serve the reference:
//!
//! ```text
//! cost       CPU seconds of the run, the median of its repeats; spread (max − min)/median
//! error       of the peak |f − f*|/scale, of the curve ‖f − f*‖₂/‖f* − f*₀‖₂          f* from [`reference`]
//! error bar   error + U(f*): a setting meets a level if its bar does
//! front       settings that no cheaper one beats in error
//! ```
//!
//! The costs of reaching one error are compared between families ([`super::line`](mod@super::line)), and costs are extrapolated over the cells
//! ([`power_law`](mod@crate::study::estimate::power_law)).

use crate::study::analysis::ByQuantity;
use crate::study::estimate::power_law::{PowerLaw, Predicted};
use crate::study::kinds::cost::line::Line;
use crate::study::kinds::cost::reference::ReferenceCurve;
use crate::study::store::record::PhaseRecord;
use serde::Serialize;

/// Error levels that every study considers, in addition to its own tolerance.
pub const LEVELS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

/// Findings of a cost study.
#[derive(Clone, Debug, PartialEq)]
pub struct CostFindings {
    pub levels: Vec<f64>,
    /// Findings in every quantity \[variants × quantities\]
    pub quantities: Vec<ByQuantity<CostOfAccuracy>>,
    pub growth: Vec<GrowthLaw>,
}

/// The error that is judged: of the peak, or of the whole curve.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    Peak,
    Curve,
}

pub const MEASURES: [Measure; 2] = [Measure::Peak, Measure::Curve];

impl Measure {
    pub fn words(self) -> &'static str {
        match self {
            Self::Peak => "peak",
            Self::Curve => "curve",
        }
    }
}

/// Costs and errors in one quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CostOfAccuracy {
    pub reference: Option<ReferenceCurve>,
    /// The settings, cheapest first; empty without a reference, since no error is known
    pub settings: Vec<CostedCase>,
    /// Cost lines of the peak, one per family with at least two settings
    pub lines: Vec<Line>,
    pub answers: Vec<Cheapest>,
}

/// A case as a setting to choose from.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CostedCase {
    pub case: String,
    pub family: String,
    pub label: String,
    pub cost_s: f64,
    /// Spread (max − min)/median of the repeats \[–\]; `None` for a single run and for times of zero
    pub spread: Option<f64>,
    pub value: f64,
    /// Errors of the peak and of the curve \[–\]
    pub errors: [f64; 2],
    /// Whether it is on the Pareto front of the peak and on that of the curve
    pub front: [bool; 2],
    pub dofs: usize,
    pub factor_nnz: usize,
    /// Floating-point operations of all factorisations
    pub flops: f64,
    pub memory_bytes: Option<u64>,
    pub phases: PhaseRecord,
}

/// The cheapest setting for a level.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Cheapest {
    pub measure: Measure,
    pub level: f64,
    /// Index of the setting; `None` if no error bar is within the level
    pub cheapest: Option<usize>,
    /// Index of the next more expensive setting with a smaller error
    pub next: Option<usize>,
}

/// Growth of time or memory with the number of cells, for one formulation.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct GrowthLaw {
    pub variant: String,
    pub formulation: String,
    pub of: Grows,
    /// Measured points as (cells, value), with the value in \[s\] or \[bytes\]
    pub points: Vec<(f64, f64)>,
    pub law: PowerLaw,
    /// Twice the largest number of cells
    pub next_cells: f64,
    /// Prediction of the law, at least the largest measured value
    pub next: Predicted,
    /// Prediction for the largest mesh from the others, relative to the measured value \[–\]
    pub check: Option<f64>,
}

#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Grows {
    Time,
    Memory,
}

impl CostOfAccuracy {
    /// Returns the uncertainty U(f*) of the reference in a measure \[–\]; infinite without a usable reference.
    pub fn uncertainty(&self, measure: Measure) -> f64 {
        self.reference.as_ref().filter(|r| !r.refused).map_or(f64::INFINITY, |r| match measure {
            Measure::Peak => r.peak_uncertainty,
            Measure::Curve => r.curve_uncertainty,
        })
    }

    /// Returns the error bar of a setting, its error plus U(f*) \[–\].
    pub fn bar(&self, setting: usize, measure: Measure) -> f64 {
        self.settings[setting].errors[measure as usize] + self.uncertainty(measure)
    }

    pub fn answer(&self, measure: Measure, level: f64) -> Option<&Cheapest> {
        self.answers.iter().find(|a| a.measure == measure && a.level == level)
    }
}
