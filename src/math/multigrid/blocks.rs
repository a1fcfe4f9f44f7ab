//! Sparse matrices of small dense blocks in compressed rows, as used by the levels of a multigrid hierarchy.

use crate::math::sparse::accumulate;
use crate::math::threads;
use std::ops::Range;

/// Smallest number of blocks in a part of the rows, and largest number of parts: more parts than threads balance the load.
const LEAST: usize = 50_000;
const MOST: usize = 8;
/// Factor on the number of parts where each part stores a product of its own.
const FINER: usize = 4;

/// A block of R × C stored by columns: `block[c][r]`.
pub type Block<const R: usize, const C: usize, T = f64> = [[T; R]; C];

/// A matrix of R × C blocks; columns ascend within a row.
#[derive(Clone, Debug, Default)]
pub struct BlockMatrix<const R: usize, const C: usize, T = f64> {
    /// Number of block columns
    pub columns: usize,
    /// \[rows + 1\] start of each row in `col` and `values`
    pub row_ptr: Vec<u32>,
    /// \[blocks\]
    pub col: Vec<u32>,
    /// \[blocks\]
    pub values: Vec<Block<R, C, T>>,
}

/// The positions of the blocks of Aᵀ in A, row by row of Aᵀ.
struct Transposition {
    row_ptr: Vec<u32>,
    /// \[blocks\] row of each block in A
    row: Vec<u32>,
    /// \[blocks\] index among the blocks of A
    slot: Vec<u32>,
}

fn transposed<const R: usize, const C: usize, T: Copy>(block: &Block<R, C, T>) -> Block<C, R, T> {
    std::array::from_fn(|r| std::array::from_fn(|c| block[c][r]))
}

impl<const R: usize, const C: usize, T: Copy + Into<f64> + Sync> BlockMatrix<R, C, T> {
    /// Number of block rows.
    pub fn rows(&self) -> usize {
        self.row_ptr.len() - 1
    }

    /// Range of the blocks of row i.
    pub fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.row_ptr[i] as usize..self.row_ptr[i + 1] as usize
    }

    /// Columns and blocks of row i.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Block<R, C, T>)> {
        let range = self.range(i);
        self.col[range.clone()].iter().map(|&j| j as usize).zip(&self.values[range])
    }

    /// Number of stored scalars.
    pub fn entries(&self) -> usize {
        R * C * self.values.len()
    }

    /// Returns Aᵀ.
    pub fn transposed(&self) -> BlockMatrix<C, R, T> {
        let Transposition { row_ptr, row, slot } = self.transposition();
        let values = slot.iter().map(|&k| transposed(&self.values[k as usize])).collect();
        BlockMatrix { columns: self.rows(), row_ptr, col: row, values }
    }

    fn transposition(&self) -> Transposition {
        let mut row_ptr = vec![0u32; self.columns + 1];
        self.col.iter().for_each(|&j| row_ptr[j as usize + 1] += 1);
        accumulate(&mut row_ptr);
        let mut next = row_ptr.clone();
        let (mut row, mut slot) = (vec![0u32; self.col.len()], vec![0u32; self.col.len()]);
        for i in 0..self.rows() {
            for k in self.range(i) {
                let to = &mut next[self.col[k] as usize];
                (row[*to as usize], slot[*to as usize]) = (i as u32, k as u32);
                *to += 1;
            }
        }
        Transposition { row_ptr, row, slot }
    }

    /// Ranges of rows with about equally many blocks, which are distributed over threads.
    pub fn parts(&self) -> Vec<Range<usize>> {
        threads::divide(&self.row_ptr, LEAST, MOST)
    }

    /// Applies f to each row.
    pub fn by_rows<Y: Clone + Send>(&self, f: impl Fn(usize) -> Y + Sync) -> Vec<Y> {
        threads::map(self.parts(), |rows| rows.map(&f).collect::<Vec<Y>>()).concat()
    }

    /// Returns A x.
    pub fn product(&self, x: &[[f64; C]]) -> Vec<[f64; R]> {
        self.by_rows(|i| self.row_times(i, x))
    }

    /// Returns y_i of y = A x.
    pub fn row_times(&self, i: usize, x: &[[f64; C]]) -> [f64; R] {
        let mut y = [0.0; R];
        self.row(i).for_each(|(j, a)| add_product(&mut y, a, &x[j]));
        y
    }
}

impl<const R: usize, const C: usize> BlockMatrix<R, C> {
    /// The matrix in single precision.
    pub fn rounded(self) -> BlockMatrix<R, C, f32> {
        let values = self.values.iter().map(|block| block.map(|column| column.map(|v| v as f32))).collect();
        BlockMatrix { columns: self.columns, row_ptr: self.row_ptr, col: self.col, values }
    }

