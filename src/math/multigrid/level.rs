//! A level of the hierarchy: its matrix, the smoother, and the transfer to the next level.
//!
//! ```text
//! x = G⁻¹ r,  x += P (next level of) Pᵀ(r − A x),  x += G⁻ᵀ(r − A x),  G = the lower triangle of A within each part of the rows
//! ```
//!
//! Block Gauss–Seidel within parts of the rows, which are distributed over threads, and block Jacobi between the parts. For M to be positive
//! definite, G + Gᵀ − A has to be. This matrix consists of the diagonal blocks less the couplings with other parts: where the couplings have the
//! larger sum of magnitudes, the difference is added to the diagonal of G (as in Baker, Falgout, Kolev & Yang, SIAM J. Sci. Comput. 33, 2011). The
//! division into parts depends only on the size of the matrix; small levels have one part.

use super::blocks::{Block, BlockMatrix, add_product, subtract_product};
use crate::math::threads;

/// The matrix has a motion without positive stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotDefinite;

/// A level with blocks of B × B. A and P are in single precision, which halves the memory traffic; the same rounded numbers are used for restriction
/// and prolongation, so that M⁻¹ is symmetric to the rounding of double precision.
pub(super) struct Level<const B: usize> {
    a: BlockMatrix<B, B, f32>,
    /// \[rows\] the amount added to the diagonal of G
    outside: Vec<[f64; B]>,
    /// \[rows\] inverses of the diagonal blocks with the added amount
    inverse: Vec<Block<B, B>>,
    p: BlockMatrix<B, 6, f32>,
    /// The transpose Pᵀ
    restriction: BlockMatrix<6, B, f32>,
}

impl<const B: usize> Level<B> {
    pub fn new(a: BlockMatrix<B, B>, p: BlockMatrix<B, 6>) -> Result<Self, NotDefinite> {
        let p = p.rounded();
        let parts = a.parts();
        let of_part = |rows: std::ops::Range<usize>| -> Vec<[f64; B]> {
            let of_row = |i: usize| {
                let mut sum = [0.0; B];
                for block in a.row(i).filter(|(j, _)| !rows.contains(j)).map(|(_, block)| block) {
                    block.iter().for_each(|column| sum.iter_mut().zip(column).for_each(|(sum, v)| *sum += v.abs()));
                }
                let own = &a.values[a.diagonal(i)];
                std::array::from_fn(|r| {
                    let others: f64 = (0..B).filter(|&c| c != r).map(|c| own[c][r].abs()).sum();
                    (sum[r] - (own[r][r] - others)).max(0.0)
                })
            };
            rows.clone().map(of_row).collect()
        };
        let outside = threads::map(parts, of_part).concat();
        let inverse = inverses(&a, &outside)?;
        Ok(Self { a: a.rounded(), outside, inverse, restriction: p.transposed(), p })
    }

    /// Returns M⁻¹ r of this level, where `next` applies the M⁻¹ of the next level.
    pub fn cycle(&self, r: &[[f64; B]], next: impl FnOnce(&[[f64; 6]]) -> Vec<[f64; 6]>) -> Vec<[f64; B]> {
        let x = self.forwards(r);
        let correction = next(&self.restriction.product(&self.left(&x)));
        let x = self.p.by_rows(|i| {
            let mut x = x[i];
            self.p.row(i).for_each(|(g, p)| add_product(&mut x, p, &correction[g]));
            x
        });
        self.backwards(r, &x)
    }

    /// Returns G⁻¹ r.
    fn forwards(&self, r: &[[f64; B]]) -> Vec<[f64; B]> {
        let sweep = |rows: std::ops::Range<usize>| {
            let mut x = vec![[0.0; B]; rows.len()];
            for i in rows.clone() {
                let mut rest = r[i];
                let before = self.a.row(i).skip_while(|(j, _)| *j < rows.start).take_while(|(j, _)| *j < i);
                before.for_each(|(j, a)| subtract_product(&mut rest, a, &x[j - rows.start]));
                add_product(&mut x[i - rows.start], &self.inverse[i], &rest);
            }
            x
        };
        threads::map(self.a.parts(), sweep).concat()
    }

    /// Returns r − A x for x = G⁻¹ r: within a part G x = r, so that only the entries above the diagonal and those of other parts remain.
    fn left(&self, x: &[[f64; B]]) -> Vec<[f64; B]> {
        let of_part = |rows: std::ops::Range<usize>| {
            let of_row = |i: usize| {
                let mut left: [f64; B] = std::array::from_fn(|c| self.outside[i][c] * x[i][c]);
                let (others, after) = (self.a.range(i), self.a.diagonal(i) + 1);
                let mut subtract =
                    |k: usize| subtract_product(&mut left, &self.a.values[k], &x[self.a.col[k] as usize]);
                others.take_while(|&k| (self.a.col[k] as usize) < rows.start).for_each(&mut subtract);
                (after..self.a.range(i).end).for_each(subtract);
                left
            };
            rows.clone().map(of_row).collect::<Vec<_>>()
        };
        threads::map(self.a.parts(), of_part).concat()
    }

    /// Returns x + G⁻ᵀ(r − A x).
    fn backwards(&self, r: &[[f64; B]], x: &[[f64; B]]) -> Vec<[f64; B]> {
        let sweep = |rows: std::ops::Range<usize>| {
            let mut own = x[rows.clone()].to_vec();
            for i in rows.clone().rev() {
                let mut rest = r[i];
                for (j, a) in self.a.row(i).filter(|(j, _)| *j != i) {
                    let x = if rows.contains(&j) { &own[j - rows.start] } else { &x[j] };
                    subtract_product(&mut rest, a, x);
                }
                rest.iter_mut().zip(&self.outside[i]).zip(&x[i]).for_each(|((rest, out), x)| *rest += out * x);
                own[i - rows.start] = [0.0; B];
                add_product(&mut own[i - rows.start], &self.inverse[i], &rest);
            }
            own
        };
        threads::map(self.a.parts(), sweep).concat()
    }

    /// Number of scalars in A.
    pub fn matrix_entries(&self) -> usize {
        self.a.entries()
    }

    /// Number of stored scalars.
    pub fn entries(&self) -> usize {
        self.a.entries() + 2 * self.p.entries() + B * (B + 1) * self.inverse.len()
    }
}

/// Returns (D + `more`)⁻¹ for the diagonal blocks D.
pub(super) fn inverses<const B: usize>(
    a: &BlockMatrix<B, B>,
    more: &[[f64; B]],
) -> Result<Vec<Block<B, B>>, NotDefinite> {
    let of_row = |i: usize| {
        let mut block = nalgebra::SMatrix::<f64, B, B>::from(a.values[a.diagonal(i)]);
        (0..B).for_each(|c| block[(c, c)] += more[i][c]);
        let inverse = block.cholesky().ok_or(NotDefinite)?.inverse();
        Ok(inverse.into())
    };
    (0..a.rows()).map(of_row).collect()
}
