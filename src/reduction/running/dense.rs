//! Small dense systems, solved repeatedly without allocation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::mat::{MatMut, MatRef};
use faer::perm::PermRef;
use faer::{Conj, Par};

/// LU factors with partial pivoting for systems up to a given size, and their workspace.
pub struct Dense {
    /// \[n × n\] column by column
    matrix: Vec<f64>,
    n: usize,
    forward: Vec<usize>,
    backward: Vec<usize>,
    memory: MemBuffer,
}

impl Dense {
    /// Allocates memory for systems of at most `most` unknowns.
    pub fn new(most: usize) -> Self {
        let of_factor = factor::lu_in_place_scratch::<usize, f64>(most, most, Par::Seq, Default::default());
        let of_solve = solve::solve_in_place_scratch::<usize, f64>(most, 1, Par::Seq);
        Self {
            matrix: vec![0.0; most * most],
            n: 0,
            forward: vec![0; most],
            backward: vec![0; most],
            memory: MemBuffer::new(of_factor.or(of_solve)),
        }
    }

    /// Factorises the matrix of `n` unknowns with these entries (row, column).
    pub fn factorise(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) {
        self.n = n;
        for column in 0..n {
            for row in 0..n {
                self.matrix[column * n + row] = entry(row, column);
            }
        }
        let a = MatMut::from_column_major_slice_mut(&mut self.matrix[..n * n], n, n);
        let (forward, backward) = (&mut self.forward[..n], &mut self.backward[..n]);
        factor::lu_in_place(a, forward, backward, Par::Seq, MemStack::new(&mut self.memory), Default::default());
    }

    /// Solves in place; for a singular matrix the result is not finite.
    pub fn solve(&mut self, b: &mut [f64]) {
        let n = self.n;
        let lu = MatRef::from_column_major_slice(&self.matrix[..n * n], n, n);
        let order = PermRef::new_checked(&self.forward[..n], &self.backward[..n], n);
        let b = MatMut::from_column_major_slice_mut(b, n, 1);
        solve::solve_in_place_with_conj(lu, lu, order, Conj::No, b, Par::Seq, MemStack::new(&mut self.memory));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A saddle-point matrix with a zero on its diagonal, by hand: [2 1; 1 0] x = [5; 2] has x = (2, 1).
    #[test]
    fn a_saddle_point_and_a_smaller_system_after_it() {
        let mut dense = Dense::new(3);
        let saddle = [[2.0, 1.0], [1.0, 0.0]];
        dense.factorise(2, |i, j| saddle[i][j]);
        let mut b = [5.0, 2.0];
        dense.solve(&mut b);
        assert!((b[0] - 2.0).abs() < 1e-15 && (b[1] - 1.0).abs() < 1e-15, "{b:?}");
        dense.factorise(1, |_, _| 0.0);
        let mut b = [1.0];
        dense.solve(&mut b);
        assert!(!b[0].is_finite());
    }
}
