//! Errors of the data points as the data show them, and the standard errors of the constants that follow.
//!
//! The constants are those of least squares, θ̂ = θ + Br with B = (JᵀJ)⁻¹Jᵀ, whatever the errors are; what the data decide is the covariance
//! BΣBᵀ of θ̂.
//!
//! *Specimens* (two or more): the law of each one differs, and Σ has one block of each, rⱼrⱼᵀ: k/(k − 1) Σⱼ (Bⱼrⱼ)(Bⱼrⱼ)ᵀ (Liang & Zeger, Biometrika 73,
//! 1986, 13–22), with k − 1 degrees of freedom. Of specimens with the same stretches it is the covariance s²/k of the mean.
//!
//! *Correlated*: Σᵢⱼ = σ²ρ^|i−j| between data points of one curve (specimen and mode) in order of loading. The restricted likelihood of ρ (Patterson &
//! Thompson, Biometrika 58, 1971; it counts the constants, so that ρ is not too small by their number),
//! ℓ(ρ) = −½[ln|Σ| + ln|JᵀΣ⁻¹J| + (n − p) ln r̃ᵀΣ⁻¹r̃] by the differences of Prais & Winsten (1954), is compared with the one of ρ = 0: the model is
//! taken where 2Δℓ exceeds 1.642 (10 %, one-sided: ρ ≥ 0). The covariance is the mean over ρ with the weight exp ℓ, uniform in ρ before the data:
//! at the most likely ρ alone the intervals are too narrow. Student's t has n_eff − p degrees of freedom, n_eff = n(1 − ρ)/(1 + ρ) independent data
//! points. A correlation that leaves fewer than p + 2 of them is a departure of the law, which one curve cannot tell from noise: ρ ends there, and
//! σ² is then that of the residual itself, rᵀr/(n − tr UᵀRU) with R = Σ/σ² and U an orthonormal basis of the columns of J, where that is the larger one.
//!
//! *Independent*, else: s²(JᵀJ)⁻¹ with n − p degrees of freedom.
//!
//! Limits: linearised at the answer; one ρ of all curves; two data points count as neighbours however far apart their stretches are.

use crate::calibrate::Sample;
use crate::calibrate::solve::rows::padded;
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Errors of the data points.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ErrorModel {
    /// Of every data point alone
    #[default]
    Independent,
    /// Of neighbours in order of loading
    Correlated {
        /// Correlation of neighbours, the mean over its likelihood \[–\]
        rho: f64,
        /// Independent data points with the same information about a mean
        effective: f64,
    },
    /// Of each specimen as a whole
    Specimens { specimens: usize },
}

impl fmt::Display for ErrorModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Independent => f.write_str("the errors of the data points are independent"),
            Self::Correlated { rho, effective } => write!(
                f,
                "the errors of neighbouring data points are correlated ({rho:.3}): they count as {effective:.1} independent ones"
            ),
            Self::Specimens { specimens } => write!(f, "scatter between {specimens} specimens"),
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
}

/// Correlations of the grid, ρ_max √(k/45)
const GRID: u32 = 46;
/// Independent data points beyond the constants that the largest correlation leaves
const LEFT: f64 = 2.0;
/// 2Δℓ from which on errors count as correlated: χ² of one degree of freedom, 80 %, for a one-sided test at 10 %
const CORRELATED: f64 = 1.642;
/// Weight of a correlation below which it is left out \[–\]
const NONE: f64 = 1e-5;
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

/// Sums of products of the columns and the residual over neighbours, of which those of the differences by any ρ consist.
struct Products {
    n: f64,
    curves: f64,
    /// Σ zzᵀ over all, over all but the first and last of each curve, and of neighbours (symmetric part) with z = (U, r)
    all: DMatrix<f64>,
    inner: DMatrix<f64>,
    next: DMatrix<f64>,
}

