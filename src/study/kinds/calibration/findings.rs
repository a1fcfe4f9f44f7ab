//! Findings of a calibration: the constants of each variant, and everything known about their errors.

use crate::study::store::record::Role;
use serde::Serialize;

/// Findings of a calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFindings {
    pub variants: Vec<CalibratedVariant>,
}

/// Result of one measured curve.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CalibratedVariant {
    pub variant: String,
    /// Name of the variant in words
    pub label: String,
    /// The case on the finest mesh
    pub case: String,
    pub cells: usize,
    pub constants: Vec<CalibratedConstant>,
    /// Relative misfit √(Σr²/Σy²) of each curve \[–\]
    pub rms_relative: Vec<f64>,
    /// Formulation of the finest mesh
    pub formulation: String,
    /// The verdict on element and mesh in words: whether the constants belong to the material or partly to the mesh
    #[serde(rename = "element")]
    pub mesh_verdict: String,
    /// Pressure scatter of the finest mesh if it raises the locking alarm \[–\]
    pub locking: Option<f64>,
    /// Errors of the data points, in words
    pub errors: String,
    /// Cases of imprecisely known dimensions without constants: the intervals lack the effects of these dimensions
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_constants: Vec<String>,
    /// Whether the scene depends on time steps whose error is in no interval
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lacks_steps: bool,
    /// Forward solves of the finest case, and its time relative to one forward solve \[–\]
    pub solves: usize,
    pub cost: f64,
}

/// A constant with everything known about its error, in SI.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CalibratedConstant {
    pub key: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 % interval from data, mesh, time steps and dimensions
    pub interval: Option<[f64; 2]>,
    /// Reason why there is no interval
    pub open: Option<String>,
    /// Relative half-width of the interval from the data alone, and from data and dimensions together if these are known \[–\]
    pub rows: Option<f64>,
    pub rest: Option<f64>,
    /// Relative change from the next coarser mesh to the finest \[–\]
    pub drift: Option<f64>,
    /// Uncertainty U of the finest mesh relative to the value \[–\], and how it was estimated; `None` for a single mesh
    pub mesh: Option<f64>,
    pub mesh_method: Option<String>,
    /// Error of the time steps relative to the value \[–\]; `None` if no family of time steps shows it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<f64>,
    /// Whether U is no bound, because the finest mesh locks or its family diverges
    pub mesh_refused: bool,
    /// Smallest and largest value over the corners of the nuisance families, on the finest mesh
    pub nuisance: Option<[f64; 2]>,
    /// A sentence if the dimensions do not simply add up
    pub corners: Option<String>,
    /// Value that the gauge length would have given
    pub gauge: Option<f64>,
    /// Relative error of the gauge-length value \[–\]
    pub bias: Option<f64>,
    pub cases: Vec<ConstantInCase>,
}

/// A constant in one case.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ConstantInCase {
    pub case: String,
    pub family: String,
    pub member: String,
    pub role: Role,
    pub cells: usize,
    pub value: f64,
    pub interval: Option<[f64; 2]>,
    pub rms_relative: f64,
    /// For a dimension, the case of the sizes that its change is measured from
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
}
