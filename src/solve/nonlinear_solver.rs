//! The solver of a step: its equations, its linear systems, and the steps that all methods share.

use super::diagnosis::rigid_motions::hold;
use super::equations::Equations;
use super::linear::system::LinearSystem;
use super::newton::iteration::{IterationReport, OnIteration};
use super::newton::settings::NewtonSettings;
use super::{Failure, Solution, Step};
use crate::math::linear::Method;
use crate::system::{State, System, Want};

/// Solves the equations of one step by [Newton's method](NonlinearSolver::solve) or by repeated contact corrections. Sums and factorisation are
/// reused from step to step.
pub struct NonlinearSolver {
    pub settings: NewtonSettings,
    pub equations: Equations,
    pub linear: LinearSystem,
    /// Number of iterations of Newton's method so far, including those of failed solves
    pub iterations: usize,
    /// Receives every iteration of Newton's method, and every contact correction
    pub on_iteration: Option<OnIteration>,
    /// Whether a factor served more than one iteration of the last solve
    pub(super) has_reused_factor: bool,
}

impl NonlinearSolver {
    pub fn new(system: &System, settings: NewtonSettings, length: f64) -> Self {
        Self::with_method(Method::default(), system, settings, length)
    }

    /// Builds a solver with this choice between direct and iterative linear solvers; `length` \[m\] is the length of the body.
    pub fn with_method(method: Method, system: &System, settings: NewtonSettings, length: f64) -> Self {
        let (equations, linear) = (Equations::new(system, length), LinearSystem::new(method, system));
        Self { settings, equations, linear, iterations: 0, on_iteration: None, has_reused_factor: false }
    }

    /// Solves a step as [`NonlinearSolver::solve`] does, but with a new factor in every iteration.
    pub(super) fn solve_afresh(&mut self, step: &Step, next: &mut State) -> Result<Solution, Failure> {
        let reuse_factor = std::mem::replace(&mut self.settings.reuse_factor, false);
        let result = self.solve(step, next);
        self.settings.reuse_factor = reuse_factor;
        result
    }

    /// Reports the error of a state after `number` iterations of a step to the observer of the iterations.
    pub(super) fn report(&self, step: &Step, next: &State, number: usize, error: f64) {
        if let Some(on_iteration) = &self.on_iteration {
            on_iteration(&IterationReport { t: next.t, dt: step.dt, number, error: error / self.settings.tolerance });
        }
    }

    /// Solves a step with a new factor in every iteration, and without shifting indefinite tangents: this leads to the nearest equilibrium, including
    /// unstable ones.
    pub(super) fn solve_indefinite(&mut self, step: &Step, next: &mut State) -> Result<Solution, Failure> {
        self.linear.keeps_indefinite = true;
        let result = self.solve_afresh(step, next);
        self.linear.keeps_indefinite = false;
        result.map(|solution| Solution { regularised: true, ..solution })
    }

    /// The solution before the first iteration. The count of an earlier factorisation remains valid as long as there is no new one.
    pub(super) fn no_solution_yet(&self) -> Solution {
        let unstable_modes = self.linear.factor.multigrid().is_none().then_some(0);
        let projected = self.equations.sums.projected;
        Solution {
            iterations: 0,
            correction: None,
            unstable_modes,
            regularised: false,
            shift: 0.0,
            projected,
            anew: false,
        }
    }

    /// Number of negative eigenvalues of the constrained tangent at a converged state, excluding those of free rigid motions, which are zero and may
    /// be negative by rounding; `None` if the tangent has no factorisation. On the iterative path they are counted only if the state is `suspected`
    /// to be unstable, or if the last tangent was factorised.
    pub(super) fn unstable_modes(&mut self, step: &Step, state: &State, suspected: bool) -> Option<usize> {
        let modes = self.negative_eigenvalues(step, state, suspected)?;
        let Self { equations, linear, .. } = self;
        if modes == 0 || hold(step.system, &mut equations.sums, &linear.points, &state.x) == 0 {
            return Some(modes);
        }
        linear.count(step.system, &equations.sums)
    }

    /// Number of negative eigenvalues of the constrained tangent, including those of free rigid motions that are negative by rounding; `None` as for
    /// [`Self::unstable_modes`].
    pub(super) fn negative_eigenvalues(&mut self, step: &Step, state: &State, suspected: bool) -> Option<usize> {
        let Self { equations, linear, .. } = self;
        if linear.factor.multigrid().is_some() && !linear.factor.fell_back() && !suspected {
            return None;
        }
        equations.sums.descending = false;
        let evaluated = equations.evaluate(step, &mut state.clone(), Want::Tangent, None);
        equations.sums.descending = true;
        evaluated.ok()?;
        linear.fit(step.system, &equations.sums);
        linear.count(step.system, &equations.sums)
    }

    /// The failure at a state with this residual.
    pub(super) fn not_converged(&self, system: &System, residual: f64) -> Failure {
        let node = self.equations.worst_node(system);
        match residual <= self.settings.tolerance {
            true => Failure::Inaccurate { node },
            false => Failure::NotConverged { residual, node },
        }
    }
}
