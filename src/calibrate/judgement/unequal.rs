//! Independent errors whose size changes with the stress: a test, and the covariance of the constants without one size of all.
//!
//! *Test*: nR² of eᵢ² = rᵢ²/(1 − hᵢ) over |P̂ᵢ|, the stresses of the law, is χ² of one degree of freedom where the size does not change (Koenker, J. Econometrics 17,
//! 1981, 107–112, the studentised form of Breusch & Pagan, 1979); hᵢ is the leverage uᵢᵀuᵢ. Taken at 5 %.
//!
//! *Covariance*: BDBᵀ with D = diag(eᵢ²), the HC2 of MacKinnon & White (J. Econometrics 29, 1985, 305–325), which is unbiased for errors of one size. Student's t has
//! Satterthwaite's degrees of freedom (tr Γ)²/tr Γ² of each constant (Bell & McCaffrey, Survey Methodology 28, 2002, 169–181), Γ = A(I − H)S(I − H)A with
//! A = diag(bᵢ/√(1 − hᵢ)), b the row of B and S the sizes that the line of the test gives.
//!
//! Limits: the size is one line over the stress in all modes; correlated errors are not tested.

use super::directions::Directions;
use super::error_model::{ErrorModel, Errors};
use crate::math::statistics::real_quantile;
use nalgebra::{DMatrix, DVector};

/// 95 % of χ² of one degree of freedom
const CHANGES: f64 = 3.841;
/// Data points beyond the constants that the test needs
const LEAST: usize = 8;
/// Smallest size on the line, over the mean of the squares \[–\]
const SMALLEST: f64 = 1e-3;
/// 1 − h of a data point that the constants follow, whose residual says nothing \[–\]
const FOLLOWED: f64 = 1e-9;

/// The errors of the constants, where the test finds that the size changes; `equal`: those of one size.
pub fn unequal(
    directions: &Directions,
    residual: &DVector<f64>,
    fitted: &DVector<f64>,
    equal: &Errors,
) -> Option<Errors> {
    let u = &directions.u;
    let n = u.nrows();
    let left: Vec<f64> = u.row_iter().map(|row| 1.0 - row.norm_squared()).collect();
    let square = |i: usize| if left[i] > FOLLOWED { residual[i].powi(2) / left[i] } else { 0.0 };
    let squares = DVector::from_fn(n, |i, _| square(i));
    let line = Line::of(&fitted.abs(), &squares)?;
    if equal.free < LEAST || n as f64 * line.explained <= CHANGES {
        return None;
    }
    let covariance = u.transpose() * DMatrix::from_fn(n, u.ncols(), |i, k| squares[i] * u[(i, k)]);
    let sizes = line.at.map(|s| s.max(SMALLEST * squares.mean()));
    let t = real_quantile(0.95, equal.free as f64);
    let factor = |row: usize| {
        let b = u * directions.by.row(row).transpose();
        let a2 = DVector::from_fn(n, |i, _| if left[i] > FOLLOWED { b[i].powi(2) / left[i] } else { 0.0 });
        real_quantile(0.95, degrees(u, &a2, &sizes).clamp(1.0, equal.free as f64)) / t
    };
    let factors: Vec<f64> = (0..directions.by.nrows()).map(factor).collect();
    let model = ErrorModel::Unequal { grow: line.slope > 0.0 };
    Some(directions.errors(model, &covariance, equal.free, 0.0, equal.smooth).scaled(&factors))
}

/// A straight line through y over x.
struct Line {
    slope: f64,
    /// Part of the variance of y, R²
    explained: f64,
    /// Its values
    at: DVector<f64>,
}

impl Line {
    fn of(x: &DVector<f64>, y: &DVector<f64>) -> Option<Self> {
        let (mx, my) = (x.mean(), y.mean());
        let (dx, dy) = (x.add_scalar(-mx), y.add_scalar(-my));
        let (xx, yy) = (dx.norm_squared(), dy.norm_squared());
        let slope = Some(dx.dot(&dy) / xx).filter(|s| s.is_finite() && yy > 0.0)?;
        Some(Self { slope, explained: slope * slope * xx / yy, at: (dx * slope).add_scalar(my) })
    }
}

/// (tr Γ)²/tr Γ² with the squares of the diagonal of A and the sizes; (I − H)S(I − H) = S + WCWᵀ, W = (U, SU), of p × p blocks.
fn degrees(u: &DMatrix<f64>, a2: &DVector<f64>, sizes: &DVector<f64>) -> f64 {
    let (n, p) = u.shape();
    let su = DMatrix::from_fn(n, p, |i, k| sizes[i] * u[(i, k)]);
    let inner = u.transpose() * &su;
    let w = DMatrix::from_fn(n, 2 * p, |i, k| if k < p { u[(i, k)] } else { su[(i, k - p)] });
    let minus = |a: usize, b: usize| if a == b { -1.0 } else { 0.0 };
    let c = DMatrix::from_fn(2 * p, 2 * p, |a, b| match (a < p, b < p) {
        (true, true) => inner[(a, b)],
        (true, false) => minus(a, b - p),
        (false, true) => minus(a - p, b),
        (false, false) => 0.0,
    });
    let wc = &w * &c;
    let low = DVector::from_fn(n, |i, _| wc.row(i).dot(&w.row(i)));
    let trace: f64 = (0..n).map(|i| a2[i] * (sizes[i] + low[i])).sum();
    let block = &c * (w.transpose() * DMatrix::from_fn(n, 2 * p, |i, k| a2[i] * w[(i, k)]));
    let own: f64 = (0..n).map(|i| a2[i].powi(2) * sizes[i] * (sizes[i] + 2.0 * low[i])).sum();
    trace * trace / (own + (&block * &block).trace())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::judgement::directions::directions;

    /// The degrees of freedom against Γ in full.
    #[test]
    fn degrees_are_those_of_the_dense_matrix() {
        let j = DMatrix::from_fn(12, 2, |i, k| (1.0 + 0.1 * i as f64).powi(k as i32 + 1));
        let u = directions(&j).u;
        let a2 = DVector::from_fn(12, |i, _| 0.1 + 0.02 * i as f64);
        let sizes = DVector::from_fn(12, |i, _| 1.0 + (i as f64).powi(2));
        let left = DMatrix::identity(12, 12) - &u * u.transpose();
        let a = DMatrix::from_diagonal(&a2.map(f64::sqrt));
        let gamma = &a * &left * DMatrix::from_diagonal(&sizes) * &left * &a;
        let dense = gamma.trace().powi(2) / (&gamma * &gamma).trace();
        assert!((degrees(&u, &a2, &sizes) / dense - 1.0).abs() < 1e-12);
    }
}
