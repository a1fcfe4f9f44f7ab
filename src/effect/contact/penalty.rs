//! The penalty, per area: ½ k d² for d < 0, and zero otherwise: a spring on the depth.
//!
//! Limits: surfaces penetrate each other by p/k, and a step that passes through a thin obstacle goes undetected.

use super::pressed::Response;
use super::shape::{Shape, Witness};
use crate::math::tensor::Vec3;
use crate::system::ContactPotential;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// k \[Pa/m\]
    pub stiffness: f64,
    /// Depth over which kinks of the distance inside a surface are rounded \[m\]
    pub rounding: f64,
}

impl ContactPotential for Penalty {
    fn reach(&self) -> f64 {
        0.0
    }

    fn potential(&self, d: f64) -> Option<[f64; 3]> {
        let depth = d.min(0.0);
        Some([0.5 * self.stiffness * depth * depth, self.stiffness * depth, if d < 0.0 { self.stiffness } else { 0.0 }])
    }
}

impl Response for Penalty {
    fn witnesses(&self, shape: &Shape, y: &Vec3, _radius: f64) -> Vec<(usize, Witness)> {
        shape.contacts(y, self.rounding)
    }

    fn slips(&self, shape: &Shape) -> usize {
        shape.sheets()
    }

    fn limits_motion(&self) -> bool {
        false
    }

    fn rounding(&self) -> f64 {
        self.rounding
    }
}
