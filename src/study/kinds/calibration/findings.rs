//! Findings of a calibration: the constants of each variant, and all that is known of their errors.

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
    /// The variant in words
    pub label: String,
    /// The case on the finest mesh
    pub case: String,
    pub cells: usize,
    pub constants: Vec<CalibratedConstant>,
    /// Relative misfit √(Σr²/Σy²) of each curve \[–\]
    pub rms_relative: Vec<f64>,
    /// Formulation of the finest mesh
    pub formulation: String,
    /// The verdict on element and mesh in words: whether the constants are those of the material or partly those of the mesh
    #[serde(rename = "element")]
    pub mesh_verdict: String,
    /// Pressure scatter of the finest mesh where it raises the locking alarm \[–\]
    pub locking: Option<f64>,
    /// Errors of the data points, in words
    pub errors: String,
    /// Cases of dimensions not known exactly that have no constants: what these dimensions change is in no interval
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_constants: Vec<String>,
    /// The scene depends on the time steps, whose error is in no interval
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lacks_steps: bool,
    /// Forward solves of the finest case, and its time over the one of a forward solve \[–\]
    pub solves: usize,
    pub cost: f64,
}

/// A constant with all that is known of its error. SI.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CalibratedConstant {
    pub key: String,
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// 95 %: data, mesh, time steps, nuisance
    pub interval: Option<[f64; 2]>,
    /// Reason for which there is none
    pub open: Option<String>,
    /// Half-width of the interval of the data alone, and of data and dimensions together where these are known, relative \[–\]
    pub rows: Option<f64>,
    pub rest: Option<f64>,
    /// Relative change from the next coarser mesh to the finest \[–\]
    pub drift: Option<f64>,
    /// Uncertainty of the finest mesh U over the value \[–\], and how it was estimated; none of one mesh
    pub mesh: Option<f64>,
    pub mesh_method: Option<String>,
    /// Error of the time steps over the value \[–\]; none where no family of them tells it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<f64>,
    /// U is no bound: the finest mesh locks, or its family diverges
    pub mesh_refused: bool,
    /// Smallest and largest value over the corners of the nuisance families, on the finest mesh
    pub nuisance: Option<[f64; 2]>,
    /// Where the dimensions do not simply add up, in words
    pub corners: Option<String>,
    /// Reading by a gauge length
    pub gauge: Option<f64>,
    /// Its relative error \[–\]
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
    /// Of a dimension, the case of the sizes that its change counts from
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
}
