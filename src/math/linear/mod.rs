//! Solution of symmetric systems, sparse with a low-rank part ([`Pattern`](super::low_rank::Pattern)): LLᵀ where the matrix is positive definite, LDLᵀ where it is
//! not; and where the factor is too large, a Krylov method to the same residual, with a multigrid hierarchy
//! ([`multigrid`](super::multigrid)) of the sparse part: conjugate gradients, or generalised minimal residuals next to the pressures of a mixed formulation.
//!
//! The unknowns are numbered in elimination order before the matrix is assembled, so the factorisation permutes nothing. The choice
//! between the two methods is made by counts ([`Method`]), so that it is the same for one matrix on every machine. Where conjugate gradients
//! find negative curvature, or either method is slow, this matrix is factorised, if [`Method::factor_memory`] allows it.

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
