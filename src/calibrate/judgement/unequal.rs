//! Errors of unequal size, independent or correlated: a different size for each curve, or one that changes with the stress.
//!
//! *Curves* (a mode and direction of one specimen): if all curves have one size, nR² of the regression of eᵢ² = rᵢ²/(1 − hᵢ) on the means of the
//! curves is χ²-distributed with one degree of freedom less than there are curves (Koenker, J. Econometrics 17, 1981, 107–112, the studentised form
//! of Breusch & Pagan, 1979); hᵢ = uᵢᵀuᵢ is the leverage. The variances of the curves follow from restricted likelihood for independent errors, s_k²
//! = Σrᵢ²/Σ(1 − hᵢ) over curve k, with r and h of least squares with the weights 1/s (Harville, J. Am. Stat. Assoc. 72, 1977, 320–338). With equal
//! weights, the residual of a quiet curve would be dominated by the error of the constants due to a noisy one, which is smooth and looks like a
//! correlation.
//!
//! *Stress*: nR² of the regression of eᵢ² on |P̂ᵢ|, with P̂ the stresses of the law, is χ²-distributed with one degree of freedom if the size does
//! not change. Both tests use a level of 5 %; separate sizes of the curves are used if they explain more of the eᵢ² than the stress does.
//!
//! *Covariance*: BDBᵀ with D = diag(eᵢ²), the HC2 of MacKinnon & White (J. Econometrics 29, 1985, 305–325), which is unbiased for errors of one size.
//! Student's t has Satterthwaite's degrees of freedom (tr Γ)²/tr Γ² for each constant (Bell & McCaffrey, Survey Methodology 28, 2002, 169–181), Γ =
//! A(I − H)S(I − H)A with A = diag(bᵢ/√(1 − hᵢ)), b the row of B and S the sizes of the test. For correlated errors whose sizes differ between curves
//! or grow with the stress, [`super::correlated`] is applied to the rows divided by their sizes.
//!
//! Limits: one line over the stress for all modes; all curves with fewer than four data points share one size.

use super::correlated::Scaled;
use super::correlation::Correlation;
use super::directions::{Directions, directions};
use super::error_model::{ErrorModel, Errors};
use crate::math::statistics::{extent, real_quantile};
use nalgebra::{DMatrix, DVector};

/// 95 % quantiles of χ² of one to eleven degrees of freedom: a specimen of a direct fit has at most nine curves, both sides of three modes, shear and
/// two directions of a biaxial test; more than twelve curves of an inverse analysis have errors of one size
const CHANGES: [f64; 11] = [3.841, 5.991, 7.815, 9.488, 11.070, 12.592, 14.067, 15.507, 16.919, 18.307, 19.675];
/// Number of data points, beyond the number of constants, that the tests need
const LEAST: usize = 8;
/// Least number of data points of a curve with its own size
const OWN: usize = 4;
/// Smallest squared size relative to the mean of the squares \[–\]
const SMALLEST: f64 = 1e-3;
/// 1 − h below which the constants follow a data point, so that its residual says nothing \[–\]
const FOLLOWED: f64 = 1e-9;
/// Stress relative to the largest below which the size of the errors no longer decreases \[–\]
const FLOOR: f64 = 0.05;
/// Number of iterations for the sizes of curves: each multiplies the error by about the leverage of a curve
const ROUNDS: usize = 8;

/// Squared sizes of the errors of the data points, and the model that they follow.
pub struct Sizes {
    at: DVector<f64>,
    model: ErrorModel,
}

impl Sizes {
    /// A separate size for each curve, if the test finds that they differ by more than the stress explains.
    pub fn of_curves(
        directions: &Directions,
        residual: &DVector<f64>,
        fitted: &DVector<f64>,
        curves: &[Vec<usize>],
    ) -> Option<Self> {
        let (long, short): (Vec<_>, Vec<_>) = curves.iter().cloned().partition(|c| c.len() >= OWN);
        let short = short.concat();
        let groups: Vec<Vec<usize>> = long.into_iter().chain((!short.is_empty()).then_some(short)).collect();
        let n = residual.len();
        if groups.len() < 2 || n < directions.by.nrows() + LEAST {
            return None;
        }
        let (squares, _) = squares(directions, residual);
        let mean = squares.mean();
        let of = |g: &Vec<usize>| g.iter().map(|i| squares[*i]).sum::<f64>() / g.len() as f64;
        let between: f64 = groups.iter().map(|g| g.len() as f64 * (of(g) - mean).powi(2)).sum();
        let explained = between / squares.add_scalar(-mean).norm_squared();
        let limit = CHANGES.get(groups.len() - 2)?;
        let by_stress = Line::of(&fitted.abs(), &squares).map_or(0.0, |line| line.explained);
        if !(explained > by_stress && n as f64 * explained > *limit) {
            return None;
        }
        let mut at = DVector::zeros(n);
        groups.iter().for_each(|g| g.iter().for_each(|i| at[*i] = of(g).max(SMALLEST * mean)));
        for _ in 0..ROUNDS {
            let (u, rest) = weighed(&at, directions, residual);
            for g in &groups {
                let free: f64 = g.iter().map(|i| 1.0 - u.row(*i).norm_squared()).sum();
                let sum: f64 = g.iter().map(|i| rest[*i].powi(2)).sum();
                let factor = if free > FOLLOWED { sum / free } else { 1.0 };
                g.iter().for_each(|i| at[*i] = (at[*i] * factor).max(SMALLEST.powi(2) * mean));
            }
        }
        let [least, most] = extent(at.iter().copied());
        Some(Self { at, model: ErrorModel::UnequalCurves { ratio: (most / least).sqrt() } })
    }

