//! Correlations of the data points of a curve in order of loading, and what follows for sums over them.
//!
//! R = (1 − w)R₁ + wI, (R₁)ᵢⱼ = ρ^|i−j|: a drift, whose steps are independent, and independent noise of each reading with the share w of the
//! variance.
//!
//! *Innovations.* With the drift s of variance 1 − w and the noise v, z = s + v, the part of zᵢ that the previous data points do not explain is eᵢ =
//! zᵢ − aᵢ with the variance Fᵢ = Pᵢ + w; aᵢ₊₁ = ρ(aᵢ + eᵢPᵢ/Fᵢ), Pᵢ₊₁ = ρ²wPᵢ/Fᵢ + (1 − w)(1 − ρ²) from P₁ = 1 − w (Kalman, J. Basic Eng. 82, 1960,
//! 35–45): zᵀR⁻¹z = Σeᵢ²/Fᵢ and |R| = ΠFᵢ.
//!
//! *Roots.* With the tridiagonal T = (1 − ρ²)R₁⁻¹, whose eigenvalues lie between (1 − ρ)² and (1 + ρ)², R⁻¹ = T S⁻¹ with S = (1 − w)(1 − ρ²)I + wT,
//! so that R^(−½)x = T T^(−½)S^(−½)x.

use nalgebra::{DMatrix, DVector};

/// Correlation between the data points of a curve; by default they are independent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correlation {
    /// Correlation of the drift between neighbours \[–\]
    pub rho: f64,
    /// Share of the variance that is independent noise of each reading \[–\]
    pub white: f64,
}

impl Correlation {
    /// Whether data points are independent.
    pub fn is_none(self) -> bool {
        self.rho == 0.0
    }

    /// Correlation of neighbours.
    pub fn of_neighbours(self) -> f64 {
        (1.0 - self.white) * self.rho
    }

    /// Number of independent data points with the same information about a mean as `n` of these.
    pub fn effective(self, n: f64) -> f64 {
        n * (1.0 - self.rho) / (1.0 - self.rho + 2.0 * self.of_neighbours())
    }

    /// ln|R| and the products ZᵀR⁻¹Z of the columns Z, summed over all curves.
    pub fn products(self, z: &GroupedColumns, curves: &[Vec<usize>]) -> (f64, DMatrix<f64>) {
        let Self { rho, white } = self;
        let (mut log, mut sums) = (0.0, Sums::new(z.width));
        let (mut rest, mut expected) = (vec![[0.0; GROUP]; z.groups()], vec![[0.0; GROUP]; z.groups()]);
        for curve in curves {
            expected.fill([0.0; GROUP]);
            let (mut drift, mut determinant) = (1.0 - white, 1.0);
            for k in curve {
                let variance = drift + white;
                let (weight, gain) = (1.0 / variance, drift / variance);
                for ((rest, expected), z) in rest.iter_mut().zip(&mut expected).zip(z.row(*k)) {
                    for i in 0..GROUP {
                        rest[i] = z[i] - expected[i];
                        expected[i] = rho * (expected[i] + rest[i] * gain);
                    }
                }
                sums.add(weight, &rest, &rest);
                determinant *= variance;
                if determinant < SMALL {
                    log += f64::ln(std::mem::replace(&mut determinant, 1.0));
                }
                drift = rho * rho * white * gain + (1.0 - white) * (1.0 - rho * rho);
            }
            log += determinant.ln();
        }
        (log, sums.matrix())
    }

    /// ZᵀRZ = Σᵢⱼ zᵢzⱼᵀRᵢⱼ over the pairs of each curve.
    pub fn spread(self, z: &GroupedColumns, curves: &[Vec<usize>]) -> DMatrix<f64> {
        let mut sums = Sums::new(z.width);
        // zⱼ + 2(1 − w)Σᵢ zᵢρ^(j−i) over the rows i before j: each pair is counted twice here, and the symmetric part is taken at the end
        let (mut before, mut both) = (vec![[0.0; GROUP]; z.groups()], vec![[0.0; GROUP]; z.groups()]);
        for curve in curves {
            before.fill([0.0; GROUP]);
            for k in curve {
                for ((before, both), z) in before.iter_mut().zip(&mut both).zip(z.row(*k)) {
                    for i in 0..GROUP {
                        both[i] = z[i] + 2.0 * (1.0 - self.white) * before[i];
                        before[i] = self.rho * (before[i] + z[i]);
                    }
                }
                sums.add(1.0, &both, z.row(*k));
            }
        }
        let one_sided = sums.matrix();
        (&one_sided + one_sided.transpose()) * 0.5
    }

