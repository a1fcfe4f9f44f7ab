//! Covariance of the constants if only some tests (in a direct fit: modes) have several specimens: the scatter of their levels is used for the others
//! too.
//!
//! Each specimen has a level δⱼ on the stresses P̂ of the law, δ = r·P̂/P̂² of its curve. The variance τ² of δ is estimated within the tests with
//! several specimens, with ν_τ = Σ(k − 1) degrees of freedom. The covariance of the directions is τ² Σⱼ(UⱼᵀP̂ⱼ)(UⱼᵀP̂ⱼ)ᵀ, plus the covariance from
//! the curves without their levels (independent or correlated errors). Student's t has Satterthwaite's degrees of freedom (a + d)²/(a²/ν_τ + d²/ν_d)
//! of both parts (Biometrics Bull. 2, 1946, 110–114). Standard errors are stated for ν_τ degrees.
//!
//! Limits: specimens of tests without a repeat are assumed to scatter like those of the other tests, and only in level, not in the shape of the
//! curve.

use super::clusters;
use super::curve_errors::{Known, of_curves_along};
use super::directions::Directions;
use super::error_model::{ErrorModel, Errors};
use super::origin::Origin;
use super::repeats::Repeats;
use crate::math::statistics::real_quantile;
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};

/// The errors of the constants from the levels of the specimens in the repeated tests.
pub fn between(
    directions: &Directions,
    (residual, rounding): (&DVector<f64>, bool),
    fitted: &DVector<f64>,
    origin: &Origin,
    Repeats { repeated, .. }: &Repeats<usize>,
) -> Errors {
    let u = &directions.u;
    let mut tests: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    let Origin { specimen, test, curves } = origin;
    specimen.iter().zip(test).enumerate().for_each(|(i, (s, t))| tests.entry((*s, *t)).or_default().push(i));
    let tests: Vec<Vec<usize>> = tests.into_values().collect();
    let levels = clusters::levels(residual, fitted, &tests);
    let mut alone = residual.clone();
    for (rows, level) in tests.iter().zip(&levels) {
        rows.iter().for_each(|i| alone[*i] -= level * fitted[*i]);
    }
    let (tau2, free) = variance(&tests, &levels, test, repeated);
    let mut by_level = DMatrix::zeros(u.ncols(), u.ncols());
    let specimens: BTreeSet<usize> = specimen.iter().copied().collect();
    for one in &specimens {
        let own: Vec<usize> = (0..specimen.len()).filter(|i| specimen[*i] == *one).collect();
        let pull = u.select_rows(&own).transpose() * fitted.select_rows(&own);
        by_level += &pull * pull.transpose() * tau2;
    }
    let known = Known { fitted: Some(fitted), apart: None };
    let noise = of_curves_along(directions, &alone, curves, rounding, known);
    let model = ErrorModel::Levels { specimens: specimens.len(), repeats: free };
    let level = directions.errors(model, &by_level, free, noise.correlation, noise.smooth);
    let t = real_quantile(0.95, free as f64);
    let factor = |(a, d): (&f64, &f64)| {
        let (a, d) = (a * a, d * d);
        let both = (a + d).powi(2) / (a * a / free as f64 + d * d / noise.free.max(1) as f64);
        if both.is_finite() { real_quantile(0.95, both.max(1.0)) / t } else { 1.0 }
    };
    let factors: Vec<f64> = level.deviations.iter().zip(&noise.deviations).map(factor).collect();
    let deviations = level.deviations.iter().zip(&noise.deviations).map(|(a, d)| a.hypot(*d)).collect();
    let covariance = &level.covariance + &noise.covariance;
    Errors { deviations, covariance, ..level }.scaled(&factors)
}

/// Variance of the levels within the repeated tests, and its degrees of freedom. `test`: the test of each data point.
fn variance(curves: &[Vec<usize>], levels: &[f64], test: &[usize], repeated: &[usize]) -> (f64, usize) {
    let (mut sum, mut free) = (0.0, 0);
    for one in repeated {
        let own: Vec<f64> = curves.iter().zip(levels).filter(|(c, _)| test[c[0]] == *one).map(|(_, l)| *l).collect();
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        sum += own.iter().map(|l| (l - mean).powi(2)).sum::<f64>();
        free += own.len() - 1;
    }
    (sum / free.max(1) as f64, free.max(1))
}
