//! A straight line through data, with the errors of direct fits.

use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors;
use crate::calibrate::judgement::statistics::t_quantile;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// A straight line with what is needed to judge it.
pub struct Line {
    pub slope: Bounded,
    pub offset: Bounded,
    /// Rms of the residual over that of y without its mean \[–\]
    pub misfit: f64,
    pub residual: DVector<f64>,
    pub errors: errors::Errors,
    /// Coefficient of (x − x̄)² with its interval
    pub bend: Bounded,
}

/// Part of y below which a residual is rounding \[–\]
const ROUNDING: f64 = 1e-12;

/// y = offset + slope x by least squares, and the second-order term that would be added.
pub fn line(x: &[f64], y: &[f64]) -> Line {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    let target = DVector::from_column_slice(y);
    let solve = |columns: usize| {
        let j = DMatrix::from_fn(n, columns, |i, k| match k {
            0 => 1.0,
            1 => x[i],
            _ => (x[i] - mean).powi(2),
        });
        let found = svd(j.clone(), true, true).solve(&target, 1e-14).expect("both factors were asked for");
        let residual = &target - &j * &found;
        let rounding = residual.norm() <= ROUNDING * target.norm();
        let errors = errors::of_curves(&j, &residual, &[(0..n).collect()], rounding);
        let t = if errors.free > 0 { t_quantile(0.95, errors.free) } else { f64::INFINITY };
        let bounded = |k: usize| {
            let half = if rounding { 0.0 } else { t * errors.deviations[k] };
            Bounded { value: found[k], interval: [found[k] - half, found[k] + half] }
        };
        ((0..columns).map(bounded).collect::<Vec<_>>(), residual, errors.clone())
    };
    let bend = solve(3).0[2];
    let (found, residual, errors) = solve(2);
    let centre = target.mean();
    let spread = target.iter().map(|y| (y - centre).powi(2)).sum::<f64>().sqrt();
    Line { slope: found[1], offset: found[0], misfit: residual.norm() / spread, residual, errors, bend }
}
