//! Error models of the data points, chosen by the data, and the resulting standard errors of the constants.
//!
//! The constants are always those of least squares, θ̂ = θ + Br with B = (JᵀJ)⁻¹Jᵀ; the data decide only the covariance BΣBᵀ of θ̂.
//!
//! *Specimens* (two or more in every test; for direct fits a test is a mode): the law of each specimen differs, and Σ has one block for each
//! ([`clusters`]). *Levels*: some tests have one specimen, and the scatter of the stress level in the other tests is used for them ([`levels`]). If
//! no test has two specimens, the files count as the curves of one specimen.
//!
//! *Correlated*: Σᵢⱼ = sᵢsⱼ[(1 − w)ρ^|i−j| + wδᵢⱼ] between data points of one curve (specimen and mode) in order of loading, where the sizes s are
//! all one, differ between the curves, or grow with the stress, as the data decide ([`correlated`]).
//!
//! *Unequal*: independent errors whose size changes with the stress or differs between the curves ([`Sizes`]). *Independent*, otherwise: s²(JᵀJ)⁻¹
//! with n − p degrees of freedom.
//!
//! Limit: linearised at the answer.

use super::clusters;
use super::correlation::Correlation;
use super::levels;
use super::origin::Origin;
use super::unequal::Sizes;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

pub use super::correlation::square;
pub use super::curve_errors::{curves, of_curves};
pub use super::directions::{Directions, directions};
pub use super::error_model::{ErrorModel, Errors};

use super::curve_errors::{Known, of_curves_along, smooth};
use super::directions::BLIND;

/// The errors of the constants of a law. `jacobian` (n × p), `residual` (n) and `fitted`, the stresses of the law (n), are weighted. `rounding` says
/// that the residual is only rounding.
pub fn of(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    fitted: &DVector<f64>,
    origin: &Origin,
    rounding: bool,
) -> Errors {
    let directions = directions(jacobian);
    let repeats = origin.repeats();
    let (n, p) = jacobian.shape();
    if repeats.repeated.is_empty() || n <= p {
        return of_one(&directions, (residual, rounding), fitted, &origin.curves);
    }
    if !repeats.single.is_empty() {
        return levels::between(&directions, (residual, rounding), fitted, origin, &repeats);
    }
    between(&directions, (residual, rounding), Some(fitted), &origin.specimen, &origin.curves)
}

/// The errors of the constants from the curves of one specimen.
fn of_one(
    directions: &Directions,
    (residual, rounding): (&DVector<f64>, bool),
    fitted: &DVector<f64>,
    curves: &[Vec<usize>],
) -> Errors {
    let apart = if rounding { None } else { Sizes::of_curves(directions, residual, fitted, curves) };
    let known = Known { fitted: Some(fitted), apart: apart.as_ref() };
    let found = of_curves_along(directions, residual, curves, rounding, known);
    if rounding || found.model != ErrorModel::Independent {
        return found;
    }
    match apart.or_else(|| Sizes::over_stress(directions, residual, fitted)) {
        Some(sizes) => sizes.independent(directions, residual, &found),
        None => found,
    }
}

/// The errors of the constants if the specimen of each row is given, in one mode. Residual and fitted values are weighted; `curves` are lists of rows
/// in order of loading. Columns that belong to one specimen, such as its own offset, count as constants of all.
pub fn of_specimens(
    jacobian: &DMatrix<f64>,
    (residual, fitted): (&DVector<f64>, &DVector<f64>),
    specimen: &[usize],
    curves: &[Vec<usize>],
    rounding: bool,
) -> Errors {
    let (n, p) = jacobian.shape();
    let directions = directions(jacobian);
    if specimen.iter().all(|k| *k == specimen[0]) || n <= p {
        return of_one(&directions, (residual, rounding), fitted, curves);
    }
    between(&directions, (residual, rounding), None, specimen, curves)
}

/// The errors of the constants from the scatter between specimens.
fn between(
    directions: &Directions,
    (residual, rounding): (&DVector<f64>, bool),
    fitted: Option<&DVector<f64>>,
    specimen: &[usize],
    curves: &[Vec<usize>],
) -> Errors {
    let all: std::collections::BTreeSet<usize> = specimen.iter().copied().collect();
    let rows = |one: usize| (0..specimen.len()).filter(|i| specimen[*i] == one).collect::<Vec<_>>();
    let specimens: Vec<Vec<usize>> = all.into_iter().map(rows).collect();
    let (k, factors) = clusters::scatter(directions, residual, fitted, &specimens);
    let mut alone = residual.clone();
    for own in &specimens {
        let (rows, errors) = (directions.u.select_rows(own), residual.select_rows(own));
        // Without the part that separate constants of the specimen would explain
        let inverse = svd(rows.transpose() * &rows, true, true).pseudo_inverse(BLIND).unwrap_or_default();
        let kept = &errors - &rows * inverse * (rows.transpose() * &errors);
        own.iter().zip(kept.iter()).for_each(|(i, r)| alone[*i] = *r);
    }
    let model = ErrorModel::Specimens { specimens: specimens.len() };
    let smooth = if rounding { 0.0 } else { smooth(&alone, curves) };
    directions.errors(model, &k, specimens.len() - 1, Correlation::default(), smooth).scaled(&factors)
}
