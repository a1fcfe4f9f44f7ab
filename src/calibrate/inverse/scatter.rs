//! Residuals of a point as evidence about the directions of a search: the scatter of the residuals, and whether the misfit falls by more than it.
//!
//! Let u_k be the unit change of the weighted curve along direction k, r the residual, and r⊥ its part orthogonal to all directions that the curves
//! depend on. The scatter s_k of u_kᵀr follows from the error model that r⊥ shows ([`errors`]), independent or correlated between neighbours. The
//! misfit falls along a direction by more than the scatter if |u_kᵀr| > t s_k, with the 95 % quantile t of Student's t. Far from an answer r⊥ is
//! mostly curvature, which looks like correlated errors: a direction that contains more than half of r is therefore judged with independent errors.

use crate::calibrate::judgement::errors;
use crate::math::statistics;
use nalgebra::{DMatrix, DVector};

/// Relative change of a curve below which it is rounding of the forward solves \[–\]
const ROUNDING: f64 = 1e-7;

/// A direction compared with the scatter.
#[derive(Clone, Copy, Debug)]
pub struct Along {
    /// Change of the curve along it that the scatter leaves open at 95 % \[–\]
    pub open: f64,
    /// Whether the misfit falls along the direction by more than the scatter
    pub falls: bool,
}

/// Judges each direction of `changes`, orthonormal columns (n × m), at a residual \[n\]. `size`: ‖wy‖; `curves`: lists of rows in order of x.
pub fn along(changes: &DMatrix<f64>, residual: &DVector<f64>, size: f64, curves: &[Vec<usize>]) -> Vec<Along> {
    let (n, m) = changes.shape();
    if n <= m {
        return vec![Along { open: f64::INFINITY, falls: false }; m];
    }
    let pull = changes.transpose() * residual;
    let rest = residual - changes * &pull;
    let errors = errors::of_curves(changes, &rest, curves, rest.norm() <= ROUNDING * size);
    let t = statistics::t_quantile(0.95, errors.free.max(1));
    let independent = statistics::t_quantile(0.95, n - m) * rest.norm() / ((n - m) as f64).sqrt();
    let one = |k: usize| {
        let open = (t * errors.deviations[k] / size).max(ROUNDING);
        let own = pull[k].abs() / size;
        let is_most = pull[k].powi(2) > 0.5 * residual.norm_squared();
        Along { open, falls: own > open || (is_most && own > (independent / size).max(ROUNDING)) }
    };
    (0..m).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of one direction with independent errors of size 1, n = 40: the misfit falls along it if its part exceeds t s, and not below.
    #[test]
    fn a_fall_counts_beyond_the_scatter() {
        let n = 40;
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let changes = DMatrix::from_fn(n, 1, |_, _| (n as f64).sqrt().recip());
        let at = |pull: f64| {
            let residual = DVector::from_fn(n, |k, _| sign(k)) + changes.column(0) * pull;
            along(&changes, &residual, 100.0, &[(0..n).collect()])[0]
        };
        // s² = 40/39, and t of 39 degrees of freedom is 2.0227
        let open = 2.0227 * (40.0_f64 / 39.0).sqrt();
        assert!((at(0.0).open - open / 100.0).abs() < 1e-4 * open, "{:?}", at(0.0));
        assert!(!at(0.99 * open).falls && at(1.01 * open).falls);
        assert!(along(&changes, &DVector::zeros(n), 100.0, &[(0..n).collect()])[0].open <= ROUNDING);
    }

    /// A slow wave, like the curvature of a curve far from its answer, looks like correlated errors, which would hide a direction that contains most
    /// of the residual.
    #[test]
    fn most_of_a_residual_counts_whatever_the_rest_looks_like() {
        let n = 40;
        let x = |k: usize| (k as f64 + 0.5) / n as f64;
        let changes = DMatrix::from_fn(n, 1, |_, _| (n as f64).sqrt().recip());
        let wave = DVector::from_fn(n, |k, _| (2.0 * std::f64::consts::PI * x(k)).cos());
        let at = |pull: f64| along(&changes, &(&wave + changes.column(0) * pull), 100.0, &[(0..n).collect()])[0];
        let (half, most) = (0.9 * wave.norm(), 1.1 * wave.norm());
        assert!(most / 100.0 < at(most).open, "the rest looks correlated: {:?}", at(most));
        assert!(!at(half).falls && at(most).falls);
    }
}
