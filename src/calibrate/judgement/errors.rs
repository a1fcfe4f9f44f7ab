//! Errors of the data points as the data show them, and the standard errors of the constants that follow.
//!
//! The constants are those of least squares, θ̂ = θ + Br with B = (JᵀJ)⁻¹Jᵀ, whatever the errors are; what the data decide is the covariance
//! BΣBᵀ of θ̂.
//!
//! *Specimens* (two or more in every mode): the law of each one differs, and Σ has one block of each ([`clusters`]). *Levels*: some modes have one specimen, and the
//! scatter of the stress level in the others is taken for them ([`levels`]). Where no mode has two specimens, the files are the curves of one.
//!
//! *Correlated*: Σᵢⱼ = σ²ρ^|i−j| between data points of one curve (specimen and mode) in order of loading ([`correlated`]).
//!
//! *Unequal*: independent, of a size that changes with the stress ([`unequal`]). *Independent*, else: s²(JᵀJ)⁻¹ with n − p degrees of freedom.
//!
//! Limit: linearised at the answer.

use super::clusters;
use super::correlated::correlated;
use super::levels;
use super::repeats::Repeats;
use super::unequal::unequal;
use crate::calibrate::Sample;
use crate::calibrate::solve::rows::padded;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::fmt;

pub use super::correlated::whitened;

/// Errors of the data points.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ErrorModel {
    /// Of every data point alone
    #[default]
    Independent,
    /// Of every data point alone, of a size that changes with the stress
    Unequal {
        /// Larger at large stresses
        grow: bool,
    },
    /// Of neighbours in order of loading
    Correlated {
        /// Correlation of neighbours, the mean over its likelihood \[–\]
        rho: f64,
        /// Independent data points with the same information about a mean
        effective: f64,
    },
    /// Of each specimen as a whole
    Specimens { specimens: usize },
    /// Of the stress level of each specimen, as the modes with several specimens show it
    Levels {
        specimens: usize,
        /// Degrees of freedom of the scatter: specimens beyond the first of each mode
        repeats: usize,
    },
}

impl fmt::Display for ErrorModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Independent => f.write_str("the errors of the data points are independent"),
            Self::Correlated { rho, effective } => write!(
                f,
                "the errors of neighbouring data points are correlated ({rho:.3}): they count as {effective:.1} independent ones"
            ),
            Self::Unequal { grow } => {
                let side = if *grow { "larger" } else { "smaller" };
                write!(f, "the errors of the data points are independent, and {side} at large stresses")
            }
            Self::Specimens { specimens } => write!(f, "scatter between {specimens} specimens"),
            Self::Levels { specimens, repeats } => write!(
                f,
                "scatter of the stress level between {specimens} specimens, from {repeats} repeats of a mode; modes with one specimen are taken to scatter alike"
            ),
        }
    }
}

/// Standard errors of the constants, with the model of the errors behind them.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    pub model: ErrorModel,
    /// Standard error of each column of the Jacobian; where the data do not determine it, of the part that they determine
    pub deviations: Vec<f64>,
    /// √((JᵀJ)⁻¹ⱼⱼ): the same of errors of size 1 that are independent
    pub plain: Vec<f64>,
    /// Degrees of freedom of Student's t; 0 where there are as many constants as data points
    pub free: usize,
    /// Most likely correlation of neighbours; 0 where they are independent
    pub rho: f64,
    /// ‖r‖ of what differs smoothly from the law: beyond the differences between neighbours, weighted as the residual
    pub smooth: f64,
    /// Covariance of the constants, of the part that the data determine
    pub covariance: DMatrix<f64>,
}

impl Errors {
    /// Largest ratio of a standard error to the one of independent errors of this size.
    pub fn wider(&self, size: f64) -> f64 {
        let ratio = |(d, plain): (&f64, &f64)| if *plain > 0.0 && size > 0.0 { d / (size * plain) } else { 1.0 };
        self.deviations.iter().zip(&self.plain).map(ratio).filter(|r| r.is_finite()).fold(0.0, f64::max)
    }

