//! The solver of a step: its equations, its linear systems, and the steps that all methods share.

use super::equations::Equations;
use super::linear_system::LinearSystem;
use super::newton_settings::NewtonSettings;
use super::{Failure, Solution, Step};
use crate::math::linear::Method;
use crate::system::{State, System, Want};

/// Solves the equations of one step, by [Newton's method](NonlinearSolver::solve) or by repeated contact corrections. Sums and
/// factorisation are reused from step to step.
pub struct NonlinearSolver {
    pub settings: NewtonSettings,
    pub equations: Equations,
    pub linear: LinearSystem,
}

impl NonlinearSolver {
    pub fn new(system: &System, settings: NewtonSettings, length: f64) -> Self {
        Self::with_method(Method::default(), system, settings, length)
    }

    /// With this choice between direct and iterative linear solvers; `length` \[m\] is that of the body.
    pub fn with_method(method: Method, system: &System, settings: NewtonSettings, length: f64) -> Self {
        Self { settings, equations: Equations::new(system, length), linear: LinearSystem::new(method, system) }
    }

    /// The solution before the first iteration. The count of an earlier factorisation holds as long as there is no new one.
    pub(super) fn no_solution_yet(&self) -> Solution {
        let unstable_modes = self.linear.factor.multigrid().is_none().then_some(0);
        Solution { iterations: 0, unstable_modes, regularised: false, projected: self.equations.sums.projected }
    }

    /// Negative eigenvalues of the constrained tangent at a converged state; none where it has no factorisation, or where they are
    /// not counted.
    pub(super) fn unstable_modes(&mut self, step: &Step, state: &State) -> Option<usize> {
        let Self { equations, linear, .. } = self;
        if linear.factor.multigrid().is_some() && !linear.factor.fell_back() {
            return None;
        }
        equations.sums.descending = false;
        let evaluated = equations.evaluate(step, &mut state.clone(), Want::Tangent, None);
        equations.sums.descending = true;
        evaluated.ok()?;
        linear.fit(step.system, &equations.sums);
        linear.factor.factorise_counting(&equations.sums.k).ok()?;
        let schur = linear.schur(step.system, &equations.sums).ok()?;
        linear.negative(step.system, &equations.sums, &schur)
    }

    /// The failure at a state of this error.
    pub(super) fn not_converged(&self, system: &System, residual: f64) -> Failure {
        Failure::NotConverged { residual, node: self.equations.worst_node(system) }
    }
}
