//! Requests for the evaluation of a record of motion.

use super::plateau::PlateauRule;
use super::release::ReleaseRule;
use super::track::ReadOptions;
use super::vibration::Creep;
use crate::math::tensor::Vec3;
use std::path::PathBuf;

/// A rigid group of markers, and the point of the body to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyRequest {
    pub markers: Vec<String>,
    /// Position of the point in the held state \[m\]; if `None`, the centroid of the markers
    pub at: Option<Vec3>,
}

/// Request for the evaluation of a motion record.
#[derive(Clone, Debug, Default)]
pub struct MotionRequest {
    pub file: PathBuf,
    pub read: ReadOptions,
    pub body: Option<BodyRequest>,
    /// Markers in which the states are found; if none of them is known, those of the body, or else all
    pub guides: Vec<String>,
    /// Table of marker positions in the frame of the body, onto which the held state is registered
    pub reference: Option<PathBuf>,
    /// Windows of the held and the final state \[s\]; found automatically if `None`
    pub held_s: Option<[f64; 2]>,
    pub final_s: Option<[f64; 2]>,
    /// Name of a curve, and the window after the release \[s\]
    pub ring_down: Option<(String, [f64; 2])>,
    pub creep: Creep,
    pub plateau: PlateauRule,
    pub release: ReleaseRule,
}
