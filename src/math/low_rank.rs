//! Symmetric matrices K + B S Bᵀ: K sparse, S small, and B with few columns of few entries (weighted means of unknowns). Written out, B S Bᵀ would be
//! dense over all rows in which a pair of coupled columns has entries.

use super::parts::Parts;
use super::sparse::SymPattern;
use std::sync::Arc;

/// The low-rank part B S Bᵀ: B, the pattern of S, and their position in the elimination order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LowRank {
    /// Per column of B: (row, entry), rows ascending
    pub columns: Vec<Vec<(u32, f64)>>,
    /// \[columns × columns\] pattern of S
    pub inner: Option<SymPattern>,
    /// Per column: number of rows of K that are eliminated before it
    pub after: Vec<u32>,
}

impl LowRank {
    fn nnz(&self) -> usize {
        self.inner.as_ref().map_or(0, SymPattern::nnz)
    }

    /// y += B S Bᵀ x, with `entry` applied to the entries of B
    fn add_product(&self, s: &[f64], x: &[f64], y: &mut [f64], entry: impl Fn(f64) -> f64) {
        let Some(inner) = &self.inner else { return };
        let mean = |column: &Vec<(u32, f64)>| column.iter().map(|&(i, b)| entry(b) * x[i as usize]).sum();
        let means: Vec<f64> = self.columns.iter().map(mean).collect();
        let mut forces = vec![0.0; means.len()];
        inner.multiply(s, &means, &mut forces);
        for (column, force) in self.columns.iter().zip(&forces) {
            column.iter().for_each(|&(i, b)| y[i as usize] += entry(b) * force);
        }
    }
}

/// Pattern of K + B S Bᵀ. The values are those of K, followed by those of S.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// Rows of K
    pub n: usize,
    pub sparse: Arc<SymPattern>,
    pub low_rank: Arc<LowRank>,
    /// Parts of the columns of K for products on several threads
    parts: Arc<Parts>,
}

impl From<SymPattern> for Pattern {
    fn from(sparse: SymPattern) -> Self {
        Self { n: sparse.n, parts: Parts::new(&sparse).into(), sparse: Arc::new(sparse), low_rank: Arc::default() }
    }
}

impl From<SymPattern> for Arc<Pattern> {
    fn from(sparse: SymPattern) -> Self {
        Self::new(sparse.into())
    }
}

impl Pattern {
    pub fn new(sparse: SymPattern, low_rank: LowRank) -> Self {
        Self { low_rank: Arc::new(low_rank), ..sparse.into() }
    }

    /// Returns the pattern with additional pairs in K, given in any order and possibly repeated.
    pub fn with_pairs(&self, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        Self { low_rank: self.low_rank.clone(), ..self.sparse.with_pairs(pairs).into() }
    }

    /// Index of each value in a wider pattern that contains this one.
    pub fn slots_in(&self, wider: &Self) -> Vec<u32> {
        let (from, to) = (self.sparse.nnz(), wider.sparse.nnz() as u32);
        self.sparse.slots_in(&wider.sparse).into_iter().chain((0..(self.nnz() - from) as u32).map(|s| to + s)).collect()
    }

    /// Number of values.
    pub fn nnz(&self) -> usize {
        self.sparse.nnz() + self.low_rank.nnz()
    }

    /// Index of entry (i, j) or (j, i) of K in the values.
    pub fn slot(&self, i: u32, j: u32) -> Option<u32> {
        self.sparse.slot(i, j)
    }

    /// Index of entry (i, j) or (j, i) of S in the values.
    pub fn inner_slot(&self, i: u32, j: u32) -> Option<u32> {
        let slot = self.low_rank.inner.as_ref().and_then(|inner| inner.slot(i, j));
        slot.map(|slot| self.sparse.nnz() as u32 + slot)
    }

    /// Index of the diagonal entry of K in row j.
    pub fn on_diagonal(&self, j: usize) -> usize {
        self.sparse.col_ptr[j] as usize
    }

    /// y ← (K + B S Bᵀ) x
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        let (k, s) = values.split_at(self.sparse.nnz());
        self.parts.multiply(&self.sparse, k, x, y);
        self.low_rank.add_product(s, x, y, |b| b);
    }

    /// Returns (|K| + |B||S||Bᵀ|) |x| with entrywise absolute values: the scale of the rounding errors of a product.
    pub fn multiply_abs(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let (k, s) = values.split_at(self.sparse.nnz());
        let mut y = self.sparse.multiply_abs(k, x);
        let absolute = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| v.abs()).collect() };
        self.low_rank.add_product(&absolute(s), &absolute(x), &mut y, f64::abs);
        y
    }

    /// Diagonal of K + B S Bᵀ.
    pub fn diagonal(&self, values: &[f64]) -> Vec<f64> {
        let (k, s) = values.split_at(self.sparse.nnz());
        let mut diagonal = self.sparse.diagonal(k);
        let Some(inner) = &self.low_rank.inner else { return diagonal };
        let columns = &self.low_rank.columns;
        for ((i, j), s) in inner.entries().zip(s) {
            let twice = if i == j { *s } else { 2.0 * s };
            let mut others = columns[j].iter().peekable();
            for &(row, b) in &columns[i] {
                while others.next_if(|other| other.0 < row).is_some() {}
                if let Some((_, c)) = others.next_if(|other| other.0 == row) {
                    diagonal[row as usize] += b * twice * c;
                }
            }
        }
        diagonal
    }
}