impl Products {
    fn new(z: &DMatrix<f64>, curves: &[Vec<usize>]) -> Self {
        let width = z.ncols();
        let zero = || DMatrix::<f64>::zeros(width, width);
        let (mut all, mut inner, mut next) = (zero(), zero(), zero());
        let add = |to: &mut DMatrix<f64>, i: usize, j: usize| {
            for a in 0..width {
                for b in 0..width {
                    to[(a, b)] += 0.5 * (z[(i, a)] * z[(j, b)] + z[(j, a)] * z[(i, b)]);
                }
            }
        };
        for curve in curves {
            for (place, k) in curve.iter().enumerate() {
                add(&mut all, *k, *k);
                if place > 0 {
                    add(&mut next, curve[place - 1], *k);
                }
                if place > 0 && place + 1 < curve.len() {
                    add(&mut inner, *k, *k);
                }
            }
        }
        Self { n: z.nrows() as f64, curves: curves.len() as f64, all, inner, next }
    }

    /// Restricted log-likelihood of ρ and the variance σ² of the errors.
    fn likelihood(&self, rho: f64) -> Option<(f64, f64)> {
        let p = self.all.ncols() - 1;
        let free = self.n - p as f64;
        let whole = &self.all + &self.inner * (rho * rho) - &self.next * (2.0 * rho);
        let columns = whole.view((0, 0), (p, p)).into_owned();
        let slope = whole.view((0, p), (p, 1)).into_owned();
        let factor = columns.cholesky()?;
        let square = whole[(p, p)] - (slope.transpose() * factor.solve(&slope))[(0, 0)];
        let square = Some(square).filter(|s| *s > 0.0)?;
        let log_columns: f64 = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let log_errors = -self.curves * (1.0 - rho * rho).ln();
        Some((-0.5 * (log_errors + log_columns + free * square.ln()), square / free / (1.0 - rho * rho)))
    }
}

/// Σᵢⱼ uᵢuⱼᵀρ^|i−j| over the pairs of each curve.
fn spread(u: &DMatrix<f64>, curves: &[Vec<usize>], rho: f64) -> DMatrix<f64> {
    let p = u.ncols();
    let mut sum = u.transpose() * u;
    let mut before = vec![0.0; p];
    for curve in curves {
        before.fill(0.0);
        for k in curve {
            for a in 0..p {
                for b in 0..p {
                    sum[(a, b)] += u[(*k, a)] * before[b] + before[a] * u[(*k, b)];
                }
            }
            (0..p).for_each(|a| before[a] = rho * (before[a] + u[(*k, a)]));
        }
    }
    sum
}

/// Orthonormal columns of the directions that the data determine, and θ of each of them.
pub struct Directions {
    u: DMatrix<f64>,
    /// \[constants × directions\]
    by: DMatrix<f64>,
}

impl Directions {
    /// (JᵀJ)⁻¹Jᵀ on these directions, (p, n): a change of the weighted data into the one of the constants.
    pub fn inverse(&self) -> DMatrix<f64> {
        &self.by * self.u.transpose()
    }

