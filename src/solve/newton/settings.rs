//! Settings of the nonlinear solver.

/// Tolerances of the nonlinear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// ‖r‖ ≤ tolerance · (largest effect's Σ‖r_e‖), |g| ≤ tolerance · (length or volume of the constraint)
    pub tolerance: f64,
    /// Largest correction that an accepted state may still ask for, as a share of the largest displacement \[–\]
    pub accuracy: f64,
    pub max_iterations: usize,
    pub line_search: bool,
    /// Reuse factorisations, from step to step too (`lagged_factor`); without it every iteration has its own
    pub reuse_factor: bool,
    /// A factorisation that costs at least so many back-substitutions is reused from step to step
    pub reuse_threshold: f64,
    /// Where a step fails, try it with tangents of blocks made positive semidefinite
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
