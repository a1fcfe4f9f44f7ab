//! The bordered matrix of K + B S Bᵀ ([`Pattern`]), m columns in B:
//!
//! ```text
//! ⎡K   B        0    ⎤   x          w = Bᵀx − D f means, f = S(w + D f) forces on them,
//! ⎢Bᵀ  DSD−2D   DS−1 ⎥   f          D = diag(d) > 0 with d_j (Σ_l |S_jl|) ≤ 1
//! ⎣0   SD−1     S    ⎦   w
//! ```
//!
//! Its Schur complement on x is K + B S Bᵀ, and the block of (f, w) is congruent to \[0 −1; −1 S\], which has m negative eigenvalues. By the inertia
//! formula of Haynsworth (Linear Algebra Appl. 1, 1968), it therefore has m more negative eigenvalues than K + B S Bᵀ, whatever the ranks of B and S:
//! S is not inverted, and a slack cable is not a special case. The unknowns of a column are eliminated where they cause little fill. With D = 0 the
//! pivot of f would be −BᵀK⁻¹B of the unknowns eliminated before, which is zero for a column without rows and for a linearly dependent one in a cell;
//! with 0 < DS < 2 it is negative.
//!
//! Limits: with more columns than a section of the body has nodes, the border causes more fill than it avoids.

use crate::math::low_rank::Pattern;
use crate::math::ordering::minimum_degree;
use crate::math::sparse::SymPattern;
use std::sync::Arc;

/// The bordered matrix: the positions of its entries and their values.
pub(super) struct Border {
    pub pattern: Arc<SymPattern>,
    /// Index of each row of K, of f and of w in the bordered matrix
    x: Vec<u32>,
    pub f: Vec<u32>,
    w: Vec<u32>,
    /// Slot of each entry of K
    sparse: Vec<u32>,
    pub values: Vec<f64>,
}

impl Border {
    /// Builds the border of a pattern; `None` if there is no low-rank part.
    pub fn new(pattern: &Pattern, in_order: bool) -> Option<Self> {
        let (n, columns) = (pattern.n, &pattern.low_rank.columns);
        let inner = pattern.low_rank.inner.as_ref()?;
        let (mut x, mut f, mut w) = (vec![0; n], vec![0; inner.n], vec![0; inner.n]);
        let mut place = 0;
        for vertex in order(pattern, inner, in_order) {
            match vertex.checked_sub(n) {
                None => x[vertex] = place,
                Some(j) => {
                    (f[j], w[j]) = (place, place + 1);
                    place += 1;
                }
            }
            place += 1;
        }
        let of_k = || pattern.sparse.entries().map(|(i, j)| (x[i], x[j]));
        let of_b = (0..inner.n).flat_map(|j| columns[j].iter().map(move |&(i, _)| (i, j)));
        let of_b = of_b.map(|(i, j)| (x[i as usize], f[j]));
        let of_s = inner.entries().flat_map(|(i, j)| [(w[i], w[j]), (f[i], f[j]), (w[i], f[j]), (f[i], w[j])]);
        let bordered = SymPattern::from_pairs(place as usize, of_k().chain(of_b).chain(of_s));
        let slot = |(i, j)| bordered.slot(i, j).expect("the pattern was made of these");
        let sparse = of_k().map(slot).collect();
        let values = vec![0.0; bordered.nnz()];
        Some(Self { pattern: Arc::new(bordered), x, f, w, sparse, values })
    }

    /// Fills the bordered matrix with these values.
    pub fn fill(&mut self, pattern: &Pattern, values: &[f64]) {
        let (k, s) = values.split_at(pattern.sparse.nnz());
        let columns = &pattern.low_rank.columns;
        let inner = pattern.low_rank.inner.as_ref().expect("it has a border");
        let Self { pattern: bordered, values, .. } = self;
        values.fill(0.0);
        self.sparse.iter().zip(k).for_each(|(&slot, k)| values[slot as usize] = *k);
        let mut add = |i: u32, j: u32, value: f64| {
            values[bordered.slot(i, j).expect("the pattern was made of these") as usize] += value;
        };
        let own = |i: u32| k[pattern.on_diagonal(i as usize)].abs();
        // The stiffness along a mean limits how large D may be without hiding the stiffness of the body
        let mut d = inner.multiply_abs(s, &vec![1.0; inner.n]);
        for (d, column) in d.iter_mut().zip(columns) {
            let stiffness = *d + column.iter().map(|&(i, b)| b * b * own(i)).sum::<f64>();
            *d = if stiffness > 0.0 { 1.0 / stiffness } else { 1.0 };
        }
        for (j, column) in columns.iter().enumerate() {
            column.iter().for_each(|&(i, b)| add(self.x[i as usize], self.f[j], b));
            add(self.w[j], self.f[j], -1.0);
            add(self.f[j], self.f[j], -2.0 * d[j]);
        }
        for ((i, j), s) in inner.entries().zip(s) {
            add(self.w[i], self.w[j], *s);
            add(self.f[i], self.f[j], d[i] * s * d[j]);
            add(self.w[i], self.f[j], s * d[j]);
            if i != j {
                add(self.f[i], self.w[j], d[i] * s);
            }
        }
    }

    /// Extends columns of x by zeros for f and w.
    pub fn widen(&self, columns: &[f64]) -> Vec<f64> {
        let (n, size) = (self.x.len(), self.pattern.n);
        let mut wide = vec![0.0; columns.len() / n * size];
        for (wide, column) in wide.chunks_exact_mut(size).zip(columns.chunks_exact(n)) {
            self.x.iter().zip(column).for_each(|(&place, value)| wide[place as usize] = *value);
        }
        wide
    }

    /// Extracts x from extended columns.
    pub fn narrow(&self, wide: &[f64], columns: &mut [f64]) {
        for (wide, column) in wide.chunks_exact(self.pattern.n).zip(columns.chunks_exact_mut(self.x.len())) {
            self.x.iter().zip(column).for_each(|(&place, value)| *value = wide[place as usize]);
        }
    }
}

/// Elimination order of the rows of K, numbered first, and the columns of B: that of the pattern, or a new one.
fn order(pattern: &Pattern, inner: &SymPattern, in_order: bool) -> Vec<usize> {
    let (n, after) = (pattern.n, &pattern.low_rank.after);
    if in_order {
        let mut columns: Vec<usize> = (0..after.len()).collect();
        columns.sort_by_key(|&j| after[j]);
        let mut columns = columns.into_iter().peekable();
        let mut order = Vec::with_capacity(n + after.len());
        for row in 0..=n {
            while let Some(j) = columns.next_if(|&j| after[j] as usize == row) {
                order.push(n + j);
            }
            order.push(row);
        }
        order.pop();
        return order;
    }
    let of_k = pattern.sparse.entries();
    let of_b = pattern.low_rank.columns.iter().enumerate();
    let of_b = of_b.flat_map(|(j, column)| column.iter().map(move |&(i, _)| (i as usize, n + j)));
    let of_s = inner.entries().map(|(i, j)| (n + i, n + j));
    let pairs = of_k.chain(of_b).chain(of_s).map(|(i, j)| (i as u32, j as u32));
    let graph = SymPattern::from_pairs(n + after.len(), pairs);
    minimum_degree(&graph).into_iter().map(|v| v as usize).collect()
}
