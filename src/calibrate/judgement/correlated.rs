//! Correlation of neighbouring data points, from the residual of the reported constants.
//!
//! Σᵢⱼ = σ²ρ^|i−j| between data points of one curve in order of loading, R = Σ/σ². With the residual r and an orthonormal basis U of the columns of J
//!
//! ℓ(ρ) = −½[ln|R| + ln|UᵀR⁻¹U| + (n − p) ln(rᵀR⁻¹r/f)], f = n − 2p + tr(UᵀRU UᵀR⁻¹U)
//!
//! is the restricted likelihood (Patterson & Thompson, Biometrika 58, 1971, 545–554; by the differences of Prais & Winsten, 1954), which counts the constants,
//! so that ρ is not too small by their number. Its sum of squares is that of the reported residual over its expectation σ²f at this ρ, in place of the one that
//! generalised least squares would leave with constants of their own for every ρ: with a column that is rougher than the data, as of stretches or volumes with
//! noise, these would follow the increments and call the residual of other constants correlated.
//!
//! *Sizes.* The errors of a load cell are often in proportion to its force. Along the columns of the Jacobian, which grow with the stress too, errors of one
//! size would then be too small: of three modes such intervals covered 75 to 90 % instead of 95 %. The data decide: rows over √|P̂| and over |P̂|, P̂ the
//! stresses of the law and at least 5 % of the largest, are choices next to those of one size, or of one in each curve. To compare them ℓ has the part
//! −Σ ln sᵢ − ½ ln|UᵀS⁻²U| of the sizes s, with the directions U of equal weights.
//!
//! The model is taken where 2Δℓ over ρ = 0 exceeds 1.642 (10 %, one-sided: ρ ≥ 0). The covariance is the mean over ρ and the sizes with the weight exp ℓ, uniform in ρ before
//! the data: at the most likely ρ alone the intervals are too narrow. Student's t has n_eff − p degrees of freedom, n_eff = n(1 − ρ)/(1 + ρ) independent data
//! points. A correlation that leaves fewer than p + 2 of them is a departure of the law, which one curve cannot tell from noise: ρ ends there, and σ² is then that
//! of the residual itself, rᵀr/(n − tr UᵀRU), where that is the larger one.
//!
//! Limits: one ρ of all curves, so that intervals are too narrow where the errors of some curves alone are correlated (82 to 85 % in place of 95 %, three modes, ρ = 0.8 in two of them); two data points count as neighbours however far apart their stretches are.

use super::directions::Directions;
use nalgebra::{DMatrix, DVector};

/// Correlations of the grid, ρ_max √(k/45)
const GRID: u32 = 46;
/// Independent data points beyond the constants that the largest correlation leaves
const LEFT: f64 = 2.0;
/// 2Δℓ from which on errors count as correlated: χ² of one degree of freedom, 80 %, for a one-sided test at 10 %
const CORRELATED: f64 = 1.642;
/// Weight of a correlation below which it is left out \[–\]
const NONE: f64 = 1e-5;

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

    /// ℓ(ρ) and σ², with `pairs` = UᵀRU.
    fn likelihood(&self, rho: f64, pairs: &DMatrix<f64>) -> Option<(f64, f64)> {
        let p = self.all.ncols() - 1;
        let free = self.n - p as f64;
        let left = 1.0 - rho * rho;
        // (1 − ρ²)zᵀR⁻¹z
        let whole = &self.all + &self.inner * (rho * rho) - &self.next * (2.0 * rho);
        let columns = whole.view((0, 0), (p, p)).into_owned();
        let expected = free - p as f64 + (pairs * &columns).trace() / left;
        let factor = columns.cholesky()?;
        let square = Some(whole[(p, p)] / expected).filter(|s| *s > 0.0)?;
        let log_columns: f64 = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let log_errors = -self.curves * left.ln();
        Some((-0.5 * (log_errors + log_columns + free * square.ln()), square / left))
    }
}

/// Σᵢⱼ uᵢuⱼᵀρ^|i−j| over the pairs of each curve.
fn spread(u: &DMatrix<f64>, curves: &[Vec<usize>], rho: f64) -> DMatrix<f64> {
    // Row j: Σᵢ uᵢρ^(j−i) over the rows before it
    let mut before = DMatrix::<f64>::zeros(u.nrows(), u.ncols());
    for (mut to, from) in before.column_iter_mut().zip(u.column_iter()) {
        for pair in curves.iter().flat_map(|curve| curve.windows(2)) {
            to[pair[1]] = rho * (to[pair[0]] + from[pair[0]]);
        }
    }
    let one_sided = before.tr_mul(u);
    u.tr_mul(u) + one_sided.transpose() + one_sided
}

