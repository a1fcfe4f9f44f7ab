//! Settings of the nonlinear solver.

/// Tolerances and options of the nonlinear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// ‖r‖ ≤ tolerance · (largest Σ‖r_e‖ of any effect), |g| ≤ tolerance · (length or volume of the constraint)
    pub tolerance: f64,
    /// Largest correction that an accepted state may still need, relative to the largest displacement \[–\]
    pub accuracy: f64,
    pub max_iterations: usize,
    pub line_search: bool,
    /// Whether factorisations are reused, also from step to step (`lagged_factor`); otherwise every iteration has its own
    pub reuse_factor: bool,
    /// Smallest cost of a factorisation, in back-substitutions, at which it is reused from step to step
    pub reuse_threshold: f64,
    /// Whether a failed step is tried again with the blocks of the tangent made positive semidefinite
    pub projection: bool,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            accuracy: 1e-6,
            max_iterations: 30,
            line_search: true,
            reuse_factor: true,
            reuse_threshold: 4.0,
            projection: false,
        }
    }
}
