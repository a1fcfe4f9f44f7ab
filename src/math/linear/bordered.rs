//! Direct solution with K + B S Bᵀ ([`Pattern`]): the bordered matrix ([`border`](super::border)) is factorised by LDLᵀ without pivoting, like that
//! of a second field; without a low-rank part K itself is factorised.
//!
//! Limits: negative pivots of K alone have no meaning here, so that LLᵀ is not tried with a border.

use super::border::Border;
use super::direct::{Direct, ZeroPivot};
use crate::math::low_rank::Pattern;

/// Factorisation of matrices of one pattern; without a low-rank part, that of [`Direct`].
pub(super) struct Bordered {
    border: Option<Border>,
    /// Factorisation of K, or of the bordered matrix
    direct: Direct,
}

impl Bordered {
    /// Prepares the factorisation of a pattern, with the arguments and the result of [`Direct::new`].
    pub fn new(pattern: &Pattern, in_order: bool) -> Option<Self> {
        let border = Border::new(pattern, in_order);
        let direct = match &border {
            Some(border) => Direct::new(&border.pattern, true),
            None => Direct::new(&pattern.sparse, in_order),
        };
        direct.map(|direct| Self { border, direct })
    }

    /// Number of entries of L.
    pub fn nnz(&self) -> usize {
        self.direct.nnz()
    }

    /// Memory in addition to L while it is computed \[bytes\].
    pub fn work_bytes(&self) -> usize {
        self.direct.work_bytes()
    }

    /// Number of additions and multiplications of one factorisation.
    pub fn flops(&self) -> f64 {
        self.direct.flops()
    }

    /// Factorises by LLᵀ; returns false if a pivot is not positive, and with a border.
    pub fn definite(&mut self, values: &[f64]) -> bool {
        self.border.is_none() && self.direct.definite(values)
    }

    /// Factorises by LDLᵀ; returns the number of negative eigenvalues of K + B S Bᵀ.
    pub fn indefinite(&mut self, pattern: &Pattern, values: &[f64]) -> Result<usize, ZeroPivot> {
        let Some(border) = &mut self.border else { return self.direct.indefinite(values) };
        border.fill(pattern, values);
        let pivots = self.direct.indefinite(&border.values)?;
        Ok(pivots.saturating_sub(border.f.len()))
    }

    /// Solves in place, without a check; `columns` holds consecutive columns.
    pub fn solve(&self, columns: &mut [f64]) {
        widened(self.border.as_ref(), columns, |wide| self.direct.solve(wide));
    }

    /// Solves with L rounded to single precision.
    pub fn solve_roughly(&mut self, columns: &mut [f64]) {
        let Self { border, direct } = self;
        widened(border.as_ref(), columns, |wide| direct.solve_roughly(wide));
    }
}

/// Calls `solve` with the columns extended by the rows of the border, if there is one.
fn widened(border: Option<&Border>, columns: &mut [f64], solve: impl FnOnce(&mut [f64])) {
    let Some(border) = border else { return solve(columns) };
    let mut wide = border.widen(columns);
    solve(&mut wide);
    border.narrow(&wide, columns);
}

#[cfg(test)]
mod tests {
    use crate::math::linear::{Factor, LinearError};
    use crate::math::low_rank::LowRank;
    use crate::math::low_rank::Pattern;
    use crate::math::random::SplitMix;
    use crate::math::sparse::SymPattern;
    use crate::math::statistics::smaller;
    use nalgebra::{DMatrix, DVector};
    use std::sync::Arc;

    const N: usize = 60;

