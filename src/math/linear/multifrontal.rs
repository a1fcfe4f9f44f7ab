//! Elimination of the columns of one supernode: dense work by faer's kernels; large blocks are divided into parts for threads.

use super::elimination_tree::{EliminationTree, Supernode};
use crate::math::threads;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt, llt};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place};
use faer::mat::{Mat, MatMut, MatRef};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Par};
use std::ops::Range;

/// Number of columns of a supernode that are eliminated before the remaining columns are updated.
const PANEL: usize = 512;
/// Number of columns in a part of dense work, and the number of additions and multiplications from which there is more than one part.
const PART: usize = 192;
const WORK: usize = 2_000_000;

/// The form of a factorisation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Llt,
    Ldlt,
}

/// A pivot is zero or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZeroPivot;

/// Message of a supernode to its parent in an elimination (update matrix).
pub(super) struct Update {
    /// \[rows × rows\] lower triangle by columns: the contribution of its subtree to the matrix of the remaining unknowns
    schur: Vec<f64>,
    /// Number of negative pivots in its subtree
    pub negative: usize,
}

/// Eliminates the columns of a supernode, whose entries of A are in `block`; they are overwritten by those of L.
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
    let mut left = MatMut::from_column_major_slice_mut(&mut update.schur, m, m);
    let mut whole = MatMut::from_column_major_slice_mut(block, c + m, c);
    for start in (0..c).step_by(PANEL) {
        let width = PANEL.min(c - start);
        let (_, from_diagonal) = whole.rb_mut().split_at_row_mut(start);
        let (panel, next) = from_diagonal.split_at_col_mut(start).1.split_at_col_mut(width);
        let (own, mut below) = panel.split_at_row_mut(width);
        let scaled = eliminate_panel(own, below.rb_mut(), kind, &mut update.negative)?;
        let scaled = scaled.as_ref().map_or(below.rb(), Mat::as_ref);
        let (in_columns, in_rows) = scaled.split_at_row(c - start - width);
        let (next, below) = (next.split_at_row_mut(width).1, below.rb());
        subtract(next, below, in_columns);
        subtract(left.rb_mut(), below.split_at_row(c - start - width).1, in_rows);
    }
    Ok(update)
}

/// Eliminates columns: their diagonal block and the rows below it are overwritten by those of L. For LDLᵀ, returns the rows below times D.
fn eliminate_panel(
    mut own: MatMut<f64>,
    mut below: MatMut<f64>,
    kind: Kind,
    negative: &mut usize,
) -> Result<Option<Mat<f64>>, ZeroPivot> {
    let width = own.ncols();
    let mut memory = MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    let solve = match kind {
        Kind::Llt => {
            let (regularisation, settings) = Default::default();
            llt::factor::cholesky_in_place(own.rb_mut(), regularisation, Par::Seq, stack, settings)
                .map_err(|_| ZeroPivot)?;
            solve_lower_triangular_in_place
        }
        Kind::Ldlt => {
            let (regularisation, settings) = Default::default();
            ldlt::factor::cholesky_in_place(own.rb_mut(), regularisation, Par::Seq, stack, settings)
                .map_err(|_| ZeroPivot)?;
            solve_unit_lower_triangular_in_place
        }
    };
    let (own, work) = (own.rb(), below.nrows() * width * width);
    let rows = parts(below.rb_mut().transpose_mut(), work);
    threads::map(rows, |(_, rows)| solve(own, rows, Par::Seq));
    if kind == Kind::Llt {
        return Ok(None);
    }
    // This is L D; the products also need L.
    let scaled = below.to_owned();
    for j in 0..width {
        let d = own[(j, j)];
        if !d.is_finite() || d == 0.0 {
            return Err(ZeroPivot);
        }
        *negative += usize::from(d < 0.0);
        below.rb_mut().col_mut(j).iter_mut().for_each(|l| *l /= d);
    }
    Ok(Some(scaled))
}

/// A ← A − B Cᵀ, in each column the rows from the diagonal of A on.
fn subtract(a: MatMut<f64>, b: MatRef<f64>, c: MatRef<f64>) {
    use BlockStructure::{Rectangular, TriangularLower};
    let work = b.nrows() * c.nrows() * c.ncols();
    threads::map(parts(a, work), |(first, columns)| {
        let count = columns.ncols();
        let (on_diagonal, below) = columns.split_at_row_mut(first).1.split_at_row_mut(count);
        let (of_diagonal, of_below) = b.split_at_row(first).1.split_at_row(count);
        let c = c.subrows(first, count).transpose();
        let of = TriangularLower;
        triangular::matmul(on_diagonal, of, Accum::Add, of_diagonal, Rectangular, c, Rectangular, -1.0, Par::Seq);
        matmul(below, Accum::Add, of_below, c, -1.0, Par::Seq);
    });
}

/// Divides columns into parts on which threads work at the same time, each with the index of its first column; there is one part if the `work` is
/// small. The parts do not depend on the number of threads.
fn parts(mut columns: MatMut<f64>, work: usize) -> Vec<(usize, MatMut<f64>)> {
    let width = if work < WORK { columns.ncols().max(1) } else { PART };
    let (mut parts, mut first) = (Vec::new(), 0);
    while columns.ncols() > 0 {
        let count = width.min(columns.ncols());
        let (part, rest) = columns.split_at_col_mut(count);
        parts.push((first, part));
        (columns, first) = (rest, first + count);
    }
    parts
}

/// Adds the message of a child to the block of its parent, which has `c` columns, and to the message of the parent, which has `m` rows.
fn add(child: &Update, places: &[u32], (block, c): (&mut [f64], usize), (schur, m): (&mut [f64], usize)) {
    let (height, runs) = (c + m, runs(places));
    let mut passed = 0;
    for (j, (&column, values)) in places.iter().zip(child.schur.chunks_exact(places.len())).enumerate() {
        let column = column as usize;
        // A column of the block has all rows; a column of the message has only those below the columns
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

/// Runs of consecutive places, whose values are added at once.
fn runs(places: &[u32]) -> Vec<Range<usize>> {
    let mut start = 0;
    let run = |run: &[u32]| {
        let range = start..start + run.len();
        start = range.end;
        range
    };
    places.chunk_by(|a, b| a + 1 == *b).map(run).collect()
}