    /// The errors of the constants from the covariance of the directions.
    fn errors(&self, model: ErrorModel, k: &DMatrix<f64>, free: usize, rho: f64, smooth: f64) -> Errors {
        let root = |c: &DMatrix<f64>| c.diagonal().iter().map(|c| c.max(0.0).sqrt()).collect::<Vec<f64>>();
        let covariance = &self.by * k * self.by.transpose();
        let plain = root(&(&self.by * self.by.transpose()));
        Errors { model, deviations: root(&covariance), plain, free, rho, smooth, covariance }
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

/// `jacobian` and `residual` are weighted, (n, p) and (n); `rounding`: the residual is none.
pub fn of(jacobian: &DMatrix<f64>, residual: &DVector<f64>, samples: &[Sample], rounding: bool) -> Errors {
    let specimens: Vec<usize> = samples.iter().map(|s| s.specimen).collect();
    of_specimens(jacobian, residual, &specimens, &curves(samples), rounding)
}

/// The same with the specimen of each row; `curves` are lists of rows in order of loading. Columns that belong to one specimen, such as an offset of
/// its own, count as constants of all.
pub fn of_specimens(
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    specimen: &[usize],
    curves: &[Vec<usize>],
    rounding: bool,
) -> Errors {
    let specimens = specimen.iter().copied().collect::<std::collections::BTreeSet<_>>();
    let (n, p) = jacobian.shape();
    let k = specimens.len();
    if k < 2 || n <= p {
        return of_curves(jacobian, residual, curves, rounding);
    }
    let directions = directions(jacobian);
    let u = &directions.u;
    let mut sum = DMatrix::zeros(u.ncols(), u.ncols());
    let mut alone = residual.clone();
    for one in specimens {
        let own: Vec<usize> = (0..n).filter(|i| specimen[*i] == one).collect();
        let (rows, errors) = (u.select_rows(&own), residual.select_rows(&own));
        let pull = rows.transpose() * &errors;
        sum += &pull * pull.transpose();
        // Without what constants of its own would explain
        let inverse = svd(rows.transpose() * &rows, true, true).pseudo_inverse(BLIND).unwrap_or_default();
        let kept = &errors - &rows * inverse * &pull;
        own.iter().zip(kept.iter()).for_each(|(i, r)| alone[*i] = *r);
    }
    let smooth = if rounding { 0.0 } else { smooth(&alone, curves) };
    let model = ErrorModel::Specimens { specimens: k };
    directions.errors(model, &(sum * (k as f64 / (k - 1) as f64)), k - 1, 0.0, smooth)
}

/// The same of one specimen, whose curves are lists of rows in order of loading.
pub fn of_curves(jacobian: &DMatrix<f64>, residual: &DVector<f64>, curves: &[Vec<usize>], rounding: bool) -> Errors {
    let (n, p) = jacobian.shape();
    let directions = directions(jacobian);
    let free = n.saturating_sub(p);
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

/// Model, most likely ρ, covariance of the directions and degrees of freedom; `None` where the errors are not correlated.
fn correlated(
    u: &DMatrix<f64>,
    residual: &DVector<f64>,
    curves: &[Vec<usize>],
    p: usize,
) -> Option<(ErrorModel, f64, DMatrix<f64>, usize)> {
    let z = DMatrix::from_fn(u.nrows(), u.ncols() + 1, |i, k| if k < u.ncols() { u[(i, k)] } else { residual[i] });
    let products = Products::new(&z, curves);
    let n = u.nrows() as f64;
    let left = p as f64 + LEFT;
    let root = |k: f64| (n - left) / (n + left) * (k / f64::from(GRID - 1)).sqrt();
    // ρ, its width on the grid, ℓ, σ²
    let at = |k: u32| {
        let k = f64::from(k);
        let wide = root((k + 0.5).min(f64::from(GRID - 1))) - root((k - 0.5).max(0.0));
        products.likelihood(root(k)).map(|(l, s2)| (root(k), wide, l, s2))
    };
    if n <= left {
        return None;
    }
    let (.., least, _) = at(0)?;
    let grid: Vec<_> = (0..GRID).filter_map(at).collect();
    let (likely, _, most, _) = grid.iter().copied().max_by(|a, b| a.2.total_cmp(&b.2))?;
    if 2.0 * (most - least) < CORRELATED {
        return None;
    }
    let weight = |(_, wide, l, _): &(f64, f64, f64, f64)| (l - most).exp() * wide;
    let sum: f64 = grid.iter().map(weight).sum();
    let (mut covariance, mut mean) = (DMatrix::zeros(u.ncols(), u.ncols()), 0.0);
    let mut effective = 0.0;
    for one @ (rho, .., s2) in &grid {
        let share = weight(one) / sum;
        mean += share * rho;
        effective += share * n * (1.0 - rho) / (1.0 + rho);
        if share > NONE {
            let pairs = spread(u, curves, *rho);
            let whole = residual.norm_squared() / (n - pairs.trace()).max(1.0);
            covariance += pairs * (share * s2.max(whole));
        }
    }
    let free = (effective - p as f64).max(1.0) as usize;
    Some((ErrorModel::Correlated { rho: mean, effective }, likely, covariance, free))
}

/// Rows of a curve without what the row before explains: (xᵢ − ρxᵢ₋₁)/√(1 − ρ²), in order of loading, curve by curve.
pub fn whitened(x: &DVector<f64>, curves: &[Vec<usize>], rho: f64) -> Vec<f64> {
    let one = |curve: &Vec<usize>| {
        let value = |place: usize| match place {
            0 => x[curve[0]],
            k => (x[curve[k]] - rho * x[curve[k - 1]]) / (1.0 - rho * rho).sqrt(),
        };
        (0..curve.len()).map(value).collect::<Vec<f64>>()
    };
    curves.iter().flat_map(one).collect()
}