/// Rows over the sizes of their errors.
pub struct Scaled {
    /// Orthonormal columns of the directions of these rows
    pub u: DMatrix<f64>,
    /// Residual of least squares of these rows
    pub residual: DVector<f64>,
    /// Directions of equal weights times the sizes, along which the errors of the constants are sums of these errors
    pub along: DMatrix<f64>,
    /// Part of the sizes s in the restricted likelihood of the rows as measured, −Σ ln sᵢ − ½ ln|UᵀS⁻²U| with U of equal weights
    pub log: f64,
}

impl Scaled {
    /// The rows of a residual whose errors are all of one size.
    pub fn equal(directions: &Directions, residual: &DVector<f64>) -> Self {
        let u = &directions.u;
        Self { u: u.clone(), residual: residual.clone(), along: u.clone(), log: 0.0 }
    }
}

/// One correlation of the grid, with one choice of the sizes.
struct At {
    choice: usize,
    rho: f64,
    /// Its part of the grid
    wide: f64,
    log: f64,
    s2: f64,
    pairs: DMatrix<f64>,
}

/// Errors that are correlated.
pub struct Correlated {
    /// Correlation of neighbours, the mean over its likelihood, and the most likely one
    pub rho: f64,
    pub likely: f64,
    /// Independent data points with the same information about a mean
    pub effective: f64,
    /// Of the directions of equal weights
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom
    pub free: usize,
    /// Weight of each choice of the sizes, by the likelihood
    pub shares: Vec<f64>,
}

/// The correlated errors behind `p` constants, from the rows over each choice of the sizes of their errors. `None` where the errors are not correlated.
pub fn correlated(choices: &[Scaled], curves: &[Vec<usize>], p: usize) -> Option<Correlated> {
    let n = choices.first()?.u.nrows() as f64;
    let left = p as f64 + LEFT;
    if n <= left {
        return None;
    }
    let grid: Vec<At> = (0..choices.len()).flat_map(|k| on_grid(choices, k, curves, left)).collect();
    let most = |all: &mut dyn Iterator<Item = &At>| all.map(|one| one.log).max_by(f64::total_cmp);
    let least = most(&mut grid.iter().filter(|one| one.rho == 0.0))?;
    let likely = grid.iter().max_by(|a, b| a.log.total_cmp(&b.log))?;
    if 2.0 * (likely.log - least) < CORRELATED {
        return None;
    }
    let weight = |one: &At| (one.log - likely.log).exp() * one.wide;
    let sum: f64 = grid.iter().map(weight).sum();
    let width = choices[0].along.ncols();
    let (mut covariance, mut shares) = (DMatrix::zeros(width, width), vec![0.0; choices.len()]);
    let (mut rho, mut effective) = (0.0, 0.0);
    for one in &grid {
        let (share, Scaled { residual, along, .. }) = (weight(one) / sum, &choices[one.choice]);
        shares[one.choice] += share;
        rho += share * one.rho;
        effective += share * n * (1.0 - one.rho) / (1.0 + one.rho);
        if share > NONE {
            let whole = residual.norm_squared() / (n - one.pairs.trace()).max(1.0);
            covariance += spread(along, curves, one.rho) * (share * one.s2.max(whole));
        }
    }
    let free = (effective - p as f64).max(1.0) as usize;
    Some(Correlated { rho, likely: likely.rho, effective, covariance, free, shares })
}

/// The correlations of the grid with one choice of the sizes; `left` independent data points remain at the largest.
fn on_grid(choices: &[Scaled], choice: usize, curves: &[Vec<usize>], left: f64) -> Vec<At> {
    let Scaled { u, residual, log: own, .. } = &choices[choice];
    let z = DMatrix::from_fn(u.nrows(), u.ncols() + 1, |i, k| if k < u.ncols() { u[(i, k)] } else { residual[i] });
    let products = Products::new(&z, curves);
    let n = u.nrows() as f64;
    let root = |k: f64| (n - left) / (n + left) * (k / f64::from(GRID - 1)).sqrt();
    let at = |k: u32| {
        let k = f64::from(k);
        let wide = root((k + 0.5).min(f64::from(GRID - 1))) - root((k - 0.5).max(0.0));
        let (rho, pairs) = (root(k), spread(u, curves, root(k)));
        let (log, s2) = products.likelihood(rho, &pairs)?;
        Some(At { choice, rho, wide, log: log + own, s2, pairs })
    };
    (0..GRID).filter_map(at).collect()
}

