//! Solves single steps: initial values, fallbacks, time error.

use super::contact::check as contact_check;
use super::prediction::Prediction;
use super::start::Start;
use super::step_settings::StepSettings;
use super::{Failure, Integrator, NonlinearSolver, Solution, Step};
use crate::math::tensor::Vec3;
use crate::system::{State, System};

/// Solves single steps for the step strategies.
pub struct StepSolver<'a> {
    pub system: &'a System,
    pub solver: NonlinearSolver,
    pub settings: StepSettings,
    /// \[nodes\] X, for the description of rigid motions; or empty
    pub points: &'a [Vec3],
    pub(super) prediction: Prediction,
    /// M with its factor, once a point has landed. It depends only on the system
    pub(super) mass: Option<Start>,
}

impl<'a> StepSolver<'a> {
    pub(super) fn new(system: &'a System, solver: NonlinearSolver, settings: StepSettings) -> Self {
        Self { system, solver, settings, points: &[], prediction: Prediction::default(), mass: None }
    }

    /// Solves one step to time `t`. If a rigid body [hits](StepSolver::hits) something, a multi-step rule is restarted, if possible.
    pub(super) fn solve(
        &mut self,
        integrator: Integrator,
        state: &State,
        t: f64,
    ) -> Result<(State, Solution), Failure> {
        let (hits, begins) = (self.hits(integrator, state, t), integrator.begins_at(state));
        let mut anew = None;
        if hits && !begins {
            let mut past = state.clone();
            integrator.forget(&mut past);
            anew = self.solve_by(integrator, &past, t).ok();
        }
        let ends_anew = anew.is_some() || begins;
        let (mut next, solution) = match anew {
            Some((next, solution)) => (next, Solution { anew: true, ..solution }),
            None => self.solve_by(integrator, state, t)?,
        };
        if hits && ends_anew {
            integrator.forget(&mut next);
        }
        Ok((next, solution))
    }

    /// Solves one step to time `t` by up to five attempts: from the extrapolation; with a new factor in every iteration; in the same way from the
    /// last state; if the tangent there is already indefinite, without shifting tangents; and with projected tangents.
    fn solve_by(&mut self, integrator: Integrator, state: &State, t: f64) -> Result<(State, Solution), Failure> {
        let dt = t - state.t;
        let landed = self.landed(integrator, state, t)?;
        let state = landed.as_ref().unwrap_or(state);
        let mut next = State { t, ..state.clone() };
        // The linearised step is linearised at the last state: K(xₙ)
        let extrapolate = self.settings.extrapolate && !integrator.is_linearised();
        let extrapolated = extrapolate
            && self.prediction.predict(
                self.system,
                integrator,
                state,
                &mut next,
                &mut self.solver.equations.sums.caches,
            );
        let step = Step { system: self.system, integrator, past: state, dt };
        let guess = next.clone();
        if !integrator.is_linearised() {
            contact_check::check_prescribed_points(&step, &guess)?;
        }
        let mut result = self.attempt(&step, &mut next, NonlinearSolver::solve);
        if result.as_ref().is_err_and(Failure::is_of_memory) {
            return Err(result.expect_err("it has failed"));
        }
        if result.is_err() && self.solver.has_reused_factor {
            next = guess.clone();
            result = self.attempt(&step, &mut next, NonlinearSolver::solve_afresh);
        }
        if result.is_err() && extrapolated {
            next = State { t, ..state.clone() };
            result = self.attempt(&step, &mut next, NonlinearSolver::solve_afresh);
        }
        if result.is_err() && integrator.is_static() && self.is_indefinite(&step) {
            next = guess;
            result = self.attempt(&step, &mut next, NonlinearSolver::solve_indefinite);
        }
        if result.is_err() && self.solver.settings.projection && !integrator.is_linearised() {
            next = State { t, ..state.clone() };
            self.solver.equations.sums.projected = true;
            result = self.attempt(&step, &mut next, NonlinearSolver::solve);
            self.solver.equations.sums.projected = false;
        }
        let solution = result?;
        integrator.finish(state, dt, &mut next);
        Ok((next, solution))
    }

    /// Attempts to solve a step; the solution must satisfy the conditions of contact, except in a linearised step, which is not solved for
    /// equilibrium.
    fn attempt(
        &mut self,
        step: &Step,
        next: &mut State,
        solve: impl Fn(&mut NonlinearSolver, &Step, &mut State) -> Result<Solution, Failure>,
    ) -> Result<Solution, Failure> {
        let solution = solve(&mut self.solver, step, next)?;
        if !step.integrator.is_linearised() {
            contact_check::check_solution(&mut self.solver, step, next)?;
        }
        Ok(solution)
    }

    /// Whether the tangent at the start of a step is indefinite: at an unstable equilibrium, or by rounding if rigid motions are free.
    fn is_indefinite(&mut self, step: &Step) -> bool {
        self.solver.negative_eigenvalues(step, step.past, false).is_some_and(|modes| modes > 0)
    }

    /// Time error of one step relative to the allowed one; 0 if none is set. A multi-step rule that was restarted (`anew`) with this step is implicit
    /// Euler there.
    pub(super) fn time_error(&self, integrator: Integrator, past: &State, next: &State, anew: bool) -> f64 {
        let integrator = if anew { Integrator::ImplicitEuler { linearised: false } } else { integrator };
        let Some(allowed) = self.settings.time_error.filter(|_| !integrator.is_static()) else { return 0.0 };
        let dofs = &self.system.dofs;
        let moving: Vec<u32> = dofs.free.iter().copied().filter(|&dof| dof < dofs.displacements).collect();
        integrator.local_error(past, next, &moving) / allowed
    }
}