    /// K of bandwidth 4 with eigenvalues above 1, made indefinite by `less` on its diagonal; five columns of B: two of them equal, one
    /// without rows. S of the given rank with eigenvalues of both signs.
    fn sample(random: &mut SplitMix, less: f64, rank: usize) -> (Arc<Pattern>, Vec<f64>) {
        let mut columns: Vec<Vec<(u32, f64)>> =
            [3, 20, 22, 20].map(|first| (first..first + 7).map(|i| (i, random.unit())).collect()).to_vec();
        columns[3] = columns[1].clone();
        columns.push(Vec::new());
        let m = columns.len();
        let inner = SymPattern::from_pairs(m, (0..m as u32).flat_map(|i| (0..i).map(move |j| (i, j))));
        let sparse =
            SymPattern::from_pairs(N, (0..N as u32).flat_map(|i| (i.saturating_sub(4)..i).map(move |j| (i, j))));
        let after = vec![5, 27, 40, 0, N as u32];
        let low_rank = LowRank { columns, inner: Some(inner), after };
        let pattern = Pattern::new(sparse, low_rank);
        let mut values = vec![0.0; pattern.nnz()];
        for (slot, (i, j)) in pattern.sparse.entries().enumerate() {
            values[slot] = if i == j { 9.0 - less } else { 2.0 * random.unit() - 1.0 };
        }
        for r in 0..rank {
            let v: Vec<f64> = (0..m).map(|_| 3.0 * random.unit() - 1.5).collect();
            for (i, j) in (0..m).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let slot = pattern.inner_slot(i as u32, j as u32).expect("all of S") as usize;
                values[slot] += [4.0, -2.0][r % 2] * v[i] * v[j];
            }
        }
        (Arc::new(pattern), values)
    }

    /// K + B S Bᵀ entry by entry.
    fn dense(pattern: &Pattern, values: &[f64]) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(N, N);
        for (slot, (i, j)) in pattern.sparse.entries().enumerate() {
            (a[(i, j)], a[(j, i)]) = (values[slot], values[slot]);
        }
        let columns = &pattern.low_rank.columns;
        for (i, j) in (0..columns.len()).flat_map(|i| (0..columns.len()).map(move |j| (i, j))) {
            let s = values[pattern.inner_slot(i as u32, j as u32).expect("all of S") as usize];
            for &(row, b) in &columns[i] {
                columns[j].iter().for_each(|&(column, c)| a[(row as usize, column as usize)] += b * s * c);
            }
        }
        a
    }

    fn over_samples(check: impl Fn(&str, &Arc<Pattern>, &[f64], &DMatrix<f64>)) {
        let mut random = SplitMix(11);
        for less in [0.0, 6.5, 12.0, 14.0] {
            for rank in [0, 1, 2, 5] {
                let (pattern, values) = sample(&mut random, less, rank);
                check(
                    &format!("diagonal {}, S of rank {rank}", 9.0 - less),
                    &pattern,
                    &values,
                    &dense(&pattern, &values),
                );
            }
        }
    }

    /// Sums of 60 terms of size 10 and their products: rounding 1e-13.
    #[test]
    fn the_operator_is_that_of_the_dense_matrix() {
        over_samples(|name, pattern, values, a| {
            let x = DVector::from_fn(N, |i, _| (i as f64).sin());
            let mut y = vec![0.0; N];
            pattern.multiply(values, x.as_slice(), &mut y);
            assert!((DVector::from_vec(y) - a * &x).amax() < 1e-12, "{name}");
            assert!((DVector::from_vec(pattern.diagonal(values)) - a.diagonal()).amax() < 1e-12, "{name}");
            let bound = DVector::from_vec(pattern.multiply_abs(values, x.as_slice()));
            assert!((a * &x).iter().zip(&bound).all(|(y, bound)| y.abs() <= bound + 1e-12), "{name}");
        });
    }

    /// The factor in the order of the pattern, and in an order of its own.
    fn factors(pattern: &Arc<Pattern>) -> [Factor; 2] {
        let mut other = Factor::new(Pattern::from(SymPattern::from_pairs(pattern.n, std::iter::empty())));
        other.take_pattern(pattern, false);
        [Factor::new(pattern.clone()), other]
    }

    /// Solutions differ by the condition number, below 1e4 here, times the rounding; in single precision by the condition number times 6e-8.
    #[test]
    fn solves_and_counts_as_the_dense_matrix_does() {
        let counts = std::cell::RefCell::new(std::collections::BTreeSet::new());
        over_samples(|name, pattern, values, a| {
            let eigenvalues = a.symmetric_eigenvalues();
            let least = eigenvalues.iter().fold(f64::INFINITY, |m, e| smaller(m, e.abs()));
            assert!(eigenvalues.amax() / least < 1e4, "{name}: a sample that is regular");
            let negative = eigenvalues.iter().filter(|e| **e < 0.0).count();
            counts.borrow_mut().insert(negative);
            let rhs: Vec<f64> = (0..2 * N).map(|i| (i as f64).cos()).collect();
            let wanted = a.clone().lu().solve(&DMatrix::from_column_slice(N, 2, &rhs)).expect("regular");
            let apart = |x: &[f64]| (DMatrix::from_column_slice(N, 2, x) - &wanted).norm() / wanted.norm();
            for mut factor in factors(pattern) {
                factor.factorise(values).expect("regular");
                assert_eq!(factor.negative_eigenvalues, negative, "{name}");
                let (mut x, mut roughly) = (rhs.clone(), rhs.clone());
                factor.solve(values, &mut x).expect("accurate");
                factor.solve_roughly(&mut roughly);
                assert!(apart(&x) < 1e-11 && apart(&roughly) < 1e-3, "{name}: {:e}, {:e}", apart(&x), apart(&roughly));
            }
        });
        assert!(counts.borrow().len() > 4, "definite and indefinite ones: {counts:?}");
    }

    /// A free chain, whose K is singular, and a chain pushed at a node, whose K has a negative eigenvalue, are both held by a spring at a mean:
    /// nothing is unstable. A spring of the other sign makes them unstable.
    #[test]
    fn what_only_the_border_holds_is_stable() {
        let (n, column) = (12_usize, vec![(2, 0.5), (3, 0.5)]);
        for (push, spring, negative) in [(0.0, 1.0, 0), (0.2, 1.0, 0), (0.0, -1.0, 1), (0.2, 0.0, 1)] {
            let low_rank = LowRank {
                columns: vec![column.clone()],
                inner: Some(SymPattern::from_pairs(1, std::iter::empty())),
                after: vec![6],
            };
            let chain = SymPattern::from_pairs(n, (1..n as u32).map(|i| (i, i - 1)));
            let pattern = Arc::new(Pattern::new(chain, low_rank));
            let ends = |i| if i == 0 || i == n - 1 { 1.0 } else { 2.0 };
            let pushed = |i| if i == 2 { push } else { 0.0 };
            let mut values: Vec<f64> =
                pattern.sparse.entries().map(|(i, j)| if i == j { ends(i) - pushed(i) } else { -1.0 }).collect();
            values.push(spring);
            for mut factor in factors(&pattern) {
                factor.factorise(&values).expect("regular");
                assert_eq!(factor.negative_eigenvalues, negative, "push {push}, spring {spring}");
                let x: Vec<f64> = (0..n).map(|i| 1.0 + (i as f64).sin()).collect();
                let mut y = vec![0.0; n];
                pattern.multiply(&values, &x, &mut y);
                factor.solve(&values, &mut y).expect("accurate");
                // Condition number below 1e3
                assert!(y.iter().zip(&x).all(|(y, x)| (y - x).abs() < 1e-11), "push {push}, spring {spring}");
            }
        }
    }

    /// An S different from the factorised one is detected, even if K is the same.
    #[test]
    fn the_residual_is_that_of_the_whole_operator() {
        over_samples(|name, pattern, values, _| {
            let mut factor = Factor::new(pattern.clone());
            factor.factorise(values).expect("regular");
            let mut other = values.to_vec();
            other[pattern.sparse.nnz()] += 100.0;
            let mut x: Vec<f64> = (0..N).map(|i| (i as f64).cos()).collect();
            let error = factor.solve(&other, &mut x);
            assert!(matches!(error, Err(LinearError::Inaccurate { .. })), "{name}: {error:?}");
        });
    }
}
