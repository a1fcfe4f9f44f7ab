//! Reasons why a linear system was not solved.

use super::method::MOST_ITERATIONS;

/// The matrix has no usable factorisation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// A pivot is zero or not finite: the matrix is singular to working precision.
    #[error("the tangent matrix is singular to working precision")]
    Singular,
    /// ‖Ax − b‖/‖b‖ stayed above the bound, and above the rounding level, after refinement.
    #[error("the linear solve is inaccurate (relative residual {residual:e})")]
    Inaccurate { residual: f64 },
    /// The matrix has negative curvature, and its factor would take `gigabytes`, more than is allowed
    #[error(
        "the tangent has negative curvature, which the iterative path cannot solve for, and its factor takes {}, more than \
         factor_memory",
        memory(*gigabytes)
    )]
    Indefinite { gigabytes: f64 },
    /// The Krylov method does not reach the accuracy of a solve, and the factor would take `gigabytes`, more than is allowed
    #[error(
        "the iterative method does not converge in {} iterations, and the factor of the tangent takes {}, more than \
         factor_memory",
        MOST_ITERATIONS, memory(*gigabytes)
    )]
    Slow { gigabytes: f64 },
    /// The factor would take `gigabytes`, more than is allowed, and the matrix is not suited for the iterative path
    #[error(
        "the factor of the tangent takes {}, more than factor_memory, and the iterative path does not support this scene",
        memory(*gigabytes)
    )]
    TooLarge { gigabytes: f64 },
}

/// A memory size in GB, or in MB below 0.1 GB.
fn memory(gigabytes: f64) -> String {
    if gigabytes < 0.1 { format!("{:.2} MB", 1e3 * gigabytes) } else { format!("{gigabytes:.1} GB") }
}
