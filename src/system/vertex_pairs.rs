//! Entries of K by pairs of vertices.
//!
//! A *vertex* is a node with its three unknowns, or an unknown of the second field. In the sums of a group, the entries of two vertices are
//! contiguous, so that a block stores one place for each pair of its vertices; in K they are in consecutive rows of consecutive columns.

use super::{BlockValues, Dofs};

/// Number of entries with column ≤ row of a block of `n` unknowns, or of pairs of `n` vertices.
pub(super) fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Number of entries of the largest pair of vertices.
pub(super) const LARGEST: usize = 9;

/// Position of the entry in row r and column c among the nine entries of two nodes: first the diagonal, then those above it and those below it, so
/// that a transposition swaps the last two groups of three.
const OF_NODES: [[usize; 3]; 3] = [[0, 3, 4], [6, 1, 5], [7, 8, 2]];

/// The entries of K for two vertices.
pub(super) struct Pair {
    /// Slot of the first entry of the first column
    pub slot: u32,
    /// Number of slots from the first column to the second; one less for each further column
    pub stride: u32,
    /// Offset in the sums, which are ordered as in [`OF_NODES`] for two nodes, otherwise by the components of the node
    pub offset: u32,
    pub rows: Components,
    pub columns: Components,
    pub on_diagonal: bool,
}

/// Components of a vertex: their number, and a bit for each free one.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Components {
    pub count: u8,
    free: u8,
}

impl Components {
    /// Components of a free node.
    const ALL: Self = Self { count: 3, free: 0b111 };

    /// Components of the vertex whose unknowns begin with `first`.
    pub fn of(dofs: &Dofs, first: u32) -> Self {
        let count = if first < dofs.displacements { 3 } else { 1 };
        let is_free = |i: &u32| dofs.equation[(first + i) as usize] != Dofs::FIXED;
        Self { count: count as u8, free: (0..count).filter(is_free).fold(0, |free, i| free | 1 << i) }
    }

    /// The free components, ascending.
    pub fn each_free(self) -> impl Iterator<Item = usize> {
        (0..usize::from(self.count)).filter(move |i| self.free >> i & 1 == 1)
    }
}

impl Pair {
    /// Number of entries in the lower triangle of K.
    pub fn count(&self) -> usize {
        let (rows, columns) = (self.rows.free.count_ones() as usize, self.columns.free.count_ones() as usize);
        if self.on_diagonal { triangle(rows) } else { rows * columns }
    }

    /// Adds the sums of the pair to `k`, which begins at slot `first` of K.
    pub fn add(&self, sums: &[f64], first: u32, k: &mut [f64]) {
        let sums = &sums[self.offset as usize..];
        let (slot, stride) = ((self.slot - first) as usize, self.stride as usize);
        if !self.on_diagonal && self.rows == Components::ALL && self.columns == Components::ALL {
            let s = &sums[..9];
            add(&mut k[slot..][..3], [s[0], s[6], s[7]]);
            add(&mut k[slot + stride..][..3], [s[3], s[1], s[8]]);
            add(&mut k[slot + 2 * stride - 1..][..3], [s[4], s[5], s[2]]);
            return;
        }
        let between_nodes = self.rows.count == 3 && self.columns.count == 3;
        for (column, c) in self.columns.each_free().enumerate() {
            let slot = slot + column * stride - column * column.saturating_sub(1) / 2;
            for (row, r) in self.rows.each_free().enumerate() {
                if !self.on_diagonal || r >= c {
                    k[slot + row] += sums[if between_nodes { OF_NODES[r][c] } else { r + c }];
                }
            }
        }
    }
}

/// Positions of the unknowns and entries of one block in the sums of its group.
pub(super) struct Places<'a> {
    pub nodes: usize,
    /// First unknown of each vertex: nodes come first, then unknowns of the second field
    pub vertices: &'a [u32],
    /// Twice the offset of each pair, first the pairs of nodes, then those of further unknowns with the nodes and with each other; odd if the first
    /// of the two vertices is the column in K
    pub pairs: &'a [u32],
}

impl Places<'_> {
    /// Adds a value for each unknown of the block.
    #[inline]
    pub fn add_vector(&self, to: &mut [f64], value: impl Fn(usize) -> f64) {
        let (nodes, others) = self.vertices.split_at(self.nodes);
        for (a, &place) in nodes.iter().enumerate() {
            to[place as usize..][..3].iter_mut().enumerate().for_each(|(i, to)| *to += value(3 * a + i));
        }
        for (i, &place) in (3 * self.nodes..).zip(others) {
            to[place as usize] += value(i);
        }
    }

    /// Adds K_e d_e; the prescribed increment d is zero on the free dofs.
    pub fn add_increment_force(
        &self,
        to: &mut [f64],
        dofs: impl Iterator<Item = u32>,
        values: &BlockValues,
        d: &[f64],
    ) {
        let n = 2 * self.nodes + self.vertices.len();
        for (j, from) in dofs.enumerate().filter(|(_, from)| d[*from as usize] != 0.0) {
            self.add_vector(to, |i| values.k[i.max(j) * n + i.min(j)] * d[from as usize]);
        }
    }

    /// Adds the entries with column ≤ row of a matrix of `n` unknowns; `k` holds them row by row, and `value` converts them to numbers.
    #[inline]
    pub fn add_matrix<T>(&self, to: &mut [f64], n: usize, k: &[T], value: impl Fn(&T) -> f64) {
        let mut pairs = self.pairs.iter();
        for a in 0..self.nodes {
            let row = |i: usize| &k[(3 * a + i) * n..][..3 * a + 3];
            let (x, y, z) = (row(0), row(1), row(2));
            let (x, y, z) = (x.chunks_exact(3), y.chunks_exact(3), z.chunks_exact(3));
            for (((x, y), z), &pair) in x.zip(y).zip(z).zip(&mut pairs) {
                let to = &mut to[pair as usize / 2..][..9];
                let above = 3 + 3 * (pair % 2) as usize;
                add(&mut to[..3], [value(&x[0]), value(&y[1]), value(&z[2])]);
                add(&mut to[above..][..3], [value(&x[1]), value(&x[2]), value(&y[2])]);
                add(&mut to[9 - above..][..3], [value(&y[0]), value(&z[0]), value(&z[1])]);
            }
        }
        for i in 3 * self.nodes..n {
            let (of_nodes, others) = k[i * n..=i * n + i].split_at(3 * self.nodes);
            for (x, &pair) in of_nodes.chunks_exact(3).zip(&mut pairs) {
                add(&mut to[pair as usize / 2..][..3], [value(&x[0]), value(&x[1]), value(&x[2])]);
            }
            for (x, &pair) in others.iter().zip(&mut pairs) {
                to[pair as usize / 2] += value(x);
            }
        }
    }
}

#[inline]
fn add<const N: usize>(to: &mut [f64], values: [f64; N]) {
    for (to, value) in to.iter_mut().zip(values) {
        *to += value;
    }
}
