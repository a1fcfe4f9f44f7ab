//! Cost of accuracy: settings of mesh, element, time step and solver by cost and error.
//!
//! Pure: stored cases in, [`CostFindings`] out. Every converged case of a variant that is not there for the reference is a setting:
//!
//! ```text
//! cost       CPU seconds of the run, the median of its repeats; spread (max − min)/median
//! error       of the peak |f − f*|/scale, of the curve ‖f − f*‖₂/‖f* − f*₀‖₂          f* from [`reference`]
//! error bar   error + U(f*): a setting meets a level if its bar does
//! front       settings that no cheaper one beats in error
//! ```
//!
//! Costs of one error are compared between families ([`super::line`](mod@super::line)), and costs are extrapolated over the cells ([`power_law`](mod@crate::study::estimate::power_law)).

use crate::study::analysis::ByQuantity;
use crate::study::estimate::power_law::{PowerLaw, Predicted};
use crate::study::kinds::cost::line::Line;
use crate::study::kinds::cost::reference::ReferenceCurve;
use crate::study::store::record::PhaseRecord;
use serde::Serialize;

/// Errors that every study asks for, in addition to its own tolerance.
pub const LEVELS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

/// Findings of a cost study.
#[derive(Clone, Debug, PartialEq)]
pub struct CostFindings {
    pub levels: Vec<f64>,
    /// \[variants × quantities\]
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
    /// Cheapest first; none without a reference, since no error is known
    pub settings: Vec<CostedCase>,
    /// Lines of the peak, one per family with two settings or more
    pub lines: Vec<Line>,
    pub answers: Vec<Cheapest>,
}

/// A case as something to choose.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CostedCase {
    pub case: String,
    pub family: String,
    pub label: String,
    pub cost_s: f64,
    /// (max − min)/median of the repeats \[–\]; none of one run, and of times of zero
    pub spread: Option<f64>,
    pub value: f64,
    /// \[–\] of the peak and of the curve
    pub errors: [f64; 2],
    /// Whether it is on the Pareto front of the peak, and on that of the curve
    pub front: [bool; 2],
    pub dofs: usize,
    pub factor_nnz: usize,
    /// Operations of all factorisations
    pub flops: f64,
    pub memory_bytes: Option<u64>,
    pub phases: PhaseRecord,
}

/// The cheapest setting for a level.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Cheapest {
    pub measure: Measure,
    pub level: f64,
    /// Index of the setting; none if no bar is within the level
    pub cheapest: Option<usize>,
    /// The next more expensive one with a smaller error
    pub next: Option<usize>,
}

/// How time or memory grow with the cells of one formulation.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct GrowthLaw {
    pub variant: String,
    pub formulation: String,
    pub of: Grows,
    /// (cells, value) \[s\] or \[bytes\]
    pub points: Vec<(f64, f64)>,
    pub law: PowerLaw,
    /// Twice the most cells
    pub next_cells: f64,
    /// By the law, and no less than what was measured
    pub next: Predicted,
    /// The largest mesh predicted by the others, over what was measured \[–\]
    pub check: Option<f64>,
}

#[derive(Serialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Grows {
    Time,
    Memory,
}

impl CostOfAccuracy {
    /// U(f*) of a measure \[–\].
    pub fn uncertainty(&self, measure: Measure) -> f64 {
        self.reference.as_ref().filter(|r| !r.refused).map_or(f64::INFINITY, |r| match measure {
            Measure::Peak => r.peak_uncertainty,
            Measure::Curve => r.curve_uncertainty,
        })
    }

    /// Error with U(f*) \[–\].
    pub fn bar(&self, setting: usize, measure: Measure) -> f64 {
        self.settings[setting].errors[measure as usize] + self.uncertainty(measure)
    }

    pub fn answer(&self, measure: Measure, level: f64) -> Option<&Cheapest> {
        self.answers.iter().find(|a| a.measure == measure && a.level == level)
    }
}
