//! The barrier of incremental potential contact, per area: b(d) = −κ (d − d̂)² ln(d/d̂) for d < d̂, and zero beyond.
//!
//! Source: Li et al., Incremental potential contact, ACM TOG 39 (2020), eq. 6, there dimensionless; per area as in Li et al., Convergent incremental
//! potential contact (2023). It is C² at d̂ and infinite at d = 0, and no step crosses d = 0: the surfaces stay apart under any load. Limits: contact
//! forces act before the surfaces meet, from the distance d̂ on: results depend on d̂, and less so the smaller it is.

use super::pressed::Response;
use super::shape::{Shape, Witness};
use crate::math::tensor::Vec3;
use crate::system::ContactPotential;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// d̂ \[m\]
    pub distance: f64,
    /// κ \[Pa/m\]; the pressure at d̂/2 is 1.19 κ d̂
    pub stiffness: f64,
}

impl ContactPotential for Barrier {
    fn reach(&self) -> f64 {
        self.distance
    }

    fn potential(&self, d: f64) -> Option<[f64; 3]> {
        let Self { distance, stiffness } = *self;
        if d >= distance {
            return Some([0.0; 3]);
        }
        if d <= 0.0 {
            return None;
        }
        let (e, ln) = (d - distance, (d / distance).ln());
        let first = -stiffness * e * (2.0 * ln + e / d);
        let second = -stiffness * (2.0 * ln + 4.0 * e / d - (e / d).powi(2));
        Some([-stiffness * e * e * ln, first, second])
    }
}

impl Response for Barrier {
    fn witnesses(&self, shape: &Shape, y: &Vec3, radius: f64) -> Vec<(usize, Witness)> {
        shape.within(y, self.distance + radius).into_iter().map(|witness| (0, witness)).collect()
    }

    fn slips(&self, _shape: &Shape) -> usize {
        1
    }

    fn limits_motion(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with central differences, whose error is h² b⁗/6 and whose rounding is ε b/h; at d̂ all three vanish.
    #[test]
    fn derivatives_and_smoothness() {
        let b = Barrier { distance: 2e-4, stiffness: 3e8 };
        for k in 1..40 {
            let d = b.distance * f64::from(k) / 40.0;
            let h = 1e-5 * d;
            let at = |d: f64| b.potential(d).expect("positive");
            let [low, here, high] = [at(d - h), at(d), at(d + h)];
            for i in 0..2 {
                let slope = (high[i] - low[i]) / (2.0 * h);
                assert!((slope - here[i + 1]).abs() < 1e-6 * (here[i + 1].abs() + here[i].abs() / d), "d = {d}, {i}");
            }
            assert!(here[0] > 0.0 && here[1] < 0.0 && here[2] > 0.0);
        }
        assert_eq!(b.potential(b.distance), Some([0.0; 3]));
        assert_eq!(b.potential(0.0), None);
        let half = b.potential(0.5 * b.distance).expect("positive")[1];
        assert!((-half / (b.stiffness * b.distance) - (2f64.ln() + 0.5)).abs() < 1e-14);
    }
}
