//! Elimination of the columns of one supernode: dense work by faer's kernels, on one thread.

use super::elimination_tree::{EliminationTree, Supernode};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt, llt};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place};
use faer::mat::{MatMut, MatRef};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Par};
use std::ops::Range;

/// The form of a factorisation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Llt,
    Ldlt,
}

/// A pivot is zero or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZeroPivot;

/// Message of a supernode to its parent in an elimination.
pub(super) struct Update {
    /// \[rows × rows\] lower triangle by columns: what its subtree adds to the matrix of the unknowns that are left
    schur: Vec<f64>,
    /// Negative pivots of its subtree
    pub negative: usize,
}

/// Eliminates the columns of a supernode, whose entries of A are in `block`; in their place come those of L.
pub(super) fn eliminate(
    tree: &EliminationTree,
    supernode: &Supernode,
    block: &mut [f64],
    children: &[Update],
    kind: Kind,
) -> Result<Update, ZeroPivot> {
    let (c, m) = (supernode.columns.len(), supernode.rows.len());
    let mut update = Update { schur: vec![0.0; m * m], negative: 0 };
    for (&child, of_child) in supernode.children.iter().zip(children) {
        let places = &tree.places[tree.supernodes[child].rows.clone()];
        add(of_child, places, (block, c), (&mut update.schur, m));
        update.negative += of_child.negative;
    }
    let whole = MatMut::from_column_major_slice_mut(block, c + m, c);
    let (mut own, mut below) = whole.split_at_row_mut(c);
    let mut memory = MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(c, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    let left = MatMut::from_column_major_slice_mut(&mut update.schur, m, m);
    match kind {
        Kind::Llt => {
            let (regularisation, settings) = Default::default();
            llt::factor::cholesky_in_place(own.rb_mut(), regularisation, Par::Seq, stack, settings)
                .map_err(|_| ZeroPivot)?;
            solve_lower_triangular_in_place(own.rb(), below.rb_mut().transpose_mut(), Par::Seq);
            subtract(left, below.rb(), below.rb());
        }
        Kind::Ldlt => {
            let (regularisation, settings) = Default::default();
            ldlt::factor::cholesky_in_place(own.rb_mut(), regularisation, Par::Seq, stack, settings)
                .map_err(|_| ZeroPivot)?;
            solve_unit_lower_triangular_in_place(own.rb(), below.rb_mut().transpose_mut(), Par::Seq);
            // Now L D; the product needs L too.
            let scaled = below.to_owned();
            for j in 0..c {
                let d = own[(j, j)];
                if !d.is_finite() || d == 0.0 {
                    return Err(ZeroPivot);
                }
                update.negative += usize::from(d < 0.0);
                below.rb_mut().col_mut(j).iter_mut().for_each(|l| *l /= d);
            }
            subtract(left, below.rb(), scaled.as_ref());
        }
    }
    Ok(update)
}

/// A ← A − B Cᵀ, lower triangle.
fn subtract(a: MatMut<f64>, b: MatRef<f64>, c: MatRef<f64>) {
    use BlockStructure::{Rectangular, TriangularLower};
    triangular::matmul(a, TriangularLower, Accum::Add, b, Rectangular, c.transpose(), Rectangular, -1.0, Par::Seq);
}

/// Adds the message of a child to the block of its parent, `c` columns, and to its message of `m` rows.
fn add(child: &Update, places: &[u32], (block, c): (&mut [f64], usize), (schur, m): (&mut [f64], usize)) {
    let (height, runs) = (c + m, runs(places));
    let mut passed = 0;
    for (j, (&column, values)) in places.iter().zip(child.schur.chunks_exact(places.len())).enumerate() {
        let column = column as usize;
        // A column of the block has all rows, one of the message those below the columns.
        let (to, first) = if column < c {
            (&mut block[column * height..][..height], 0)
        } else {
            (&mut schur[(column - c) * m..][..m], c)
        };
        passed += usize::from(runs[passed].end <= j);
        for run in &runs[passed..] {
            let from = run.start.max(j);
            let to = &mut to[places[from] as usize - first..];
            to.iter_mut().zip(&values[from..run.end]).for_each(|(to, value)| *to += value);
        }
    }
}

/// The places that follow each other without a gap, so that their values are added at once.
fn runs(places: &[u32]) -> Vec<Range<usize>> {
    let mut start = 0;
    let run = |run: &[u32]| {
        let range = start..start + run.len();
        start = range.end;
        range
    };
    places.chunk_by(|a, b| a + 1 == *b).map(run).collect()
}