    /// With the standard error of each constant multiplied by a factor.
    pub fn scaled(mut self, factors: &[f64]) -> Self {
        self.deviations.iter_mut().zip(factors).for_each(|(d, f)| *d *= f);
        let scaled = |a: usize, b: usize| factors[a] * factors[b] * self.covariance[(a, b)];
        self.covariance = DMatrix::from_fn(factors.len(), factors.len(), scaled);
        self
    }
}

/// Singular value of a direction that is rounding \[–\]
const BLIND: f64 = 1e-10;

/// Data points of each curve, a specimen in one mode and direction, in order of loading.
pub fn curves(samples: &[Sample]) -> Vec<Vec<usize>> {
    let mut found: std::collections::BTreeMap<_, Vec<usize>> = std::collections::BTreeMap::new();
    // Both stresses of a biaxial data point are on one line
    for (k, s) in samples.iter().enumerate() {
        let second = k > 0 && s.mode == crate::calibrate::Mode::Biaxial && samples[k - 1].line == s.line;
        found.entry((s.specimen, s.mode, second)).or_default().push(k);
    }
    found.into_values().collect()
}

/// Orthonormal columns of the directions that the data determine, and θ of each of them.
pub struct Directions {
    /// \[data points × directions\]
    pub u: DMatrix<f64>,
    /// \[constants × directions\]
    pub by: DMatrix<f64>,
}

impl Directions {
    /// (JᵀJ)⁻¹Jᵀ on these directions, (p, n): a change of the weighted data into the one of the constants.
    pub fn inverse(&self) -> DMatrix<f64> {
        &self.by * self.u.transpose()
    }

    /// √((JᵀJ)⁻¹ⱼⱼ) of each constant.
    pub fn plain(&self) -> Vec<f64> {
        self.by.row_iter().map(|row| row.norm()).collect()
    }

    /// The errors of the constants from the covariance of the directions.
    pub fn errors(&self, model: ErrorModel, k: &DMatrix<f64>, free: usize, rho: f64, smooth: f64) -> Errors {
        let root = |c: &DMatrix<f64>| c.diagonal().iter().map(|c| c.max(0.0).sqrt()).collect::<Vec<f64>>();
        let covariance = &self.by * k * self.by.transpose();
        Errors { model, deviations: root(&covariance), plain: self.plain(), free, rho, smooth, covariance }
    }
}

/// Those of a Jacobian (n, p) whose columns may have any size.
pub fn directions(jacobian: &DMatrix<f64>) -> Directions {
    let p = jacobian.ncols();
    let length: Vec<f64> = (0..p).map(|k| jacobian.column(k).norm()).map(|l| if l > 0.0 { l } else { 1.0 }).collect();
    let scaled = DMatrix::from_fn(jacobian.nrows(), p, |i, k| jacobian[(i, k)] / length[k]);
    let svd = svd(padded(&scaled, p), true, true);
    let (u, vt, sigma) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"), svd.singular_values);
    let seen: Vec<usize> = (0..p).filter(|k| sigma[*k] > BLIND * sigma.max()).collect();
    Directions {
        u: DMatrix::from_fn(jacobian.nrows(), seen.len(), |i, k| u[(i, seen[k])]),
        by: DMatrix::from_fn(p, seen.len(), |j, k| vt[(seen[k], j)] / sigma[seen[k]] / length[j]),
    }
}

/// Those of the constants of a law. `jacobian` (n, p), `residual` and the stresses of the law, `fitted`, (n) are weighted; `rounding`: the residual is none.
pub fn of(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    fitted: &DVector<f64>,
    samples: &[Sample],
    rounding: bool,
) -> Errors {
    let directions = directions(jacobian);
    let repeats = Repeats::of(samples);
    let (n, p) = jacobian.shape();
    if repeats.repeated.is_empty() || n <= p {
        let found = of_curves_along(&directions, residual, &curves(samples), rounding);
        let equal = found.model == ErrorModel::Independent && !rounding;
        let other = if equal { unequal(&directions, residual, fitted, &found) } else { None };
        return other.unwrap_or(found);
    }
    if !repeats.single.is_empty() {
        return levels::between(&directions, (residual, rounding), fitted, samples, &repeats);
    }
    let specimens: Vec<usize> = samples.iter().map(|s| s.specimen).collect();
    between(&directions, (residual, rounding), Some(fitted), &specimens, &curves(samples))
}

