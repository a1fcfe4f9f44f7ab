//! The result of a converged nonlinear solve.

/// A converged solve.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Solution {
    pub iterations: usize,
    /// Remaining correction at the accepted state, by the last factor, relative to the largest displacement \[–\]; `None` if it is not estimated
    pub correction: Option<f64>,
    /// Number of negative eigenvalues of the constrained tangent at the last factorisation; 0 at a stable equilibrium, and if the tangent is not
    /// symmetric. `None` if they were not counted and conjugate gradients found no negative curvature
    pub unstable_modes: Option<usize>,
    /// Whether a tangent was shifted towards positive definiteness
    pub regularised: bool,
    /// The last such shift, relative to the diagonal \[–\]; 0 if there was none
    pub shift: f64,
    /// Whether the integrator was restarted with this step, because of an impact
    pub anew: bool,
    /// Whether negative eigenvalues of blocks of the tangent were removed
    pub projected: bool,
}
