//! Correlation of neighbouring data points, from the residual of the reported constants.
//!
//! Σ = σ²R between data points of one curve in order of loading, Rᵢⱼ = (1 − w)ρ^|i−j| + w δᵢⱼ ([`Correlation`]): a drift, and independent noise of
//! each reading. A model without the noise would miss the drift: with noise a third as large as the drift the intervals covered 55 %, with noise as
//! large 35 %. With the residual r and an orthonormal basis U of the columns of J
//!
//! ℓ(ρ, w) = −½[ln|R| + ln|UᵀR⁻¹U| + (n − p) ln(rᵀR⁻¹r/f)], f = n − 2p + tr(UᵀRU UᵀR⁻¹U)
//!
//! is the restricted likelihood (Patterson & Thompson, Biometrika 58, 1971, 545–554; by innovations, Kalman, J. Basic Eng. 82, 1960, 35–45), which
//! accounts for the number of constants, so that ρ is not underestimated. It uses the sum of squares of the reported residual, whose expectation is
//! σ²f at this ρ, and not the sum that generalised least squares would leave with separate constants for every ρ: if a column is rougher than the
//! data, as with noisy stretches or volumes, such constants would follow the increments, and the residual of other constants would appear correlated.
//!
//! *Sizes.* The errors of a load cell are often proportional to its force. Along the columns of the Jacobian, which grow with the stress too, a
//! single size would then underestimate the errors: with three modes such intervals covered 75 to 90 % instead of 95 %. The data decide: errors
//! proportional to √|P̂| or |P̂|, with P̂ the stresses of the law and at least 5 % of the largest, compete with errors of one size, or of one size
//! for each curve. To compare them, ℓ includes the term −Σ ln sᵢ − ½ ln|UᵀS⁻²U| of the sizes s, with the directions U of equal weights.
//!
//! The model is accepted if 2Δℓ relative to ρ = 0 exceeds 1.642 at w = 0 (10 %, one-sided: ρ ≥ 0). The covariance is the mean over ρ, w and the sizes
//! with the weight exp ℓ, with a uniform prior in ρ and w: at the most likely ρ alone the intervals are too narrow. Student's t has n_eff − p degrees
//! of freedom, n_eff = n(1 − ρ)/(1 − ρ + 2(1 − w)ρ) independent data points. A correlation that leaves fewer than p + 2 of them is a misfit of the
//! law, which one curve cannot distinguish from noise: ρ is limited there, and σ² is then at least that of the residual itself, rᵀr/(n − tr UᵀRU).
//!
//! Limits: all curves share one ρ, so that intervals are too narrow if the errors of only some curves are correlated (82 to 85 % coverage in place of
//! 95 %, for three modes with ρ = 0.8 in two of them); two data points count as neighbours however far apart their stretches are.

use super::correlation::{Correlation, GroupedColumns};
use super::directions::Directions;
use nalgebra::{DMatrix, DVector};

/// Number of correlations on the grid, ρ_max √(k/45)
const GRID: u32 = 46;
/// Grid of the shares w of the variance that belong to single readings
const WHITE: [f64; 7] = [0.0, 0.1, 0.25, 0.45, 0.65, 0.8, 0.9];
/// Number of independent data points, beyond the number of constants, that the largest correlation leaves
const LEFT: f64 = 2.0;
/// 2Δℓ from which on errors count as correlated: χ² of one degree of freedom, 80 %, for a one-sided test at 10 %
const CORRELATED: f64 = 1.642;
/// Weight of a correlation below which it is left out \[–\]
const NONE: f64 = 1e-5;

/// ℓ and σ² of a correlation, computed from `products` = (ln|R|, ZᵀR⁻¹Z) of the columns Z = (U, r) over `n` data points, and `pairs` = UᵀRU.
fn likelihood(n: usize, (log_errors, whole): (f64, DMatrix<f64>), pairs: &DMatrix<f64>) -> Option<(f64, f64)> {
    let p = pairs.ncols();
    let free = (n - p) as f64;
    let columns = whole.view((0, 0), (p, p)).into_owned();
    let expected = free - p as f64 + (pairs * &columns).trace();
    let factor = columns.cholesky()?;
    let square = Some(whole[(p, p)] / expected).filter(|s| *s > 0.0)?;
    let log_columns: f64 = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    Some((-0.5 * (log_errors + log_columns + free * square.ln()), square))
}

/// Rows divided by the sizes of their errors.
pub struct Scaled {
    /// Orthonormal columns of the directions of these rows
    pub u: DMatrix<f64>,
    /// Least-squares residual of these rows
    pub residual: DVector<f64>,
    /// Directions of equal weights times the sizes; along them the errors of the constants are sums of the errors of these rows
    pub along: DMatrix<f64>,
    /// Term of the sizes s in the restricted likelihood of the rows as measured, −Σ ln sᵢ − ½ ln|UᵀS⁻²U| with U of equal weights
    pub log: f64,
}

