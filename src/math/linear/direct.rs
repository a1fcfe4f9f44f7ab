//! LLᵀ and LDLᵀ factorisations of sparse matrices of one pattern by the multifrontal method (Duff & Reid, ACM Trans. Math. Softw. 9, 1983; Liu, SIAM
//! Review 34, 1992), on the threads in use, with bit-identical results for any number of them.
//!
//! The symbolic analysis and the dense kernels are those of faer, whose own numeric phase has no parallelism over the
//! [tree](super::elimination_tree). The message of a supernode to its parent is its contribution to the Schur complement on the rows below it (its
//! update matrix).

use super::elimination_tree::{EliminationTree, Supernode};
pub use super::multifrontal::ZeroPivot;
use super::multifrontal::{Kind, eliminate};
use super::substitution::{Number, back, forward};
use crate::math::ordering::{minimum_degree, postorder};
use crate::math::sparse::{SymPattern, accumulate};
use crate::math::threads;
use crate::math::vector::norm;
use std::convert::Infallible;

/// Number of entries of L that one thread rounds at a time.
const PIECE: usize = 1 << 16;
/// Size from which a freed block of memory is returned to the system \[bytes\].
const KEPT: usize = 64 << 20;

/// A sparse direct factorisation. The symbolic work is done once; the memory of L is allocated by the first factorisation and then reused.
pub struct Direct {
    n: usize,
    tree: EliminationTree,
    /// \[unknowns\] in elimination order
    order: Vec<u32>,
    /// \[supernodes + 1\] offsets into `entries`
    offsets: Vec<usize>,
    /// Slot of each entry of A, and its index in the block of its supernode
    entries: Vec<(u32, u32)>,
    l: Vec<f64>,
    /// L in single precision, for [`Direct::solve_roughly`]; valid if `rounded`
    single: Vec<f32>,
    rounded: bool,
    /// The factorisation that `l` holds
    kind: Option<Kind>,
}

impl Direct {
    /// Analyses a pattern. `in_order`: the unknowns are numbered in a fill-reducing elimination order. Returns `None` if L has more entries than 32
    /// bits can count.
    pub fn new(pattern: &SymPattern, in_order: bool) -> Option<Self> {
        let order: Vec<u32> = if in_order { (0..pattern.n as u32).collect() } else { minimum_degree(pattern) };
        let order = postorder(pattern, &order);
        let mut step = vec![0; pattern.n];
        order.iter().enumerate().for_each(|(k, &unknown)| step[unknown as usize] = k as u32);
        let pairs = pattern.entries().map(|(i, j)| (step[i], step[j]));
        let tree = EliminationTree::new(&SymPattern::from_pairs(pattern.n, pairs))?;
        let (offsets, entries) = places(pattern, &step, &tree);
        let (l, single) = (Vec::new(), Vec::new());
        Some(Self { n: pattern.n, tree, order, offsets, entries, l, single, rounded: false, kind: None })
    }

    /// Number of entries of L.
    pub fn nnz(&self) -> usize {
        self.tree.nnz()
    }

    /// Number of additions and multiplications of one factorisation: the sum of the squared column lengths of L.
    pub fn flops(&self) -> f64 {
        self.tree.operations()
    }

    /// Memory in addition to L while it is computed \[bytes\]: the messages on the threads in use, or on two, which a case may get later; and twice
    /// as much for freed memory that cannot be reused, limited to the size from which memory is returned. Measured in total: up to 2.3 times the
    /// messages if L is smaller than that size, and the messages alone if it is larger.
    pub fn work_bytes(&self) -> usize {
        let messages = 8 * self.tree.waiting(threads::count().max(2));
        messages + (2 * messages).min(KEPT)
    }

    /// Factorises by LLᵀ; returns false if a pivot is not positive.
    pub fn definite(&mut self, values: &[f64]) -> bool {
        self.factorise(values, Kind::Llt).is_ok()
    }

    /// Factorises by LDLᵀ without pivoting; returns the number of negative pivots.
    pub fn indefinite(&mut self, values: &[f64]) -> Result<usize, ZeroPivot> {
        self.factorise(values, Kind::Ldlt)
    }