/// R^(−½)x by the symmetric root, curve by curve in order of loading: rows without what their neighbours explain, the same from either end. Rows whose
/// correlations are those of R become independent, of one size.
pub fn whitened(x: &DVector<f64>, curves: &[Vec<usize>], rho: f64) -> Vec<f64> {
    let one = |curve: &Vec<usize>| {
        let own: Vec<f64> = curve.iter().map(|k| x[*k]).collect();
        if rho == 0.0 || own.len() < 2 { own } else { root(&own, rho) }
    };
    curves.iter().flat_map(one).collect()
}

/// Distance of the nodes of the rule along s, whose error is 2 exp(−π²/h), and how far beyond the eigenvalues they go, which leaves out exp(−s).
const NODE: f64 = 0.4;
const BEYOND: f64 = 24.0;

/// R^(−½)x of one curve. With the tridiagonal T = (1 − ρ²)R⁻¹, whose eigenvalues lie between (1 − ρ)² and (1 + ρ)², it is T T^(−½)x/√(1 − ρ²), and
/// T^(−½) = (2/π)∫ eˢ(e²ˢ + T)⁻¹ ds over all s, by the trapezoidal rule (Hale, Higham & Trefethen, SIAM J. Numer. Anal. 46, 2008, 2505–2523).
fn root(x: &[f64], rho: f64) -> Vec<f64> {
    let n = x.len();
    let diagonal = |k: usize| if k == 0 || k + 1 == n { 1.0 } else { 1.0 + rho * rho };
    let (first, last) = ((1.0 - rho).ln() - BEYOND, (1.0 + rho).ln() + BEYOND);
    let (mut sum, mut upper, mut solved) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for node in 0..=((last - first) / NODE).ceil() as usize {
        let e = (first + NODE * node as f64).exp();
        // (e² + T) solved = x by elimination without pivots: it is diagonally dominant
        for k in 0..n {
            let (above, before) = if k == 0 { (0.0, 0.0) } else { (upper[k - 1], solved[k - 1]) };
            let pivot = e * e + diagonal(k) + rho * above;
            upper[k] = -rho / pivot;
            solved[k] = (x[k] + rho * before) / pivot;
        }
        for k in (0..n - 1).rev() {
            solved[k] -= upper[k] * solved[k + 1];
        }
        sum.iter_mut().zip(&solved).for_each(|(sum, y)| *sum += e * y);
    }
    let factor = NODE * std::f64::consts::FRAC_2_PI / (1.0 - rho * rho).sqrt();
    let at = |k: usize| {
        let neighbours = if k > 0 { sum[k - 1] } else { 0.0 } + sum.get(k + 1).copied().unwrap_or(0.0);
        factor * (diagonal(k) * sum[k] - rho * neighbours)
    };
    (0..n).map(at).collect()
}

/// (1 − ρ²)xᵀR⁻¹x, summed over the curves.
pub fn square(x: &DVector<f64>, curves: &[Vec<usize>], rho: f64) -> f64 {
    let one = |curve: &Vec<usize>| {
        let first = curve.first().map_or(0.0, |k| (1.0 - rho * rho) * x[*k].powi(2));
        first + curve.windows(2).map(|w| (x[w[1]] - rho * x[w[0]]).powi(2)).sum::<f64>()
    };
    curves.iter().map(one).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// WᵀW = R⁻¹ for the matrix W of the rows, which is symmetric, and from the other end the rows are the same in the other order.
    #[test]
    fn whitening_is_the_symmetric_root_and_has_no_direction() {
        for (n, rho) in [(2, 0.3), (9, 0.5), (40, 0.95)] {
            let curve = vec![(0..n).collect::<Vec<usize>>()];
            let column = |k: usize| whitened(&DVector::from_fn(n, |i, _| f64::from(u8::from(i == k))), &curve, rho);
            let w = DMatrix::from_fn(n, n, |i, k| column(k)[i]);
            let r = DMatrix::from_fn(n, n, |i, k| rho.powi(i.abs_diff(k) as i32));
            assert!((&w * &r * &w - DMatrix::identity(n, n)).amax() < 1e-8, "{n} {rho}");
            assert!((&w - w.transpose()).amax() < 1e-8, "{n} {rho}");
            let mut random = SplitMix(7);
            let x = DVector::from_fn(n, |_, _| random.unit() - 0.5);
            let back = vec![(0..n).rev().collect::<Vec<usize>>()];
            let (there, here) = (whitened(&x, &curve, rho), whitened(&x, &back, rho));
            assert!(there.iter().zip(here.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-8), "{n} {rho}");
            let sum: f64 = there.iter().map(|w| w * w).sum();
            assert!((square(&x, &curve, rho) / (1.0 - rho * rho) / sum - 1.0).abs() < 1e-8, "{n} {rho}");
        }
    }
}
