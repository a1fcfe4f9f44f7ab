//! The linear systems of a step, (K + A) X = B: K symmetric and factorised, A the skew part that a follower load has.
//!
//! Without A this is the direct solve. With it GMRES takes (I + K⁻¹A) x = K⁻¹ b: A acts on a rim only and is small compared with
//! K, so a few products do. K alone need not be definite.

use crate::math::gmres::gmres;
use crate::math::linear::{Factor, LinearError};
use crate::system::Assembled;

/// In place; `columns` of length n one after the other. `factor` holds the K of `sums`.
pub(super) fn solve(factor: &mut Factor, sums: &Assembled, columns: &mut [f64]) -> Result<(), LinearError> {
    factor.solve(&sums.k, columns)?;
    if sums.skew.is_empty() {
        return Ok(());
    }
    for column in columns.chunks_exact_mut(sums.increment_force.len()) {
        let apply = |v: &[f64]| {
            let mut product = vec![0.0; v.len()];
            sums.skew.add_product(v, &mut product);
            factor.solve(&sums.k, &mut product)?;
            product.iter_mut().zip(v).for_each(|(p, v)| *p += v);
            Ok(product)
        };
        let x = gmres(apply, column)?;
        column.copy_from_slice(&x);
    }
    Ok(())
}
