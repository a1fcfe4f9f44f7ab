//! Symmetric sparse matrices: the pattern is built once, only the values change.

use std::ops::{AddAssign, Range};

/// Lower triangle of a symmetric n × n pattern in compressed columns; rows ascend, and the diagonal is always present.
#[derive(Clone, Debug, PartialEq)]
pub struct SymPattern {
    pub n: usize,
    /// \[n + 1\] start of each column in `row_idx`
    pub col_ptr: Vec<u32>,
    /// \[nnz\] row of each stored entry
    pub row_idx: Vec<u32>,
}

impl SymPattern {
    /// Builds the pattern of (row, column) pairs, given in any order and possibly repeated; the diagonal is added.
    pub fn from_pairs(n: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        Self::from_list(n, &pairs.map(|(i, j)| [i.min(j), i.max(j)]).collect::<Vec<_>>())
    }

    /// Builds the pattern from [column, row] in any order and possibly repeated, in linear time: a bucket sort by rows, then by columns, which keeps
    /// the order of the rows.
    fn from_list(n: usize, pairs: &[[u32; 2]]) -> Self {
        let mut row_ptr = vec![0u32; n + 1];
        pairs.iter().for_each(|[_, i]| row_ptr[*i as usize + 1] += 1);
        accumulate(&mut row_ptr);
        let (mut next, mut columns) = (row_ptr.clone(), vec![0u32; pairs.len()]);
        for [j, i] in pairs {
            columns[next[*i as usize] as usize] = *j;
            next[*i as usize] += 1;
        }
        // The last row that each column was seen in
        let mut seen: Vec<u32> = (0..n as u32).collect();
        let mut col_ptr = vec![1u32; n + 1];
        col_ptr[0] = 0;
        let in_row = |i: u32| row_ptr[i as usize] as usize..row_ptr[i as usize + 1] as usize;
        for i in 0..n as u32 {
            for &j in &columns[in_row(i)] {
                col_ptr[j as usize + 1] += u32::from(std::mem::replace(&mut seen[j as usize], i) != i);
            }
        }
        accumulate(&mut col_ptr);
        let (mut next, mut row_idx) = (col_ptr.clone(), vec![0u32; col_ptr[n] as usize]);
        let mut push = |j: u32, i: u32| {
            row_idx[next[j as usize] as usize] = i;
            next[j as usize] += 1;
        };
        (0..n as u32).for_each(|i| seen[i as usize] = i);
        for i in 0..n as u32 {
            push(i, i);
            for &j in &columns[in_row(i)] {
                if std::mem::replace(&mut seen[j as usize], i) != i {
                    push(j, i);
                }
            }
        }
        Self { n, col_ptr, row_idx }
    }

    /// Returns the pattern with additional pairs, given in any order and possibly repeated.
    pub fn with_pairs(&self, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let known = (0..self.n as u32).flat_map(|j| {
            let column = self.col_ptr[j as usize] as usize..self.col_ptr[j as usize + 1] as usize;
            self.row_idx[column].iter().map(move |&i| (i, j))
        });
        Self::from_pairs(self.n, known.chain(pairs))
    }

    /// Index of each entry in a wider pattern that contains all of them.
    pub fn slots_in(&self, wider: &Self) -> Vec<u32> {
        let mut out = Vec::with_capacity(self.nnz());
        for j in 0..self.n {
            let mut slot = wider.col_ptr[j];
            for &i in &self.row_idx[self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize] {
                while wider.row_idx[slot as usize] < i {
                    slot += 1;
                }
                out.push(slot);
            }
        }
        out
    }

    /// Indices (i, j) of the stored entries, in the order of the values.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let column = |j: usize| self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize;
        (0..self.n).flat_map(move |j| self.row_idx[column(j)].iter().map(move |&i| (i as usize, j)))
    }

    /// Number of stored entries (lower triangle with diagonal).
    pub fn nnz(&self) -> usize {
        self.row_idx.len()
    }

    /// The upper triangle in compressed columns: column pointers and rows.
    pub fn upper(&self) -> (Vec<u32>, Vec<u32>) {
        let mut col_ptr = vec![0u32; self.n + 1];
        for &i in &self.row_idx {
            col_ptr[i as usize + 1] += 1;
        }
        accumulate(&mut col_ptr);
        let (mut next, mut rows) = (col_ptr.clone(), vec![0u32; self.nnz()]);
        for j in 0..self.n {
            for &i in &self.row_idx[self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize] {
                rows[next[i as usize] as usize] = j as u32;
                next[i as usize] += 1;
            }
        }
        (col_ptr, rows)
    }

    /// Index of entry (i, j) or (j, i) in the values.
    pub fn slot(&self, i: u32, j: u32) -> Option<u32> {
        let (column, row) = (i.min(j) as usize, i.max(j));
        let (start, end) = (self.col_ptr[column], self.col_ptr[column + 1]);
        let rows = &self.row_idx[start as usize..end as usize];
        rows.binary_search(&row).ok().map(|k| start + k as u32)
    }

    /// y ← A x
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.add_columns(0..self.n, values, x, |i, v| y[i] += v);
    }

    /// Calls `add(i, v)` for every contribution of the stored entries of these columns to y_i of y = A x.
    pub fn add_columns(&self, columns: Range<usize>, values: &[f64], x: &[f64], mut add: impl FnMut(usize, f64)) {
        for j in columns {
            let mut sum = 0.0;
            let column = self.col_ptr[j] as usize..self.col_ptr[j + 1] as usize;
            for (&i, value) in self.row_idx[column.clone()].iter().zip(&values[column]) {
                let i = i as usize;
                add(i, value * x[j]);
                if i != j {
                    sum += value * x[i];
                }
            }
            add(j, sum);
        }
    }

    /// Returns |A| |x| with entrywise absolute values: the scale of the rounding errors of A x.
    pub fn multiply_abs(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let values: Vec<f64> = values.iter().map(|v| v.abs()).collect();
        let x: Vec<f64> = x.iter().map(|v| v.abs()).collect();
        let mut y = vec![0.0; self.n];
        self.multiply(&values, &x, &mut y);
        y
    }

    /// Diagonal of A.
    pub fn diagonal(&self, values: &[f64]) -> Vec<f64> {
        (0..self.n).map(|j| values[self.col_ptr[j] as usize]).collect()
    }
}

/// Turns counts into offsets in place: entry \[i + 1\] holds the count of i.
pub fn accumulate<T: Copy + Default + AddAssign>(counts: &mut [T]) {
    let mut sum = T::default();
    counts.iter_mut().for_each(|count| {
        sum += *count;
        *count = sum;
    });
}

/// Matrix with few entries: (i, j, A_ij) in any order; repeated entries are summed.
#[derive(Clone, Debug, Default)]
pub struct FewEntries {
    pub entries: Vec<(u32, u32, f64)>,
}

impl FewEntries {
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// y ← y + A x
    pub fn add_product(&self, x: &[f64], y: &mut [f64]) {
        self.entries.iter().for_each(|&(i, j, a)| y[i as usize] += a * x[j as usize]);
    }
}

/// Skew-symmetric matrix with few entries: (i, j, A_ij) in any order; repeated entries are summed, and A_ji = −A_ij.
#[derive(Clone, Debug, Default)]
pub struct SkewMatrix {
    pub entries: Vec<(u32, u32, f64)>,
}

impl SkewMatrix {
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// y ← y + A x
    pub fn add_product(&self, x: &[f64], y: &mut [f64]) {
        for &(i, j, a) in &self.entries {
            y[i as usize] += a * x[j as usize];
            y[j as usize] -= a * x[i as usize];
        }
    }
}
