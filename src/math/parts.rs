//! Products with a symmetric matrix on several threads.
//!
//! The columns are divided into parts. Each part adds into a vector of its own, which has few rows beyond the part: those of separators, because the
//! unknowns are in their elimination order. The sums are added in the order of the parts, so that results do not depend on the number of threads.

use super::sparse::SymPattern;
use super::threads;
use std::ops::Range;

/// Smallest number of entries in a part, and largest number of parts.
const LEAST: usize = 100_000;
const MOST: usize = 8;

/// Ranges of columns, each with the rows below the range in which its columns have entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Parts(Vec<(Range<usize>, Vec<u32>)>);

impl Parts {
    pub fn new(pattern: &SymPattern) -> Self {
        let part = |columns: Range<usize>| {
            let mut rows: Vec<u32> = pattern.row_idx
                [pattern.col_ptr[columns.start] as usize..pattern.col_ptr[columns.end] as usize]
                .iter()
                .copied()
                .filter(|&i| i as usize >= columns.end)
                .collect();
            rows.sort_unstable();
            rows.dedup();
            (columns, rows)
        };
        let columns = threads::divide(&pattern.col_ptr, LEAST, MOST);
        Self(if columns.len() < 2 { Vec::new() } else { columns.into_iter().map(part).collect() })
    }

    /// y ← A x for the matrix of this pattern.
    pub fn multiply(&self, pattern: &SymPattern, values: &[f64], x: &[f64], y: &mut [f64]) {
        if self.0.is_empty() {
            return pattern.multiply(values, x, y);
        }
        let of_part = |(columns, _): &(Range<usize>, Vec<u32>)| {
            let first = columns.start;
            let mut own = vec![0.0; pattern.n - first];
            pattern.add_columns(columns.clone(), values, x, |i, v| own[i - first] += v);
            own
        };
        let sums = threads::map(self.0.iter().collect(), of_part);
        y.fill(0.0);
        for ((columns, beyond), own) in self.0.iter().zip(&sums) {
            y[columns.clone()].iter_mut().zip(own).for_each(|(y, own)| *y += own);
            beyond.iter().for_each(|&i| y[i as usize] += own[i as usize - columns.start]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// Rows have about twenty entries below 1, so that rounding is below 1e-13. Results are bit-identical for any number of threads.
    #[test]
    fn products_of_parts_are_those_of_the_whole() {
        let n = 40_000u32;
        let mut random = SplitMix(3);
        let mut any = |below: u32| (random.unit() * f64::from(below)) as u32;
        let pairs: Vec<(u32, u32)> = (0..n).flat_map(|i| [1, 7, 300].map(|d| (i, i.saturating_sub(d)))).collect();
        let far: Vec<(u32, u32)> = (0..100_000).map(|_| (any(n), any(n))).collect();
        let pattern = SymPattern::from_pairs(n as usize, pairs.into_iter().chain(far));
        let mut random = SplitMix(4);
        let values: Vec<f64> = (0..pattern.nnz()).map(|_| random.unit() - 0.5).collect();
        let x: Vec<f64> = (0..n).map(|_| random.unit() - 0.5).collect();
        let (mut whole, mut first) = (vec![0.0; x.len()], Vec::new());
        pattern.multiply(&values, &x, &mut whole);
        let parts = Parts::new(&pattern);
        assert!(parts.0.len() > 1);
        for count in [1, 2, 3] {
            threads::use_threads(count);
            let mut y = vec![1.0; x.len()];
            parts.multiply(&pattern, &values, &x, &mut y);
            assert!(y.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-13));
            first = if first.is_empty() { y.clone() } else { first };
            assert_eq!(y, first);
        }
    }
}