    /// R^(−½)x by the symmetric root, curve by curve in order of loading: the rows without the part that their neighbours explain, independent of the
    /// direction of the order. Rows whose correlations are R become independent and of one size.
    pub fn whitened(self, x: &DVector<f64>, curves: &[Vec<usize>]) -> Vec<f64> {
        let one = |curve: &Vec<usize>| {
            let own: Vec<f64> = curve.iter().map(|k| x[*k]).collect();
            if self.is_none() || own.len() < 2 { own } else { self.root(&own) }
        };
        curves.iter().flat_map(one).collect()
    }

    /// R^(−½)x of one curve.
    fn root(self, x: &[f64]) -> Vec<f64> {
        let Self { rho, white } = self;
        let of_drift = (1.0 - white) * (1.0 - rho * rho);
        let [low, high] = [(1.0 - rho).powi(2), (1.0 + rho).powi(2)];
        let x: Vec<f64> = match white > 0.0 {
            true => {
                let s = Tridiagonal { scale: white, add: of_drift, rho, n: x.len() };
                s.inverse_root(x, [of_drift + white * low, of_drift + white * high])
            }
            false => x.iter().map(|x| x / of_drift.sqrt()).collect(),
        };
        let t = Tridiagonal { scale: 1.0, add: 0.0, rho, n: x.len() };
        t.times(&t.inverse_root(&x, [low, high]))
    }
}

/// Product of variances below which its logarithm is taken.
const SMALL: f64 = 1e-200;

/// Number of columns that are processed together.
const GROUP: usize = 4;

/// Columns over data points, stored data point by data point; the last group is padded with zeros.
pub struct GroupedColumns {
    width: usize,
    values: Vec<[f64; GROUP]>,
}

impl GroupedColumns {
    pub fn of(columns: &DMatrix<f64>) -> Self {
        let width = columns.ncols();
        let value = |k: usize, c: usize| if c < width { columns[(k, c)] } else { 0.0 };
        let row = |k: usize| (0..width.div_ceil(GROUP)).map(move |g| std::array::from_fn(|i| value(k, GROUP * g + i)));
        Self { width, values: (0..columns.nrows()).flat_map(row).collect() }
    }

    fn groups(&self) -> usize {
        self.width.div_ceil(GROUP)
    }

    fn row(&self, k: usize) -> &[[f64; GROUP]] {
        &self.values[k * self.groups()..][..self.groups()]
    }
}

/// Sum of dyads.
struct Sums {
    width: usize,
    values: Vec<[f64; GROUP]>,
}

impl Sums {
    fn new(width: usize) -> Self {
        Self { width, values: vec![[0.0; GROUP]; width * width.div_ceil(GROUP)] }
    }

    fn add(&mut self, weight: f64, a: &[[f64; GROUP]], b: &[[f64; GROUP]]) {
        for (sums, a) in self.values.chunks_exact_mut(b.len().max(1)).zip(a.as_flattened()) {
            let a = weight * a;
            for (sum, b) in sums.iter_mut().zip(b) {
                (0..GROUP).for_each(|i| sum[i] += a * b[i]);
            }
        }
    }

    fn matrix(&self) -> DMatrix<f64> {
        let groups = self.width.div_ceil(GROUP);
        DMatrix::from_fn(self.width, self.width, |i, j| self.values[i * groups + j / GROUP][j % GROUP])
    }
}

/// The matrix `scale` T + `add` I.
struct Tridiagonal {
    scale: f64,
    add: f64,
    rho: f64,
    n: usize,
}

/// Spacing of the nodes of the quadrature rule in s, whose error is 2 exp(−π²/h), and their extent beyond the eigenvalues, which neglects exp(−s).
const NODE: f64 = 0.4;
const BEYOND: f64 = 24.0;

impl Tridiagonal {
    fn diagonal(&self, k: usize) -> f64 {
        let own = if k == 0 || k + 1 == self.n { 1.0 } else { 1.0 + self.rho * self.rho };
        self.add + self.scale * own
    }

    fn off_diagonal(&self) -> f64 {
        -self.scale * self.rho
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        let at = |k: usize| {
            let neighbours = if k > 0 { x[k - 1] } else { 0.0 } + x.get(k + 1).copied().unwrap_or(0.0);
            self.diagonal(k) * x[k] + self.off_diagonal() * neighbours
        };
        (0..self.n).map(at).collect()
    }