impl Scaled {
    /// The rows of a residual whose errors all have one size.
    pub fn equal(directions: &Directions, residual: &DVector<f64>) -> Self {
        let u = &directions.u;
        Self { u: u.clone(), residual: residual.clone(), along: u.clone(), log: 0.0 }
    }
}

/// One correlation of the grid, with one choice of the sizes.
struct At {
    choice: usize,
    correlation: Correlation,
    /// Width of its part of the grid
    wide: f64,
    log: f64,
    s2: f64,
    pairs: DMatrix<f64>,
}

/// A model of correlated errors.
pub struct Correlated {
    /// Correlation of neighbours, averaged over its likelihood
    pub rho: f64,
    /// The most likely correlation
    pub likely: Correlation,
    /// Number of independent data points with the same information about a mean
    pub effective: f64,
    /// Covariance of the directions of equal weights
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom
    pub free: usize,
    /// Weight of each choice of the sizes, from the likelihood
    pub shares: Vec<f64>,
}

/// The correlated errors behind `p` constants, from the rows divided by each choice of the sizes of their errors. `None` if the errors are not
/// correlated.
pub fn correlated(choices: &[Scaled], curves: &[Vec<usize>], p: usize) -> Option<Correlated> {
    let n = choices.first()?.u.nrows() as f64;
    let left = p as f64 + LEFT;
    if n <= left {
        return None;
    }
    let with = |white: usize| (0..choices.len()).flat_map(move |k| on_grid((choices, k), curves, left, white));
    let mut grid: Vec<At> = with(0).collect();
    let most = |all: &mut dyn Iterator<Item = &At>| all.map(|one| one.log).max_by(f64::total_cmp);
    let least = most(&mut grid.iter().filter(|one| one.correlation.is_none()))?;
    if 2.0 * (most(&mut grid.iter())? - least) < CORRELATED {
        return None;
    }
    grid.extend((1..WHITE.len()).flat_map(with));
    let likely = grid.iter().max_by(|a, b| a.log.total_cmp(&b.log))?;
    let weight = |one: &At| (one.log - likely.log).exp() * one.wide;
    let sum: f64 = grid.iter().map(weight).sum();
    let width = choices[0].along.ncols();
    let (mut covariance, mut shares) = (DMatrix::zeros(width, width), vec![0.0; choices.len()]);
    let (mut rho, mut effective) = (0.0, 0.0);
    let along: Vec<GroupedColumns> = choices.iter().map(|choice| GroupedColumns::of(&choice.along)).collect();
    for one in &grid {
        let (share, residual) = (weight(one) / sum, &choices[one.choice].residual);
        shares[one.choice] += share;
        rho += share * one.correlation.of_neighbours();
        effective += share * one.correlation.effective(n);
        if share > NONE {
            let whole = residual.norm_squared() / (n - one.pairs.trace()).max(1.0);
            covariance += one.correlation.spread(&along[one.choice], curves) * (share * one.s2.max(whole));
        }
    }
    let free = (effective - p as f64).max(1.0) as usize;
    Some(Correlated { rho, likely: likely.correlation, effective, covariance, free, shares })
}

/// The correlations of the grid for one choice of the sizes and one share of [`WHITE`]; at the largest one `left` independent data points remain.
fn on_grid((choices, choice): (&[Scaled], usize), curves: &[Vec<usize>], left: f64, white: usize) -> Vec<At> {
    let Scaled { u, residual, log: own, .. } = &choices[choice];
    let z = DMatrix::from_fn(u.nrows(), u.ncols() + 1, |i, k| if k < u.ncols() { u[(i, k)] } else { residual[i] });
    let (u, z) = (GroupedColumns::of(u), GroupedColumns::of(&z));
    let n = residual.len() as f64;
    let last = f64::from(GRID - 1);
    let w = WHITE[white];
    let root = |k: f64| (n - left) / (n - left + 2.0 * left * (1.0 - w)) * (k / last).sqrt();
    let at = |k: u32| {
        let k = f64::from(k);
        let wide = (root((k + 0.5).min(last)) - root((k - 0.5).max(0.0))) * part_of_white(white);
        let correlation = Correlation { rho: root(k), white: w };
        let pairs = correlation.spread(&u, curves);
        let (log, s2) = likelihood(residual.len(), correlation.products(&z, curves), &pairs)?;
        Some(At { choice, correlation, wide, log: log + own, s2, pairs })
    };
    // Without correlation the share of uncorrelated errors does not matter
    (u32::from(white > 0)..GRID).filter_map(at).collect()
}

/// Width of the part of the shares from 0 to 1 that one share of the grid represents.
fn part_of_white(k: usize) -> f64 {
    let middle = |a: usize, b: usize| 0.5 * (WHITE[a] + WHITE[b]);
    let low = if k == 0 { 0.0 } else { middle(k - 1, k) };
    let high = if k + 1 == WHITE.len() { 1.0 } else { middle(k, k + 1) };
    high - low
}
