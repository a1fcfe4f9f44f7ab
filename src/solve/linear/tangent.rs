//! The linear systems of a step, (K + A) X = B: K is symmetric and factorised; A is the skew part of follower loads plus the remainder of contact
//! with friction.
//!
//! Without A this is the direct solve. With A, GMRES is preconditioned by K: A acts only on a rim or at contact points, so that a few products
//! suffice. K itself need not be definite.

use crate::math::gmres::gmres;
use crate::math::linear::{Factor, LinearError};
use crate::math::vector::norm;
use crate::system::Assembled;

/// Relative residual ‖b − (K + A) x‖/‖b‖ with a skew part, and largest number of products.
const SKEW: (f64, usize) = (1e-10, 100);
/// Relative residual with a remainder only, for directions of Newton's method, and largest number of products.
const REMAINDER: (f64, usize) = (1e-4, 100);

/// Solves in place; `columns` holds consecutive columns of length n. `factor` holds the K of `sums`.
pub(in crate::solve) fn solve(factor: &mut Factor, sums: &Assembled, columns: &mut [f64]) -> Result<(), LinearError> {
    if sums.skew.is_empty() && sums.remainder.is_empty() {
        return factor.solve(&sums.k, columns);
    }
    let (tolerance, most) = if sums.skew.is_empty() { REMAINDER } else { SKEW };
    for column in columns.chunks_exact_mut(sums.increment_force.len()) {
        let multiply = |v: &[f64]| {
            let mut product = vec![0.0; v.len()];
            sums.pattern.multiply(&sums.k, v, &mut product);
            sums.skew.add_product(v, &mut product);
            sums.remainder.add_product(v, &mut product);
            product
        };
        let precondition = |r: &[f64]| {
            let mut z = r.to_vec();
            factor.solve(&sums.k, &mut z)?;
            Ok(z)
        };
        let (x, _) = gmres(multiply, precondition, column, tolerance * norm(column), most)?;
        column.copy_from_slice(&x);
    }
    Ok(())
}