    /// A^(−½)x = (2/π)∫ eˢ(e²ˢ + A)⁻¹x ds over all s, by the trapezoidal rule (Hale, Higham & Trefethen, SIAM J. Numer. Anal. 46, 2008, 2505–2523);
    /// `[least, most]` are bounds of the eigenvalues.
    fn inverse_root(&self, x: &[f64], [least, most]: [f64; 2]) -> Vec<f64> {
        let n = self.n;
        let (first, last) = (0.5 * least.ln() - BEYOND, 0.5 * most.ln() + BEYOND);
        let (mut sum, mut upper, mut solved) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for node in 0..=((last - first) / NODE).ceil() as usize {
            let e = (first + NODE * node as f64).exp();
            // (e² + A) solved = x by elimination without pivoting, because the matrix is diagonally dominant
            for k in 0..n {
                let (above, before) = if k == 0 { (0.0, 0.0) } else { (upper[k - 1], solved[k - 1]) };
                let pivot = e * e + self.diagonal(k) - self.off_diagonal() * above;
                upper[k] = self.off_diagonal() / pivot;
                solved[k] = (x[k] - self.off_diagonal() * before) / pivot;
            }
            for k in (0..n - 1).rev() {
                solved[k] -= upper[k] * solved[k + 1];
            }
            sum.iter_mut().zip(&solved).for_each(|(sum, y)| *sum += e * y);
        }
        sum.iter().map(|s| NODE * std::f64::consts::FRAC_2_PI * s).collect()
    }
}

/// (1 − ρ²)xᵀR₁⁻¹x, summed over the curves.
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

    fn dense(n: usize, Correlation { rho, white }: Correlation) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, k| {
            (1.0 - white) * rho.powi(i.abs_diff(k) as i32) + white * f64::from(u8::from(i == k))
        })
    }

    /// WᵀW = R⁻¹ for the symmetric matrix W of the rows; with the order of the data points reversed, the rows are the same in reverse order.
    #[test]
    fn whitening_is_the_symmetric_root_and_has_no_direction() {
        for (n, rho, white) in [(2, 0.3, 0.0), (9, 0.5, 0.0), (40, 0.95, 0.0), (2, 0.5, 0.4), (40, 0.98, 0.2)] {
            let correlation = Correlation { rho, white };
            let curve = vec![(0..n).collect::<Vec<usize>>()];
            let unit = |k: usize| DVector::from_fn(n, |i, _| f64::from(u8::from(i == k)));
            let column = |k: usize| correlation.whitened(&unit(k), &curve);
            let w = DMatrix::from_fn(n, n, |i, k| column(k)[i]);
            let r = dense(n, correlation);
            assert!((&w * &r * &w - DMatrix::identity(n, n)).amax() < 1e-8, "{n} {correlation:?}");
            assert!((&w - w.transpose()).amax() < 1e-8, "{n} {correlation:?}");
            let mut random = SplitMix(7);
            let x = DVector::from_fn(n, |_, _| random.unit() - 0.5);
            let back = vec![(0..n).rev().collect::<Vec<usize>>()];
            let (there, here) = (correlation.whitened(&x, &curve), correlation.whitened(&x, &back));
            assert!(there.iter().zip(here.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-8), "{n} {correlation:?}");
            if white == 0.0 {
                let sum: f64 = there.iter().map(|w| w * w).sum();
                assert!((square(&x, &curve, rho) / (1.0 - rho * rho) / sum - 1.0).abs() < 1e-8, "{n} {rho}");
            }
        }
    }

    /// Compares innovations and sums over pairs with the dense matrix of two curves.
    #[test]
    fn sums_over_pairs_are_those_of_the_dense_matrix() {
        let curves = [(0..7).collect::<Vec<usize>>(), (7..12).collect()];
        for correlation in [Correlation { rho: 0.9, white: 0.0 }, Correlation { rho: 0.97, white: 0.35 }] {
            let mut r = DMatrix::zeros(12, 12);
            r.view_mut((0, 0), (7, 7)).copy_from(&dense(7, correlation));
            r.view_mut((7, 7), (5, 5)).copy_from(&dense(5, correlation));
            let mut random = SplitMix(3);
            let z = DMatrix::from_fn(12, 3, |_, _| random.unit() - 0.5);
            let rows = GroupedColumns::of(&z);
            let (log, sum) = correlation.products(&rows, &curves);
            let inverse = r.clone().try_inverse().expect("a correlation");
            assert!((&sum - z.transpose() * inverse * &z).amax() < 1e-10 * sum.amax(), "{correlation:?}");
            assert!((log - r.determinant().ln()).abs() < 1e-10, "{correlation:?}");
            let spread = correlation.spread(&rows, &curves);
            assert!((&spread - z.transpose() * &r * &z).amax() < 1e-12 * spread.amax(), "{correlation:?}");
        }
    }

    /// A determinant that underflows, (1 − ρ²)^(n−1) without noise, and products of no columns, as when no constant changes anything.
    #[test]
    fn a_determinant_below_all_numbers_has_a_logarithm() {
        let (rows, curves) = (GroupedColumns::of(&DMatrix::zeros(1000, 0)), [(0..1000).collect::<Vec<usize>>()]);
        let correlation = Correlation { rho: 0.9, white: 0.0 };
        let (log, sum) = correlation.products(&rows, &curves);
        assert!((log / (999.0 * 0.19_f64.ln()) - 1.0).abs() < 1e-12, "{log}");
        assert_eq!((sum.len(), correlation.spread(&rows, &curves).len()), (0, 0));
    }
}