    /// Returns A B, computed row by row (Gustavson, ACM Trans. Math. Softw. 4, 1978): first the columns, so that the blocks are allocated once.
    pub fn times<const D: usize>(&self, other: &BlockMatrix<C, D>) -> BlockMatrix<R, D> {
        let (mut row_ptr, mut col) = (vec![0], Vec::new());
        for (ends, of_part) in threads::map(self.parts(), |rows| self.columns_times(rows, other)) {
            let before = col.len() as u32;
            row_ptr.extend(ends.iter().map(|end| before + end));
            col.extend(of_part);
        }
        let mut values = vec![[[0.0; R]; D]; col.len()];
        let mut rest = &mut values[..];
        let split = |rows: Range<usize>| {
            let blocks = row_ptr[rows.end] - row_ptr[rows.start];
            let (own, after) = std::mem::take(&mut rest).split_at_mut(blocks as usize);
            rest = after;
            (rows, own)
        };
        let parts: Vec<_> = self.parts().into_iter().map(split).collect();
        threads::map(parts, |(rows, values)| self.rows_times(rows, other, (&row_ptr, &col), values));
        BlockMatrix { columns: other.columns, row_ptr, col, values }
    }

    /// Returns Aᵀ B A, and the number of blocks of B A that were computed. B A, the largest of the matrices, exists only in parts: each part of the
    /// rows of Aᵀ computes the rows of B A that it needs.
    pub fn galerkin(&self, b: &BlockMatrix<R, R>) -> (BlockMatrix<C, C>, usize) {
        self.galerkin_in_parts(b, LEAST / FINER)
    }

    /// Computes [`Self::galerkin`] in parts of at least `least` blocks of Aᵀ.
    fn galerkin_in_parts(&self, b: &BlockMatrix<R, R>, least: usize) -> (BlockMatrix<C, C>, usize) {
        let transposition = self.transposition();
        let of_part = |part: Range<usize>| {
            let range = transposition.row_ptr[part.start] as usize..transposition.row_ptr[part.end] as usize;
            let rows = &transposition.row[range.clone()];
            let mut needed = rows.to_vec();
            needed.sort_unstable();
            needed.dedup();
            let product = b.selected(&needed).times_alone(self);
            let at = |i: &u32| needed.binary_search(i).expect("it is needed") as u32;
            let ends = transposition.row_ptr[part.start..=part.end].iter();
            let own = BlockMatrix {
                columns: needed.len(),
                row_ptr: ends.map(|&end| end - range.start as u32).collect(),
                col: rows.iter().map(at).collect(),
                values: transposition.slot[range].iter().map(|&k| transposed(&self.values[k as usize])).collect(),
            };
            (own.times_alone(&product), product.col.len())
        };
        let parts = threads::map(threads::divide(&transposition.row_ptr, least, FINER * MOST), of_part);
        let blocks = parts.iter().map(|(part, _)| part.col.len()).sum();
        let (mut row_ptr, mut col, mut values) = (vec![0], Vec::with_capacity(blocks), Vec::with_capacity(blocks));
        let mut computed = 0;
        for (part, of_part) in parts {
            let before = col.len() as u32;
            row_ptr.extend(part.row_ptr[1..].iter().map(|end| before + end));
            col.extend(part.col);
            values.extend(part.values);
            computed += of_part;
        }
        (BlockMatrix { columns: self.columns, row_ptr, col, values }, computed)
    }

    /// The matrix of these rows of A.
    fn selected(&self, rows: &[u32]) -> Self {
        let blocks = rows.iter().map(|&i| self.range(i as usize).len()).sum();
        let (mut row_ptr, mut col, mut values) = (vec![0], Vec::with_capacity(blocks), Vec::with_capacity(blocks));
        for &i in rows {
            let range = self.range(i as usize);
            col.extend_from_slice(&self.col[range.clone()]);
            values.extend_from_slice(&self.values[range]);
            row_ptr.push(col.len() as u32);
        }
        Self { columns: self.columns, row_ptr, col, values }
    }

    /// Returns A B, computed on one thread.
    fn times_alone<const D: usize>(&self, other: &BlockMatrix<C, D>) -> BlockMatrix<R, D> {
        let (ends, col) = self.columns_times(0..self.rows(), other);
        let row_ptr: Vec<u32> = std::iter::once(0).chain(ends).collect();
        let mut values = vec![[[0.0; R]; D]; col.len()];
        self.rows_times(0..self.rows(), other, (&row_ptr, &col), &mut values);
        BlockMatrix { columns: other.columns, row_ptr, col, values }
    }

    /// Returns the end of each of these rows of A B in the list of columns, and the columns.
    fn columns_times<const D: usize>(&self, rows: Range<usize>, other: &BlockMatrix<C, D>) -> (Vec<u32>, Vec<u32>) {
        let (mut ends, mut col) = (Vec::with_capacity(rows.len()), Vec::new());
        // The last row that had a block in a column
        let mut seen = vec![u32::MAX; other.columns];
        for i in rows {
            let start = col.len();
            for &j in &self.col[self.range(i)] {
                for &k in &other.col[other.range(j as usize)] {
                    if seen[k as usize] != i as u32 {
                        seen[k as usize] = i as u32;
                        col.push(k);
                    }
                }
            }
            col[start..].sort_unstable();
            ends.push(col.len() as u32);
        }
        (ends, col)
    }

