//! A converged nonlinear solve.

/// A converged solve.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Solution {
    pub iterations: usize,
    /// Correction that the equations still ask for at the accepted state, by the last factor, as a share of the largest displacement
    /// \[–\]; none where it is not estimated
    pub correction: Option<f64>,
    /// Negative eigenvalues of the constrained tangent at the last factorisation; 0 at a stable equilibrium, and where the
    /// tangent is not symmetric. None where they were not counted, and conjugate gradients met none
    pub unstable_modes: Option<usize>,
    /// Whether a tangent was shifted towards positive definiteness
    pub regularised: bool,
    /// The last such shift, as a share of the diagonal \[–\]; 0 without one
    pub shift: f64,
    /// Whether the rule began anew with this step, at an impact
    pub anew: bool,
    /// Whether negative eigenvalues of blocks of the tangent were removed
    pub projected: bool,
}
