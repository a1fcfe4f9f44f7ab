//! Tests of the residuals of a fit for a pattern.

use super::error_rows::ErrorRows;
use crate::calibrate::Sample;
use crate::calibrate::judgement::correlation::Correlation;
use crate::calibrate::judgement::errors;
use crate::calibrate::judgement::identify;
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::judgement::repeats::Repeats;
use crate::math::statistics;
use nalgebra::DVector;

/// Tests of the residuals for a pattern that the error model does not explain.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pattern {
    /// Number of runs of signs, after the correlation of neighbours is removed
    pub runs: Option<usize>,
    /// Probability of as few runs or fewer \[–\]
    pub runs_p: Option<f64>,
    /// Two-sided p-value of β = 0 in P = P(λ) + β P(λ)/λ \[–\]; `None` with too few data points
    pub departure_p: Option<f64>,
    /// Standard deviation of an independent data point after fitting the constants and β, in the form used for standard errors, with its degrees of
    /// freedom
    pub beyond: Option<(f64, usize)>,
}

/// Level of each of the two tests: together at most 5 % false alarms \[–\]
const LEVEL: f64 = 0.025;

impl Pattern {
    /// The smaller probability of the two tests.
    pub fn least(&self) -> f64 {
        [self.runs_p, self.departure_p].into_iter().flatten().fold(1.0, f64::min)
    }

    /// Whether this pattern, one of `among` tested ones, is not explained by random errors.
    pub fn is_found(&self, among: usize) -> bool {
        self.least() * among as f64 <= LEVEL
    }

    /// Tests residuals of data points with this correlation.
    pub fn of(samples: &[Sample], rows: &ErrorRows, correlation: Correlation) -> Self {
        let second = DVector::from_fn(samples.len(), |i, _| rows.fitted[i] / samples[i].stretch);
        let (runs, runs_p) = runs(samples, &rows.unlimited, correlation).unzip();
        let (departure_p, beyond) = departure(rows, second, samples).unzip();
        Self { runs, runs_p, departure_p, beyond }
    }
}

/// A correlated curve of n data points is divided into blocks of n/`BLOCKS` data points (rounded down, at least one): fewer than 2 `BLOCKS` blocks
const BLOCKS: usize = 200;

/// Number of runs of signs with their probability: for independent errors in the order of λ, for correlated errors in the order of loading after
/// removing what their neighbours explain, independent of the direction of the order; `None` for several specimens in one mode, whose levels differ.
///
/// For long curves with correlated errors the signs are those of the means of blocks: in tables with very many data points, which become means of
/// neighbours, the part that the neighbours do not explain is correlated by up to ¼ from one mean to the next (Working, Econometrica 28, 1960,
/// 916–918), which thousands of signs would detect.
fn runs(samples: &[Sample], residual: &DVector<f64>, correlation: Correlation) -> Option<(usize, f64)> {
    if !Repeats::of_samples(samples).repeated.is_empty() {
        return None;
    }
    let mut curves = errors::curves(samples);
    if correlation.is_none() {
        curves.iter_mut().for_each(|c| c.sort_by(|a, b| samples[*a].stretch.total_cmp(&samples[*b].stretch)));
    }
    let blocks = |curve: &Vec<usize>| {
        let size = if correlation.is_none() { 1 } else { (curve.len() / BLOCKS).max(1) };
        let white = correlation.whitened(residual, std::slice::from_ref(curve));
        white.chunks(size).map(|block| block.iter().sum::<f64>()).collect::<Vec<f64>>()
    };
    let signs = curves.iter().flat_map(blocks).filter(|r| *r != 0.0).map(|r| r > 0.0);
    statistics::few_runs(&signs.collect::<Vec<bool>>())
}

/// p-value of β = 0, and the errors beyond β, in P = P(λ) + β P(λ)/λ (for a neo-Hookean law in uniaxial tension β is Mooney's second constant): a
/// t-test with the error model of a fit that includes β, on the part of P/λ that the constants of the law cannot reproduce.
fn departure(rows: &ErrorRows, second: DVector<f64>, samples: &[Sample]) -> Option<(f64, (f64, usize))> {
    let ErrorRows { jacobian, residual, fitted, .. } = rows;
    let p = jacobian.ncols();
    residual.len().checked_sub(p + 1).filter(|n| *n >= 1)?;
    let across = identify::across(jacobian, &second);
    let across2 = across.norm_squared();
    if across2 <= 1e-16 * second.norm_squared() {
        return None;
    }
    let beta = across.dot(residual) / across2;
    let r2 = residual.norm_squared();
    let mut left = residual - &across * beta;
    if left.norm_squared() < f64::EPSILON * r2 {
        left *= (f64::EPSILON * r2 / left.norm_squared().max(f64::MIN_POSITIVE)).sqrt();
    }
    let mut more = jacobian.clone().insert_column(p, 0.0);
    more.set_column(p, &across);
    let errors = errors::of(&more, &left, fitted, &Origin::of(samples), false);
    let t = beta / errors.deviations[p];
    let p_value = (1.0 - statistics::t_probability(t, errors.free)).max(0.0);
    Some((p_value, (errors.wider(1.0), errors.free)))
}
