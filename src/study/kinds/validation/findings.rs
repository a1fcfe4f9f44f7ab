//! Findings of a validation: constants, predictions with their budgets, and the scores of measured predictions.

use crate::study::kinds::validation::budget::Contribution;
use crate::study::kinds::validation::plan::TracksPlan;
use serde::Serialize;

/// Findings of a validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationFindings {
    pub constants: Vec<FoundConstant>,
    pub fitted: Vec<FittedDatum>,
    /// √(χ²/ν) if that is beyond chance, otherwise 1
    pub widened: f64,
    pub chi2: f64,
    pub freedom: usize,
    pub predictions: Vec<Prediction>,
    /// Origin of the values that predictions are compared with, in words; measured if absent
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Terms of the budget with their origin: (term, deviation, source)
    pub sources: Vec<(String, String, String)>,
    /// Scatter of the quantities that have repeats
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scatter: Vec<FoundScatter>,
    /// Audit of the tracks from which values were measured
    pub tracks: Vec<TracksPlan>,
}

impl ValidationFindings {
    /// Returns the word for the values that predictions are compared with: `measured`, or their origin.
    pub fn reference(&self) -> &str {
        self.reference.as_deref().unwrap_or("measured")
    }
}

/// Scatter of single values between repeats.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundScatter {
    pub quantity: String,
    /// The record with this scatter; `None` if several records share it
    pub record: Option<String>,
    pub unit: String,
    /// Standard deviation \[unit\]
    pub deviation: f64,
    /// Degrees of freedom
    pub freedom: usize,
}

/// A constant determined by the calibration records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundConstant {
    pub key: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 % interval
    pub interval: [f64; 2],
    pub range: [f64; 2],
    /// Contributions to the uncertainty, largest first
    pub budget: Vec<Contribution>,
    /// Half-width of the 95 % interval due to mesh, time steps, response surfaces and Newton's method
    pub numerical: f64,
    /// Reasons to doubt the numerical error bars
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
}

/// A measured value of the calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedDatum {
    pub record: String,
    pub quantity: String,
    pub unit: String,
    pub measured: f64,
    pub fitted: f64,
    /// (measured − fitted) divided by the standard deviation of its independent errors
    pub residual: f64,
}

/// A predicted value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    pub record: String,
    pub record_label: String,
    pub experiment: String,
    pub quantity: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 % interval
    pub interval: [f64; 2],
    /// Contributions to the uncertainty, largest first
    pub budget: Vec<Contribution>,
    /// Standard deviations from derivatives and from simulated experiments
    pub deviations: [f64; 2],
    /// Whether the response is so curved that the interval comes from simulated experiments
    pub curved: bool,
    /// Mean of the measured values, if there are any
    pub measured: Option<f64>,
    /// Whether the interval contains the measured value; `None` if the interval lacks an error
    pub inside: Option<bool>,
    /// (measured − predicted) divided by the half of the interval on that side, if it is judged
    pub score: Option<f64>,
    /// Errors that the interval lacks, in words
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lacks: Vec<String>,
    /// Reasons to doubt the numerical error bars
    pub doubts: Vec<String>,
}