/// The same with the specimen of each row, in one mode; `curves` are lists of rows in order of loading. Columns that belong to one specimen, such as an offset of
/// its own, count as constants of all.
pub fn of_specimens(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    specimen: &[usize],
    curves: &[Vec<usize>],
    rounding: bool,
) -> Errors {
    let (n, p) = jacobian.shape();
    let directions = directions(jacobian);
    if specimen.iter().all(|k| *k == specimen[0]) || n <= p {
        return of_curves_along(&directions, residual, curves, rounding);
    }
    between(&directions, (residual, rounding), None, specimen, curves)
}

/// The errors of the constants by the scatter between specimens.
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
        // Without what constants of its own would explain
        let inverse = svd(rows.transpose() * &rows, true, true).pseudo_inverse(BLIND).unwrap_or_default();
        let kept = &errors - &rows * inverse * (rows.transpose() * &errors);
        own.iter().zip(kept.iter()).for_each(|(i, r)| alone[*i] = *r);
    }
    let model = ErrorModel::Specimens { specimens: specimens.len() };
    let smooth = if rounding { 0.0 } else { smooth(&alone, curves) };
    directions.errors(model, &k, specimens.len() - 1, 0.0, smooth).scaled(&factors)
}

/// The same of one specimen, whose curves are lists of rows in order of loading.
pub fn of_curves(jacobian: &DMatrix<f64>, residual: &DVector<f64>, curves: &[Vec<usize>], rounding: bool) -> Errors {
    of_curves_along(&directions(jacobian), residual, curves, rounding)
}

/// The same along directions that are known.
pub fn of_curves_along(
    directions: &Directions,
    residual: &DVector<f64>,
    curves: &[Vec<usize>],
    rounding: bool,
) -> Errors {
    let p = directions.by.nrows();
    let free = residual.len().saturating_sub(p);
    let smooth = if rounding { 0.0 } else { smooth(residual, curves) };
    let found = if rounding || free < 2 { None } else { correlated(&directions.u, residual, curves, p) };
    if let Some((model, rho, k, free)) = found {
        return directions.errors(model, &k, free, rho, smooth);
    }
    let s2 = if free > 0 { residual.norm_squared() / free as f64 } else { f64::INFINITY };
    let seen = directions.u.ncols();
    let of_size_1 = directions.errors(ErrorModel::Independent, &DMatrix::identity(seen, seen), free, 0.0, smooth);
    let deviations = of_size_1.plain.iter().map(|d| s2.sqrt() * d).collect();
    Errors { deviations, covariance: &of_size_1.covariance * s2, ..of_size_1 }
}

/// ‖r‖ beyond independent noise: σ² is the mean of (rᵢ − ½(rᵢ₋₁ + rᵢ₊₁))²/1.5 (Gasser, Sroka & Jennen-Steinmetz 1986), of which two standard
/// deviations are allowed for, nσ²(1 + 4/√n).
fn smooth(residual: &DVector<f64>, curves: &[Vec<usize>]) -> f64 {
    let bend = |w: &[usize]| (residual[w[1]] - 0.5 * (residual[w[0]] + residual[w[2]])).powi(2) / 1.5;
    let all: Vec<f64> = curves.iter().flat_map(|c| c.windows(3).map(bend)).collect();
    if all.is_empty() {
        return 0.0;
    }
    let n = residual.len() as f64;
    let noise = all.iter().sum::<f64>() / all.len() as f64;
    (residual.norm_squared() - n * noise * (1.0 + 4.0 / n.sqrt())).max(0.0).sqrt()
}
