//! Number of negative eigenvalues of the constrained tangent: n₋(K) − n₋(S), less one for each unknown of a second field.
//!
//! The pivots of a factorisation give n₋(K) (Sylvester's law of inertia). Limits: the iterative method has no pivots, so that nothing is counted.

use super::multipliers::Schur;
use crate::math::linear::Factor;
use crate::system::{Assembled, System};

/// Number of negative eigenvalues of the constrained tangent, from those of K: a second field adds one for each unknown, and constraints add those of
/// S. With a skew part the number has no meaning, and 0 is returned. `None` with the iterative method.
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
