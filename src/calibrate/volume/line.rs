//! A straight line through data, with the errors of direct fits; several specimens share one slope and have separate offsets.
//!
//! ```text
//! a = σ²/s²,   σ² = the smaller of   (median |xᵢ₋₁ − 2xᵢ + xᵢ₊₁|/(0.6745 √6))²   and   Σ r²/(n − p)/slope²
//! ```
//!
//! Noise in x makes the least-squares slope too small by the share a of the variance s² of x that is noise (W. A. Fuller, *Measurement Error Models*,
//! 1987, section 1.1). The noise is at most the roughness of x from row to row, and at most what the residual r shows; the end of the interval that
//! is farther from zero is divided by 1 − a. The value is not corrected, because uneven loading is rough without an error. Limit: a itself is taken
//! as known, which is valid if it is small.

use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors;
use crate::math::statistics::{median, t_quantile};
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Points of the tests of one or several specimens.
#[derive(Clone, Debug, Default)]
pub struct Points {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Specimen of each point, counted from 0
    pub specimen: Vec<usize>,
}

/// A straight line with the data that are needed to judge it.
#[derive(Clone)]
pub struct Line {
    pub slope: Bounded,
    /// Offset of each specimen
    pub offsets: Vec<Bounded>,
    /// Rms of the residual relative to that of y, with the mean of each specimen subtracted \[–\]
    pub misfit: f64,
    pub residual: DVector<f64>,
    pub errors: errors::Errors,
    /// Coefficient of (x − x̄)² with its interval
    pub bend: Bounded,
    /// Largest share of the variance of x that may be noise, by which the slope would be too small \[–\]
    pub attenuation: f64,
}

/// Residual relative to y below which it is rounding \[–\]
const ROUNDING: f64 = 1e-12;

/// Ratio of the median magnitude of a normal error to its standard deviation
const MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Fits y = offset + slope x by least squares, and the second-order term that could be added.
pub fn line(points: &Points) -> Line {
    let Points { x, y, specimen } = points;
    let (n, count) = (x.len(), specimen.iter().max().map_or(1, |k| k + 1));
    let mean = x.iter().sum::<f64>() / n as f64;
    let target = DVector::from_column_slice(y);
    let rows_of = |one: usize| (0..n).filter(|i| specimen[*i] == one).collect::<Vec<_>>();
    let curves: Vec<Vec<usize>> = (0..count).map(rows_of).collect();
    let solve = |columns: usize| {
        let j = DMatrix::from_fn(n, count + columns, |i, k| match k.checked_sub(count) {
            None => f64::from(u8::from(specimen[i] == k)),
            Some(0) => x[i],
            Some(_) => (x[i] - mean).powi(2),
        });
        let found = svd(j.clone(), true, true).solve(&target, 1e-14).expect("both factors were asked for");
        let residual = &target - &j * &found;
        let rounding = residual.norm() <= ROUNDING * target.norm();
        let fitted = &target - &residual;
        let errors = errors::of_specimens(&j, (&residual, &fitted), specimen, &curves, rounding);
        let t = if errors.free > 0 { t_quantile(0.95, errors.free) } else { f64::INFINITY };
        let bounded = |k: usize| {
            let half = if rounding { 0.0 } else { t * errors.deviations[k] };
            Bounded { value: found[k], interval: [found[k] - half, found[k] + half] }
        };
        ((0..count + columns).map(bounded).collect::<Vec<_>>(), residual, errors.clone())
    };
    let bend = solve(2).0[count + 1];
    let (found, residual, errors) = solve(1);
    let of_y = curves.iter().map(|rows| spread(y, rows)).sum::<f64>().sqrt();
    let offsets = found[..count].to_vec();
    let mut slope = found[count];
    let of_residual = residual.norm_squared() / (n - n.min(count + 1)).max(1) as f64 / slope.value.powi(2);
    let noise = of_residual.min(roughness(x, &curves).powi(2));
    let variance = curves.iter().map(|rows| spread(x, rows)).sum::<f64>() / n as f64;
    let attenuation = if noise > 0.0 { noise / variance } else { 0.0 };
    slope.interval[usize::from(slope.value > 0.0)] /= (1.0 - attenuation).max(0.0);
    Line { slope, offsets, misfit: residual.norm() / of_y, residual, errors, bend, attenuation }
}

impl Line {
    /// Whether another line through the same y lies within the likelihood of the intervals of this one.
    pub fn allows(&self, other: &Self) -> bool {
        let more = other.residual.norm_squared() - self.residual.norm_squared();
        self.errors.rise().is_some_and(|rise| more <= rise)
    }

    /// This line with intervals that include those of another one.
    pub fn with(mut self, other: &Self) -> Self {
        self.slope = self.slope.with(&other.slope);
        self.offsets.iter_mut().zip(&other.offsets).for_each(|(own, other)| *own = own.with(other));
        self
    }
}

/// Sum of the squared distances of some values from their mean.
fn spread(values: &[f64], rows: &[usize]) -> f64 {
    let centre = rows.iter().map(|i| values[*i]).sum::<f64>() / rows.len().max(1) as f64;
    rows.iter().map(|i| (values[*i] - centre).powi(2)).sum()
}

/// Standard deviation of independent errors that would explain the roughness of x from row to row.
fn roughness(x: &[f64], curves: &[Vec<usize>]) -> f64 {
    let second = |w: &[usize]| (x[w[0]] - 2.0 * x[w[1]] + x[w[2]]).abs();
    let differences: Vec<f64> = curves.iter().flat_map(|rows| rows.windows(3).map(second)).collect();
    if differences.is_empty() { 0.0 } else { median(&differences) / (MEDIAN * 6f64.sqrt()) }
}
