//! Sparse nonnegative least squares: w ≥ 0 with few nonzero entries and ‖A w − b‖ ≤ τ ‖b‖.
//!
//! Source: Lawson & Hanson, *Solving Least Squares Problems*, 1974, chapter 23, stopped as soon as the bound is met (Chapman, Avery, Collins &
//! Farhat, Int. J. Numer. Meth. Eng. 109, 2017). Columns are scaled to unit length, so that the choice of a column does not depend on its length. The
//! least-squares problem of the chosen columns is solved by the normal equations, which limits the accuracy to about eight digits.

use crate::math::vector::{dot, norm};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

/// The nonzero weights of the columns, and the relative residual.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseWeights {
    /// (column, weight) of the nonzero weights, ascending
    pub weights: Vec<(usize, f64)>,
    /// Relative residual ‖A w − b‖/‖b‖
    pub residual: f64,
}

/// Smallest gradient of a column, relative to ‖b‖, that still reduces the residual.
const LEAST: f64 = 1e-10;

/// Finds w ≥ 0 with at most `most` nonzero entries and ‖A w − b‖ ≤ `tolerance` ‖b‖; otherwise it returns the best weights that it found.
pub fn sparse_weights(a: &Mat<f64>, b: &[f64], tolerance: f64, most: usize) -> SparseWeights {
    let column = |j: usize| a.col_as_slice(j);
    let sizes: Vec<f64> = (0..a.ncols()).map(|j| norm(column(j))).collect();
    let size_of_b = norm(b);
    let (mut chosen, mut weights): (Vec<usize>, Vec<f64>) = (vec![], vec![]);
    let mut gram: Vec<Vec<f64>> = vec![];
    let mut rhs: Vec<f64> = vec![];
    let mut left = b.to_vec();
    let mut refused = vec![false; a.ncols()];
    let mut slopes = vec![0.0; a.ncols()];
    // A column that is chosen, removed and chosen again counts each time
    for _ in 0..3 * most {
        if norm(&left) <= tolerance * size_of_b || chosen.len() == most {
            break;
        }
        multiply(a, &left, &mut slopes);
        let free = (0..a.ncols()).filter(|&j| sizes[j] > 0.0 && !refused[j] && !chosen.contains(&j));
        let slope = |j: usize| (j, slopes[j] / sizes[j]);
        let Some((best, slope)) = free.map(slope).max_by(|x, y| x.1.total_cmp(&y.1)) else { break };
        if slope <= LEAST * size_of_b {
            break;
        }
        let scaled = |i: usize| dot(column(i), column(best)) / (sizes[i] * sizes[best]);
        gram.push(chosen.iter().map(|&i| scaled(i)).chain([1.0]).collect());
        rhs.push(dot(column(best), b) / sizes[best]);
        chosen.push(best);
        weights.push(0.0);
        // A column that depends on the others, or that they push out again, is not chosen twice in a row
        if settle(&mut gram, &mut rhs, &mut chosen, &mut weights) && chosen.contains(&best) {
            refused.fill(false);
        } else {
            refused[best] = true;
        }
        left.copy_from_slice(b);
        for (&j, w) in chosen.iter().zip(&weights) {
            left.iter_mut().zip(column(j)).for_each(|(left, a)| *left -= w / sizes[j] * a);
        }
    }
    let residual = if size_of_b > 0.0 { norm(&left) / size_of_b } else { 0.0 };
    let mut all: Vec<(usize, f64)> =
        chosen.iter().zip(&weights).map(|(&j, w)| (j, w / sizes[j])).filter(|(_, w)| *w > 0.0).collect();
    all.sort_unstable_by_key(|(j, _)| *j);
    SparseWeights { weights: all, residual }
}

/// Moves the weights to the nonnegative least-squares solution of a subset of the chosen columns; returns false if the last column depends on the
/// others and was removed.
fn settle(gram: &mut Vec<Vec<f64>>, rhs: &mut Vec<f64>, chosen: &mut Vec<usize>, weights: &mut Vec<f64>) -> bool {
    while !chosen.is_empty() {
        let n = chosen.len();
        let matrix = Mat::from_fn(n, n, |i, j| if i >= j { gram[i][j] } else { gram[j][i] });
        let Ok(factor) = matrix.llt(Side::Lower) else {
            remove(n - 1, gram, rhs, chosen, weights);
            return false;
        };
        let mut solution = Mat::from_fn(n, 1, |i, _| rhs[i]);
        factor.solve_in_place(solution.as_mut());
        let wanted = |i: usize| solution[(i, 0)];
        if (0..n).all(|i| wanted(i) > 0.0) {
            (0..n).for_each(|i| weights[i] = wanted(i));
            return true;
        }
        let share = |i: usize| weights[i] / (weights[i] - wanted(i));
        let negative = (0..n).filter(|&i| wanted(i) <= 0.0);
        let (first, step) =
            negative.map(|i| (i, share(i))).min_by(|x, y| x.1.total_cmp(&y.1)).expect("one is negative");
        let step = if step.is_finite() { step.clamp(0.0, 1.0) } else { 0.0 };
        (0..n).for_each(|i| weights[i] += step * (wanted(i) - weights[i]));
        remove(first, gram, rhs, chosen, weights);
    }
    true
}

fn remove(k: usize, gram: &mut Vec<Vec<f64>>, rhs: &mut Vec<f64>, chosen: &mut Vec<usize>, weights: &mut Vec<f64>) {
    gram.remove(k);
    gram[k..].iter_mut().for_each(|row| _ = row.remove(k));
    rhs.remove(k);
    chosen.remove(k);
    weights.remove(k);
}

/// Computes Aᵀ v.
fn multiply(a: &Mat<f64>, v: &[f64], out: &mut [f64]) {
    let (rows, columns) = (v.len(), out.len());
    let v = MatRef::from_column_major_slice(v, rows, 1);
    let out = MatMut::from_column_major_slice_mut(out, columns, 1);
    matmul(out, Accum::Replace, a.transpose(), v, 1.0, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// The sum of all columns of a matrix of rank 6 is reproduced by at most 6 weights (Carathéodory), none of them negative.
    #[test]
    fn few_weights_reproduce_a_sum_of_low_rank() {
        let (m, n, rank) = (40, 300, 6);
        let mut random = SplitMix(3);
        let left = Mat::from_fn(m, rank, |_, _| random.unit() - 0.5);
        let right = Mat::from_fn(rank, n, |_, _| random.unit() - 0.3);
        let a = &left * &right;
        let b: Vec<f64> = (0..m).map(|i| (0..n).map(|j| a[(i, j)]).sum()).collect();
        let found = sparse_weights(&a, &b, 1e-6, n);
        assert!(found.residual <= 1e-6, "{:e}", found.residual);
        assert!(found.weights.len() <= rank && found.weights.iter().all(|(_, w)| *w > 0.0), "{found:?}");
    }

    /// The point of the cone of (1, 0) and (1, 1) that is nearest to (−1, 2) is its projection on (1, 1): the weight is ½ there and 0 on the other.
    #[test]
    fn the_best_weights_where_none_reproduce() {
        let a = Mat::from_fn(2, 2, |i, j| if i == 0 || j == 1 { 1.0 } else { 0.0 });
        let found = sparse_weights(&a, &[-1.0, 2.0], 1e-9, 2);
        assert_eq!(found.weights.len(), 1);
        assert_eq!(found.weights[0].0, 1);
        assert!((found.weights[0].1 - 0.5).abs() < 1e-14);
        assert!((found.residual - (4.5_f64 / 5.0).sqrt()).abs() < 1e-14);
    }
}