    /// Adds the blocks of these rows of A B to `values`, whose first block is that of the first of the rows.
    fn rows_times<const D: usize>(
        &self,
        rows: Range<usize>,
        other: &BlockMatrix<C, D>,
        (row_ptr, col): (&[u32], &[u32]),
        values: &mut [Block<R, D>],
    ) {
        let first = row_ptr[rows.start] as usize;
        // Position of the blocks of the current row, by column
        let mut place = vec![0u32; other.columns];
        for i in rows {
            let range = row_ptr[i] as usize..row_ptr[i + 1] as usize;
            range.clone().zip(&col[range]).for_each(|(slot, &k)| place[k as usize] = (slot - first) as u32);
            for (j, a) in self.row(i) {
                for (k, b) in other.row(j) {
                    let block = &mut values[place[k] as usize];
                    block.iter_mut().zip(b).for_each(|(sum, b)| add_product(sum, a, b));
                }
            }
        }
    }
}

impl<const B: usize, T: Copy + Into<f64> + Sync> BlockMatrix<B, B, T> {
    /// Position of the diagonal block of row i.
    pub fn diagonal(&self, i: usize) -> usize {
        let range = self.range(i);
        range.start + self.col[range].binary_search(&(i as u32)).expect("a row has its diagonal")
    }
}

/// y += A x
pub fn add_product<const R: usize, const C: usize, T: Copy + Into<f64>>(
    y: &mut [f64; R],
    a: &Block<R, C, T>,
    x: &[f64; C],
) {
    for (a, x) in a.iter().zip(x) {
        y.iter_mut().zip(a).for_each(|(y, &a)| *y += a.into() * x);
    }
}

/// y −= A x
pub fn subtract_product<const R: usize, const C: usize, T: Copy + Into<f64>>(
    y: &mut [f64; R],
    a: &Block<R, C, T>,
    x: &[f64; C],
) {
    for (a, x) in a.iter().zip(x) {
        y.iter_mut().zip(a).for_each(|(y, &a)| *y -= a.into() * x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use nalgebra::DMatrix;

    fn random<const R: usize, const C: usize>(rows: usize, columns: usize, random: &mut SplitMix) -> BlockMatrix<R, C> {
        let mut m = BlockMatrix { columns, row_ptr: vec![0], ..BlockMatrix::default() };
        for _ in 0..rows {
            for j in 0..columns {
                if random.unit() < 0.4 {
                    m.col.push(j as u32);
                    m.values.push(std::array::from_fn(|_| std::array::from_fn(|_| random.unit() - 0.5)));
                }
            }
            m.row_ptr.push(m.col.len() as u32);
        }
        m
    }

    fn dense<const R: usize, const C: usize>(m: &BlockMatrix<R, C>) -> DMatrix<f64> {
        let mut d = DMatrix::zeros(R * m.rows(), C * m.columns);
        for i in 0..m.rows() {
            for (j, a) in m.row(i) {
                (0..R).for_each(|r| (0..C).for_each(|c| d[(R * i + r, C * j + c)] = a[c][r]));
            }
        }
        d
    }

    /// Sums of about ten products of numbers below 1: rounding is below 1e-14.
    #[test]
    fn products_are_those_of_dense_matrices() {
        let mut r = SplitMix(7);
        let (a, b) = (random::<3, 6>(9, 7, &mut r), random::<6, 2>(7, 8, &mut r));
        assert!((dense(&a.times(&b)) - dense(&a) * dense(&b)).amax() < 1e-14);
        let c = random::<3, 3>(9, 9, &mut r);
        let (all, computed) = a.galerkin(&c);
        assert!((dense(&all) - dense(&a).transpose() * dense(&c) * dense(&a)).amax() < 1e-14);
        let whole = a.transposed().times(&c.times(&a));
        assert_eq!((&all.values, computed), (&whole.values, c.times(&a).col.len()));
        let (by_parts, computed) = a.galerkin_in_parts(&c, 5);
        assert_eq!((by_parts.row_ptr, by_parts.col, by_parts.values), (whole.row_ptr, whole.col, whole.values));
        assert!(computed > c.times(&a).col.len(), "several parts, which need some rows twice");
        assert_eq!(dense(&a.transposed()), dense(&a).transpose());
        let x: Vec<[f64; 3]> = (0..9).map(|_| std::array::from_fn(|_| r.unit())).collect();
        let flat = DMatrix::from_iterator(27, 1, x.iter().flatten().copied());
        let y = a.transposed().product(&x).into_iter().flatten();
        assert!(y.zip((dense(&a).transpose() * flat).iter()).all(|(y, d)| (y - d).abs() < 1e-14));
    }
}