    /// A linear function of the stress, if the test finds that the size changes with it.
    pub fn over_stress(directions: &Directions, residual: &DVector<f64>, fitted: &DVector<f64>) -> Option<Self> {
        let (squares, _) = squares(directions, residual);
        let line = Line::of(&fitted.abs(), &squares)?;
        let n = residual.len();
        if n < directions.by.nrows() + LEAST || n as f64 * line.explained <= CHANGES[0] {
            return None;
        }
        let at = line.at.map(|s| s.max(SMALLEST * squares.mean()));
        Some(Self { at, model: ErrorModel::Unequal { grow: line.slope > 0.0 } })
    }

    /// Candidates for correlated errors that grow with the stress: with its square root, and in proportion to it.
    pub fn grown(fitted: &DVector<f64>) -> [Self; 2] {
        let least = FLOOR * fitted.amax();
        [1.0, 2.0].map(|power: f64| Self {
            at: fitted.map(|p| p.abs().max(least).powf(power)),
            model: ErrorModel::Unequal { grow: true },
        })
    }

    /// The standard deviations of the data points, up to a factor.
    pub fn deviations(&self) -> DVector<f64> {
        self.at.map(f64::sqrt)
    }

    /// Whether the errors grow with the stress.
    pub fn grow(&self) -> bool {
        self.model == ErrorModel::Unequal { grow: true }
    }

    /// The errors of the constants due to independent errors of these sizes; `equal`: the errors of the constants for errors of one size.
    pub fn independent(&self, directions: &Directions, residual: &DVector<f64>, equal: &Errors) -> Errors {
        let u = &directions.u;
        let n = u.nrows();
        let (squares, left) = squares(directions, residual);
        let covariance = u.transpose() * DMatrix::from_fn(n, u.ncols(), |i, k| squares[i] * u[(i, k)]);
        let t = real_quantile(0.95, equal.free as f64);
        let factor = |row: usize| {
            let b = u * directions.by.row(row).transpose();
            let a2 = DVector::from_fn(n, |i, _| if left[i] > FOLLOWED { b[i].powi(2) / left[i] } else { 0.0 });
            real_quantile(0.95, degrees(u, &a2, &self.at).clamp(1.0, equal.free as f64)) / t
        };
        let factors: Vec<f64> = (0..directions.by.nrows()).map(factor).collect();
        let found = directions
            .errors(self.model, &covariance, equal.free, Correlation::default(), equal.smooth)
            .scaled(&factors);
        let of_curves = matches!(self.model, ErrorModel::UnequalCurves { .. });
        Errors { sizes: of_curves.then(|| self.deviations()), ..found }
    }

    /// The rows divided by these sizes; `None` if a direction vanishes.
    pub fn scaled(&self, directions: &Directions, residual: &DVector<f64>) -> Option<Scaled> {
        let (u, rest) = weighed(&self.at, directions, residual);
        let (n, p) = directions.u.shape();
        let along = DMatrix::from_fn(n, p, |i, k| self.at[i].sqrt() * directions.u[(i, k)]);
        let over = DMatrix::from_fn(n, p, |i, k| directions.u[(i, k)] / self.at[i].sqrt());
        let columns: f64 = (over.transpose() * &over).cholesky()?.l().diagonal().iter().map(|d| d.ln()).sum();
        let log = -0.5 * self.at.iter().map(|s| s.ln()).sum::<f64>() - columns;
        (u.ncols() == p && log.is_finite()).then_some(Scaled { u, residual: rest, along, log })
    }
}

/// eᵢ² and 1 − hᵢ.
fn squares(directions: &Directions, residual: &DVector<f64>) -> (DVector<f64>, Vec<f64>) {
    let left: Vec<f64> = directions.u.row_iter().map(|row| 1.0 - row.norm_squared()).collect();
    let square = |i: usize| if left[i] > FOLLOWED { residual[i].powi(2) / left[i] } else { 0.0 };
    (DVector::from_fn(residual.len(), |i, _| square(i)), left)
}

/// Directions and least-squares residual with the weights 1/√at.
fn weighed(at: &DVector<f64>, equal: &Directions, residual: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let (n, p) = equal.u.shape();
    let u = directions(&DMatrix::from_fn(n, p, |i, k| equal.u[(i, k)] / at[i].sqrt())).u;
    let over = DVector::from_fn(n, |i, _| residual[i] / at[i].sqrt());
    let rest = &over - &u * (u.transpose() * &over);
    (u, rest)
}

/// A linear regression of y on x.
struct Line {
    slope: f64,
    /// Explained share of the variance of y, R²
    explained: f64,
    /// Values of the line
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

/// (tr Γ)²/tr Γ² from the squares of the diagonal of A and the sizes; with (I − H)S(I − H) = S + WCWᵀ, W = (U, SU), only p × p blocks are needed.
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

    /// Compares the degrees of freedom with the full matrix Γ.
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