    fn factorise(&mut self, values: &[f64], kind: Kind) -> Result<usize, ZeroPivot> {
        (self.kind, self.rounded) = (None, false);
        let Self { tree, offsets, entries, l, .. } = self;
        if l.is_empty() {
            // Zeroed pages, which the system clears only when threads first write to them
            *l = vec![0.0; tree.nnz()];
        }
        let mut rest = &mut l[..];
        let split = |(s, supernode): (usize, &Supernode)| {
            let (block, after) = std::mem::take(&mut rest).split_at_mut(supernode.values.len());
            rest = after;
            (&entries[offsets[s]..offsets[s + 1]], block)
        };
        let mut data: Vec<_> = tree.supernodes.iter().enumerate().map(split).collect();
        let roots = tree.up(&mut data, &|supernode, (entries, block), children| {
            block.fill(0.0);
            entries.iter().for_each(|&(slot, place)| block[place as usize] += values[slot as usize]);
            eliminate(tree, supernode, block, children, kind)
        })?;
        self.kind = Some(kind);
        Ok(roots.iter().map(|update| update.negative).sum())
    }

    /// Solves in place, without a check; `columns` holds consecutive columns of length n.
    pub fn solve(&self, columns: &mut [f64]) {
        self.substitute(&self.l, columns, |x, _| x, |x, _| x);
    }

    /// Solves with L rounded to single precision, which halves the memory traffic. Columns are scaled to the range of single precision.
    pub fn solve_roughly(&mut self, columns: &mut [f64]) {
        if !std::mem::replace(&mut self.rounded, true) {
            if self.single.is_empty() {
                self.single = vec![0.0; self.l.len()];
            }
            let pieces = self.single.chunks_mut(PIECE).zip(self.l.chunks(PIECE)).collect();
            threads::map(pieces, |(single, l): (&mut [f32], &[f64])| {
                single.iter_mut().zip(l).for_each(|(single, l)| *single = *l as f32);
            });
        }
        let sizes: Vec<f64> = columns.chunks_exact(self.n).map(norm).collect();
        let sizes: Vec<f64> = sizes.into_iter().map(|size| if size > 0.0 { size } else { 1.0 }).collect();
        let round = |x: f64, right: usize| (x / sizes[right]) as f32;
        self.substitute(&self.single, columns, round, |x, right| f64::from(x) * sizes[right]);
    }

    /// Solves with this L in its own precision; `round` converts the entries of a column to it, and `widen` converts them back.
    fn substitute<T: Number>(
        &self,
        l: &[T],
        columns: &mut [f64],
        round: impl Fn(f64, usize) -> T + Sync,
        widen: impl Fn(T, usize) -> f64,
    ) {
        let (tree, k) = (&self.tree, columns.len() / self.n);
        let kind = self.kind.expect("solve is called only after a successful factorisation");
        // The values of all right-hand sides are stored together for each supernode.
        let mut x = vec![T::default(); columns.len()];
        let mut rest = &mut x[..];
        let split = |supernode: &Supernode| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(k * supernode.columns.len());
            rest = after;
            own
        };
        let mut data: Vec<&mut [T]> = tree.supernodes.iter().map(split).collect();
        let right_sides = &*columns;
        let Ok(_) = tree.up(&mut data, &|supernode, own, children| {
            let unknowns = &self.order[supernode.columns.clone()];
            for (right, own) in own.chunks_exact_mut(unknowns.len()).enumerate() {
                let column = &right_sides[right * self.n..][..self.n];
                own.iter_mut().zip(unknowns).for_each(|(x, &unknown)| *x = round(column[unknown as usize], right));
            }
            Ok::<_, Infallible>(forward(tree, supernode, l, (own, k), children, kind))
        });
        let no_rows = vec![Vec::new(); tree.roots.len()];
        tree.down(&mut data, no_rows, &|supernode, own, above, messages| {
            back(tree, supernode, l, (own, k), &above, messages, kind);
        });
        let mut values = x.iter();
        for supernode in &tree.supernodes {
            for (right, column) in columns.chunks_exact_mut(self.n).enumerate() {
                let unknowns = self.order[supernode.columns.clone()].iter();
                unknowns.zip(&mut values).for_each(|(&unknown, x)| column[unknown as usize] = widen(*x, right));
            }
        }
    }
}

