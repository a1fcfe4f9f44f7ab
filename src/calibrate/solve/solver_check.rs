//! Numerical quality of the answer of a fit.

use serde::Serialize;

/// Numerical quality of an answer.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum SolverCheck {
    /// The QP of clarabel compared with least squares by SVD: difference of the stresses over the data \[–\]
    Convex { relative_difference: f64, allowed: f64 },
    /// Only the QP of clarabel, because a stability constraint is active
    Constrained,
    /// Trust region of argmin from several starts, and how many of them ended in the reported minimum
    Starts { starts: usize, agree: usize },
}
