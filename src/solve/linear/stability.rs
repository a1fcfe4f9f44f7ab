//! Negative eigenvalues of the constrained tangent: n₋(K) − n₋(S), less one for each unknown of a second field.
//!
//! Pivots of a factorisation count those of K (Sylvester's law of inertia). Limits: the iterative method has no pivots, and counts none.

use super::multipliers::Schur;
use crate::math::linear::Factor;
use crate::system::{Assembled, System};

/// Negative eigenvalues of the constrained tangent, by those of K: a second field adds one for each unknown, a multiplier one
/// of S. Where the tangent has a skew part they are not meaningful, and 0 is returned. None with the iterative method.
pub(in crate::solve) fn negative_eigenvalues(
    factor: &Factor,
    system: &System,
    sums: &Assembled,
    schur: &Schur,
) -> Option<usize> {
    let expected = system.scalar_equations() + schur.negative;
    let pivots = factor.has_inertia().then_some(factor.negative_eigenvalues)?;
    Some(if sums.skew.is_empty() { pivots.saturating_sub(expected) } else { 0 })
}
