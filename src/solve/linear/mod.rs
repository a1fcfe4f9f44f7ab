//! The linear system of an iteration: factorisation, constraints, and factors of earlier tangents.

pub(super) mod lagged_factor;
pub(super) mod multipliers;
mod nodal_rotations;
pub(super) mod problem;
mod stability;
pub(super) mod system;
pub(super) mod tangent;
