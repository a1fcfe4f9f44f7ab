//! Solution of symmetric systems, sparse with a low-rank part ([`Pattern`](super::low_rank::Pattern)): LLᵀ if the matrix is positive definite,
//! otherwise LDLᵀ. If the factor is too large, a Krylov method with a multigrid hierarchy ([`multigrid`](super::multigrid)) of the sparse part solves
//! to the same residual: conjugate gradients, or generalised minimal residuals for the pressures of a mixed formulation.
//!
//! The unknowns are numbered in elimination order before the matrix is assembled, so that the factorisation permutes nothing. The choice between the
//! two methods depends on operation counts only ([`Method`]), so that it is the same for one matrix on every machine. If conjugate gradients find
//! negative curvature, or either Krylov method is slow, the matrix is factorised, provided that [`Method::factor_memory`] allows it.

mod border;
mod bordered;
mod direct;
mod elimination_tree;
mod error;
mod factor;
mod method;
mod multifrontal;
mod solve;
mod substitution;

pub use direct::Direct;
pub use error::LinearError;
pub use factor::{Definiteness, Factor, GradientCounts};
pub use method::{Linear, Method};
