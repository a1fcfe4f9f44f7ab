//! Errors of the constants from the data points of one specimen, whose curves are in order of loading.

use super::correlated::{Scaled, correlated};
use super::correlation::Correlation;
use super::directions::{Directions, directions};
use super::error_model::{ErrorModel, Errors};
use super::unequal::Sizes;
use crate::calibrate::Sample;
use crate::calibrate::sample::tests;
use nalgebra::{DMatrix, DVector};

/// Data points of each curve (a specimen in one test and direction), in order of loading.
pub fn curves(samples: &[Sample]) -> Vec<Vec<usize>> {
    let mut found: std::collections::BTreeMap<_, Vec<usize>> = std::collections::BTreeMap::new();
    // Both stresses of a biaxial data point are on one line
    for (k, (s, test)) in samples.iter().zip(tests(samples)).enumerate() {
        let second = k > 0 && s.mode == crate::calibrate::Mode::Biaxial && samples[k - 1].line == s.line;
        found.entry((s.specimen, test, second)).or_default().push(k);
    }
    found.into_values().collect()
}

/// The errors from curves that are lists of rows.
pub fn of_curves(jacobian: &DMatrix<f64>, residual: &DVector<f64>, curves: &[Vec<usize>], rounding: bool) -> Errors {
    of_curves_along(&directions(jacobian), residual, curves, rounding, Known::default())
}

/// Known facts about the sizes of the errors.
#[derive(Clone, Copy, Default)]
pub struct Known<'a> {
    /// Stresses of the law, with which errors may grow
    pub fitted: Option<&'a DVector<f64>>,
    /// Sizes of the errors of each curve, if they differ
    pub apart: Option<&'a Sizes>,
}

/// The errors from curves that are lists of rows, along known directions.
pub fn of_curves_along(
    directions: &Directions,
    residual: &DVector<f64>,
    curves: &[Vec<usize>],
    rounding: bool,
    known: Known,
) -> Errors {
    let p = directions.by.nrows();
    let free = residual.len().saturating_sub(p);
    let smooth = if rounding { 0.0 } else { smooth(residual, curves) };
    if !rounding && free >= 2 {
        let grown = known.fitted.filter(|f| f.amax() > 0.0).map(Sizes::grown);
        let choices = std::iter::once(known.apart).chain(grown.iter().flatten().map(Some));
        let rows = |sizes: Option<&Sizes>| match sizes {
            Some(sizes) => sizes.scaled(directions, residual),
            None => Some(Scaled::equal(directions, residual)),
        };
        let (sizes, rows): (Vec<_>, Vec<_>) = choices.filter_map(|sizes| Some((sizes, rows(sizes)?))).unzip();
        if let Some(found) = correlated(&rows, curves, p) {
            let most = (0..sizes.len()).max_by(|a, b| found.shares[*a].total_cmp(&found.shares[*b]));
            let most = most.and_then(|k| sizes[k]);
            let grow = most.is_some_and(Sizes::grow);
            let model = ErrorModel::Correlated { rho: found.rho, effective: found.effective, grow };
            let errors = directions.errors(model, &found.covariance, found.free, found.likely, smooth);
            return Errors { sizes: most.map(Sizes::deviations), ..errors };
        }
    }
    let s2 = if free > 0 { residual.norm_squared() / free as f64 } else { f64::INFINITY };
    let seen = directions.u.ncols();
    let none = Correlation::default();
    let of_size_1 = directions.errors(ErrorModel::Independent, &DMatrix::identity(seen, seen), free, none, smooth);
    let deviations = of_size_1.plain.iter().map(|d| s2.sqrt() * d).collect();
    Errors { deviations, covariance: &of_size_1.covariance * s2, ..of_size_1 }
}

/// The part of ‖r‖ beyond independent noise: σ² is the mean of (rᵢ − ½(rᵢ₋₁ + rᵢ₊₁))²/1.5 (Gasser, Sroka & Jennen-Steinmetz 1986), and the noise may
/// reach two standard deviations above it, nσ²(1 + 4/√n).
pub fn smooth(residual: &DVector<f64>, curves: &[Vec<usize>]) -> f64 {
    let bend = |w: &[usize]| (residual[w[1]] - 0.5 * (residual[w[0]] + residual[w[2]])).powi(2) / 1.5;
    let all: Vec<f64> = curves.iter().flat_map(|c| c.windows(3).map(bend)).collect();
    if all.is_empty() {
        return 0.0;
    }
    let n = residual.len() as f64;
    let noise = all.iter().sum::<f64>() / all.len() as f64;
    (residual.norm_squared() - n * noise * (1.0 + 4.0 / n.sqrt())).max(0.0).sqrt()
}