/// The entries of A by supernodes: slot, and index in the block; with the offset of each supernode.
fn places(pattern: &SymPattern, step: &[u32], tree: &EliminationTree) -> (Vec<usize>, Vec<(u32, u32)>) {
    let mut owner = vec![0_u32; pattern.n];
    for (s, supernode) in tree.supernodes.iter().enumerate() {
        owner[supernode.columns.clone()].fill(s as u32);
    }
    let place = |(slot, (i, j)): (usize, (usize, usize))| {
        let (row, column) = (step[i].max(step[j]), step[i].min(step[j]));
        let supernode = &tree.supernodes[owner[column as usize] as usize];
        let (columns, rows) = (&supernode.columns, &tree.rows[supernode.rows.clone()]);
        let place = if (row as usize) < columns.end {
            row as usize - columns.start
        } else {
            columns.len() + rows.binary_search(&row).expect("L has the entries of A")
        };
        let height = columns.len() + rows.len();
        let column = column as usize - columns.start;
        (owner[column + columns.start], slot as u32, (column * height + place) as u32)
    };
    let found: Vec<(u32, u32, u32)> = pattern.entries().enumerate().map(place).collect();
    let mut offsets = vec![0; tree.supernodes.len() + 1];
    found.iter().for_each(|&(s, _, _)| offsets[s as usize + 1] += 1);
    accumulate(&mut offsets);
    let (mut next, mut entries) = (offsets.clone(), vec![(0, 0); found.len()]);
    for (s, slot, place) in found {
        entries[next[s as usize]] = (slot, place);
        next[s as usize] += 1;
    }
    (offsets, entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;
    use crate::math::threads::use_threads;

    /// Seven-point Laplacian of n³ vertices with `shift` on the diagonal.
    fn laplacian(n: u32, shift: f64) -> (SymPattern, Vec<f64>) {
        let at = |i: u32, j: u32, k: u32| (i * n + j) * n + k;
        let all = (0..n).flat_map(move |i| (0..n).flat_map(move |j| (0..n).map(move |k| (i, j, k))));
        let pairs = all.flat_map(|(i, j, k)| {
            let ahead = [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)];
            let inside = ahead.into_iter().filter(|&(a, b, c)| a < n && b < n && c < n);
            inside.map(|(a, b, c)| (at(i, j, k), at(a, b, c))).collect::<Vec<_>>()
        });
        let pattern = SymPattern::from_pairs((n * n * n) as usize, pairs);
        let values = pattern.entries().map(|(i, j)| if i == j { 6.0 + shift } else { -1.0 }).collect();
        (pattern, values)
    }

    /// Number of its negative eigenvalues: 6 + shift − 2 Σ cos(k π/(n + 1)).
    fn negative(n: u32, shift: f64) -> usize {
        let cos = |k: u32| 2.0 * (f64::from(k) * std::f64::consts::PI / f64::from(n + 1)).cos();
        let all = (1..=n).flat_map(|i| (1..=n).flat_map(move |j| (1..=n).map(move |k| (i, j, k))));
        all.filter(|&(i, j, k)| 6.0 + shift < cos(i) + cos(j) + cos(k)).count()
    }

    /// The parts of a part are not counted again at each level of the tree. An additional thread holds the messages of one more part.
    #[test]
    fn messages_that_wait_are_counted_for_the_threads_there_are() {
        let (pattern, _) = laplacian(25, 0.0);
        let direct = Direct::new(&pattern, false).expect("few entries");
        assert!(direct.tree.tasks() > 4, "{} tasks", direct.tree.tasks());
        let in_turn = direct.tree.waiting_in_turn();
        let on = [1, 2, 4, 8].map(|threads| direct.tree.waiting(threads));
        assert!((in_turn..=in_turn * 5 / 4).contains(&on[0]), "{in_turn}: {on:?}");
        assert!((on[0]..=on[0] * 3 / 2).contains(&on[1]) && on[1] < on[2] && on[2] <= on[3], "{in_turn}: {on:?}");
    }

    /// Condition number below 1e4: 1e-11 leaves a margin of one digit; in single precision 1e-2.
    #[test]
    fn factors_and_solutions_have_the_same_bits_for_any_number_of_threads() {
        const N: u32 = 15;
        for shift in [0.0, -0.55] {
            let (pattern, values) = laplacian(N, shift);
            let x: Vec<f64> = (0..2 * pattern.n).map(|i| (i as f64).sin()).collect();
            let mut rhs = vec![0.0; x.len()];
            for (b, x) in rhs.chunks_exact_mut(pattern.n).zip(x.chunks_exact(pattern.n)) {
                pattern.multiply(&values, x, b);
            }
            let mut of_one = None;
            for threads in [1, 2, 3, 8] {
                use_threads(threads);
                let mut direct = Direct::new(&pattern, false).expect("few entries");
                assert!(direct.tree.tasks() > 4, "{} tasks", direct.tree.tasks());
                assert_eq!(direct.definite(&values), shift == 0.0);
                if shift != 0.0 {
                    assert_eq!(direct.indefinite(&values), Ok(negative(N, shift)));
                }
                let (mut fine, mut rough) = (rhs.clone(), rhs.clone());
                direct.solve(&mut fine);
                direct.solve_roughly(&mut rough);
                let apart = |y: &[f64]| y.iter().zip(&x).fold(0.0, |m, (y, x)| larger(m, (y - x).abs()));
                assert!(apart(&fine) < 1e-11 && apart(&rough) < 1e-2, "{:e}, {:e}", apart(&fine), apart(&rough));
                let result = (direct.l.clone(), fine, rough);
                assert_eq!(*of_one.get_or_insert_with(|| result.clone()), result, "{threads} threads");
            }
        }
    }

    /// A dense matrix is one supernode: 1 100 columns, three panels in several parts. Diagonal dominance bounds the condition number by 10: 1e-12
    /// leaves a margin of two digits. A diagonal of both signs has as many negative eigenvalues as negative entries (Gershgorin).
    #[test]
    fn a_supernode_of_several_panels_has_the_same_bits_for_any_number_of_threads() {
        const N: u32 = 1100;
        let pattern = SymPattern::from_pairs(N as usize, (0..N).flat_map(|i| (0..i).map(move |j| (i, j))));
        for negative in [0, 7] {
            let diagonal = |i: usize| if i < negative { -1.5 } else { 1.5 };
            let other = |i: usize, j: usize| ((3 * i + 5 * j) as f64).sin() / f64::from(N);
            let values: Vec<f64> =
                pattern.entries().map(|(i, j)| if i == j { diagonal(i) } else { other(i, j) }).collect();
            let x: Vec<f64> = (0..pattern.n).map(|i| (i as f64).cos()).collect();
            let mut rhs = vec![0.0; pattern.n];
            pattern.multiply(&values, &x, &mut rhs);
            let mut of_one = None;
            for threads in [1, 2, 3, 8] {
                use_threads(threads);
                let mut direct = Direct::new(&pattern, true).expect("few entries");
                assert_eq!(direct.tree.supernodes.len(), 1);
                assert_eq!(direct.definite(&values), negative == 0);
                if negative > 0 {
                    assert_eq!(direct.indefinite(&values), Ok(negative));
                }
                let mut solved = rhs.clone();
                direct.solve(&mut solved);
                let apart = solved.iter().zip(&x).fold(0.0, |m, (y, x)| larger(m, (y - x).abs()));
                assert!(apart < 1e-12, "{apart:e}");
                let result = (direct.l.clone(), solved);
                assert_eq!(*of_one.get_or_insert_with(|| result.clone()), result, "{threads} threads");
            }
        }
    }
}
