//! Errors of the constants from the data points, without another forward solve.

use crate::calibrate::judgement::statistics;
use crate::calibrate::solve::rows::padded;
use crate::math::random::SplitMix;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Samples of the bootstrap
const SAMPLES: usize = 400;
const SEED: u64 = 0x1_5eed;

/// s²(JᵀJ)⁻¹, s² = ‖r‖²/(n − p); none where a direction is not seen.
pub fn covariance(jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> Option<Vec<Vec<f64>>> {
    let (n, p) = jacobian.shape();
    let s2 = residual.norm_squared() / n.checked_sub(p).filter(|f| *f > 0)? as f64;
    // Columns of length 1, so that the units of the constants do not decide what is small
    let length: Vec<f64> = (0..p).map(|k| jacobian.column(k).norm()).collect();
    if length.contains(&0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(n, p, |i, k| jacobian[(i, k)] / length[k]);
    let inverse = (scaled.transpose() * scaled).cholesky()?.inverse();
    Some((0..p).map(|i| (0..p).map(|k| s2 * inverse[(i, k)] / (length[i] * length[k])).collect()).collect())
}

/// p of the runs test on the signs of the residuals in the order of x.
pub fn few_runs(x: &[f64], residual: &DVector<f64>) -> Option<f64> {
    let mut order: Vec<usize> = (0..x.len()).filter(|i| residual[*i] != 0.0).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    let signs: Vec<bool> = order.iter().map(|i| residual[*i] > 0.0).collect();
    statistics::few_runs(&signs).map(|(_, p)| p)
}

/// Length of the blocks and percentiles 2.5 and 97.5 of the constants, refitted by one Gauss–Newton step to data points drawn in blocks of
/// neighbours in x, closed to a circle.
pub fn drawn_again(
    x: &[f64],
    values: &[f64],
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> (usize, Option<Vec<[f64; 2]>>) {
    let (n, p) = jacobian.shape();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    let sorted: Vec<f64> = order.iter().map(|i| residual[*i]).collect();
    let block = block(&sorted);
    let refit = |sample: u64| {
        let mut random = SplitMix(SplitMix(SEED ^ sample).bits());
        let starts: Vec<usize> = (0..n.div_ceil(block)).map(|_| random.below(n)).collect();
        let rows: Vec<usize> = starts.into_iter().flat_map(|s| (s..s + block).map(|k| order[k % n])).take(n).collect();
        let length: Vec<f64> = (0..p).map(|k| jacobian.column(k).norm()).collect();
        let j = DMatrix::from_fn(n, p, |i, k| jacobian[(rows[i], k)] / length[k]);
        let r = DVector::from_fn(n.max(p), |i, _| if i < n { residual[rows[i]] } else { 0.0 });
        let svd = svd(padded(&j, p), true, true);
        let step = svd.solve(&r, 1e-10 * svd.singular_values.max()).ok()?;
        Some((0..p).map(|k| values[k] + step[k] / length[k]).collect::<Vec<f64>>())
            .filter(|v| v.iter().all(|x| x.is_finite()))
    };
    let found: Vec<Vec<f64>> = (0..SAMPLES as u64).filter_map(refit).collect();
    if found.len() < SAMPLES / 2 {
        return (block, None);
    }
    let percentiles = |k: usize| {
        let mut column: Vec<f64> = found.iter().map(|v| v[k]).collect();
        column.sort_by(f64::total_cmp);
        [0.025, 0.975].map(|q| column[(q * (column.len() - 1) as f64).round() as usize])
    };
    (block, Some((0..p).map(percentiles).collect()))
}

/// Length of the blocks for these residuals in order: twice the lag at which their correlation ρ_k = Σ rᵢrᵢ₊ₖ/Σ rᵢ² falls below 1.96/√n (Politis & Romano,
/// in Exploring the Limits of Bootstrap, 1992), n/4 at most; 1 where neighbours are not correlated.
fn block(r: &[f64]) -> usize {
    let n = r.len();
    let most = (n / 4).max(1);
    let square: f64 = r.iter().map(|x| x * x).sum();
    let level = 1.96 / (n as f64).sqrt();
    let correlation = |k: usize| r.iter().zip(&r[k..]).map(|(a, b)| a * b).sum::<f64>() / square;
    let lag = (1..most).find(|k| square == 0.0 || correlation(*k) < level).unwrap_or(most);
    if lag == 1 { 1 } else { (2 * lag).min(most) }
}
