//! Displacement gradients and pressures of fields at all points of a body, and the resulting forces.

use super::body_points::{BodyPoints, PointForce};
use crate::reduction::error::ReductionError;

/// Fields at all points of a body.
pub struct FieldsAtPoints {
    /// \[fields\]\[points\] ∂v/∂X row by row
    pub gradients: Vec<Vec<[f64; 9]>>,
    /// \[fields\]\[points\] p \[Pa\]
    pub pressures: Vec<Vec<f64>>,
}

impl FieldsAtPoints {
    /// Evaluates fields \[unknowns\], each with a displacement and a pressure.
    pub fn of(points: &BodyPoints, fields: &[Vec<f64>]) -> Self {
        Self {
            gradients: fields.iter().map(|f| points.gradients(f)).collect(),
            pressures: fields.iter().map(|f| points.pressures(f)).collect(),
        }
    }

    /// Returns ∂u/∂X and p of Σ y_k v_k at all points.
    fn combine(&self, y: &[f64]) -> Vec<([f64; 9], f64)> {
        let points = self.gradients.first().map_or(0, Vec::len);
        let at = |p: usize| {
            let (mut h, mut pressure) = ([0.0; 9], 0.0);
            for (k, y) in y.iter().enumerate() {
                h.iter_mut().zip(self.gradients[k][p]).for_each(|(h, g)| *h += y * g);
                pressure += y * self.pressures[k][p];
            }
            (h, pressure)
        };
        (0..points).map(at).collect()
    }

    /// Returns P and G of Σ y_k v_k at all points.
    pub fn forces(&self, points: &BodyPoints, y: &[f64]) -> Result<Vec<PointForce>, ReductionError> {
        let places = points.places().zip(self.combine(y));
        places.map(|(at, (h, pressure))| points.force(at.part, &h, pressure)).collect()
    }

    /// Returns w (P : ∂v/∂X + p G) of a field at a point.
    pub fn work(&self, field: usize, point: usize, weight: f64, (p, gap): &PointForce) -> f64 {
        let product: f64 = p.iter().zip(&self.gradients[field][point]).map(|(p, g)| p * g).sum();
        weight * (product + self.pressures[field][point] * gap)
    }
}
