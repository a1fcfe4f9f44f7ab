//! Contractions of tensors at several points side by side.

use crate::math::lanes::Lanes;

/// Returns Σ_n a_n b_n of two tensors given row by row.
#[inline(always)]
pub(in crate::reduction) fn contract(a: &[Lanes; 9], b: &[Lanes; 9]) -> Lanes {
    let mut sum = a[0] * b[0];
    for n in 1..9 {
        sum += a[n] * b[n];
    }
    sum
}
