//! Why a linear system was not solved.

use super::method::MOST_ITERATIONS;
use std::fmt;

/// A matrix without a usable factorisation.
#[derive(Clone, Debug, PartialEq)]
pub enum LinearError {
    /// Zero or non-finite pivot: the matrix is singular to working precision.
    Singular,
    /// ‖Ax − b‖/‖b‖ stayed above the bound, and above rounding, after refinement.
    Inaccurate { residual: f64 },
    /// The matrix has negative curvature, and its factor would take `gigabytes`, more than is allowed
    Indefinite { gigabytes: f64 },
    /// The Krylov method does not come to the accuracy of a solve, and the factor would take `gigabytes`, more than is allowed
    Slow { gigabytes: f64 },
    /// The factor would take `gigabytes`, more than is allowed, and the matrix is not one for the iterative path
    TooLarge { gigabytes: f64 },
}

impl fmt::Display for LinearError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular => write!(f, "the tangent matrix is singular to working precision"),
            Self::Inaccurate { residual } => {
                write!(f, "the linear solve is inaccurate (relative residual {residual:e})")
            }
            Self::Indefinite { gigabytes } => write!(
                f,
                "the tangent has negative curvature, which the iterative path cannot solve for, and its factor of {gigabytes:.1} GB is \
                 larger than factor_memory"
            ),
            Self::Slow { gigabytes } => write!(
                f,
                "the iterative method does not solve for the tangent in {MOST_ITERATIONS} iterations, and its factor of {gigabytes:.1} GB is larger than \
                 factor_memory"
            ),
            Self::TooLarge { gigabytes } => write!(
                f,
                "the factor of the tangent takes {gigabytes:.1} GB, more than factor_memory, and the iterative path is not for this scene"
            ),
        }
    }
}

impl std::error::Error for LinearError {}
