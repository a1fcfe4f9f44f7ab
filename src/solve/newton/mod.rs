//! Newton's method for the equations of one step.
//!
//! Each iteration takes its direction from the [linear system](super::linear::system) and follows it as far as the [globalisation](globalisation)
//! allows; [`Convergence`] accepts the state.

pub(super) mod convergence;
pub(super) mod failure;
pub(super) mod globalisation;
pub(super) mod iteration;
pub(super) mod settings;
pub(super) mod solution;

use super::contact::correction::{correct_repeatedly, uses_corrections};
use super::equations::{Equations, ScaledError};
use super::linear::multipliers::Schur;
use super::linear::problem::{LinearProblem, NewtonDirection};
use super::nonlinear_solver::NonlinearSolver;
use super::{Failure, Solution, Step};
use crate::system::{State, Want};
use convergence::{AtRounding, Convergence};
use globalisation::LineSearch;

/// A factorisation of the step is reused for another iteration if the last iteration reduced the error by this factor \[–\].
const CHORD_CONTRACTION: f64 = 0.2;
/// Relative error of a direction at a state whose forces are already below the tolerance \[–\].
const BELOW: f64 = 0.01;

impl NonlinearSolver {
    /// Iterates from `next.x` and `next.lambda` (the initial guess) to equilibrium at `next.t`; computes x, v, a and λ of `next`, and advances its
    /// history, which is that of the last state, to the end of the step. On failure the content of `next` is unspecified.
    pub fn solve(&mut self, step: &Step, next: &mut State) -> Result<Solution, Failure> {
        if uses_corrections(self, step) {
            let mut trial = next.clone();
            if let Some(solution) = correct_repeatedly(self, step, &mut trial) {
                *next = trial;
                return Ok(solution);
            }
        }
        self.has_reused_factor = false;
        let targets = step.targets(next);
        let mut convergence = Convergence::new(&self.settings, step.integrator, AtRounding::IterateOnceMore);
        self.equations.begin(step, &targets, next)?;
        self.equations.evaluate(step, next, Want::Residual, None)?;
        let mut newton = NewtonIteration::new(self, step);
        loop {
            let increment = step.remaining(&targets, next);
            let error = newton.solver.equations.error(step.system, next, newton.solver.settings.tolerance);
            if !error.above_rounding.is_finite() {
                return Err(Failure::NotConverged { residual: error.above_rounding, node: 0 });
            }
            let iterations = newton.solution.iterations;
            newton.solver.report(step, next, iterations, error.above_rounding);
            if convergence.accepts(error, increment.is_none(), iterations) {
                let correction = newton.correction(next, error);
                if convergence.is_accurate(correction, error, newton.is_shifted, iterations) {
                    newton.solver.equations.advance_history(step, next)?;
                    newton.solver.linear.end_step();
                    return Ok(Solution { correction, ..newton.solution });
                }
            }
            if convergence.is_last(iterations) {
                return Err(newton.solver.not_converged(step.system, error.above_rounding));
            }
            newton.iterate(next, &targets, increment.as_deref(), error.above_rounding)?;
        }
    }
}

/// The iterations of Newton's method in one step.
struct NewtonIteration<'a> {
    solver: &'a mut NonlinearSolver,
    step: &'a Step<'a>,
    solution: Solution,
    /// Whether the lagged factor of an earlier step may be reused
    may_reuse_factor: bool,
    /// Schur complement of the factorisation of this step from which the last direction was computed, if it was
    schur: Option<Schur>,
    /// Whether the tangent of that factorisation was shifted for lack of a factor within the allowed memory
    is_shifted: bool,
    /// Error before the last iteration; 0 after a damped one, whose factorisation is not reused
    last_error: f64,
    remainder: RemainderUse,
}

/// Decides whether a direction uses the exact tangent, including the [remainder](crate::system::Assembled::remainder) that K leaves out.
///
/// K alone converges from far away, but only linearly where points slide. The remainder is used from the first iteration on that does not reduce the
/// error well. After an iteration with it that increases the error much, K alone is used for two directions.
struct RemainderUse {
    taken: bool,
    last_error: f64,
    rest: usize,
}

/// Growth of the error with the remainder after which K alone is used, and the number of directions for which it is.
const GROWN: (f64, usize) = (10.0, 2);

impl RemainderUse {
    fn new() -> Self {
        Self { taken: false, last_error: f64::INFINITY, rest: 0 }
    }

    /// Whether the remainder is used for the direction at a state with this error.
    fn is_taken(&mut self, error: f64) -> bool {
        if self.taken && error > GROWN.0 * self.last_error {
            self.rest = GROWN.1;
        }
        let is_slow = self.taken || error > CHORD_CONTRACTION * self.last_error;
        self.taken = self.rest == 0 && is_slow;
        self.rest = self.rest.saturating_sub(1);
        self.last_error = error;
        self.taken
    }
}

impl<'a> NewtonIteration<'a> {
    fn new(solver: &'a mut NonlinearSolver, step: &'a Step<'a>) -> Self {
        let (solution, sums) = (solver.no_solution_yet(), &solver.equations.sums);
        let may_reuse_factor =
            solver.linear.may_reuse_factor(&solver.settings, step.system, sums) && !step.integrator.is_linearised();
        let (last_error, remainder) = (f64::INFINITY, RemainderUse::new());
        Self { solver, step, solution, may_reuse_factor, schur: None, is_shifted: false, last_error, remainder }
    }

    /// The correction that a state with this error still needs, by the available factor and relative to the largest displacement; `None` without a
    /// factor, and in a linearised step, which is not solved for equilibrium.
    fn correction(&mut self, next: &State, error: ScaledError) -> Option<f64> {
        if self.step.integrator.is_linearised() {
            return None;
        }
        if error.exact == 0.0 {
            return Some(0.0);
        }
        let first = self.solution.iterations == 0;
        let NonlinearSolver { equations, linear, .. } = &mut *self.solver;
        let problem = LinearProblem { step: self.step, equations, state: next, increment: None };
        let direction = match &self.schur {
            Some(schur) => problem.solve(&mut linear.factor, schur).ok()?,
            None => linear.rough_direction(&problem, first)?,
        };
        let largest = |x: &[f64]| self.step.system.largest_displacement(x);
        Some(largest(&direction.x) / equations.visible(largest(&next.x)))
    }

    /// Makes one iteration from a state with this error.
    fn iterate(
        &mut self,
        next: &mut State,
        targets: &[(usize, f64)],
        increment: Option<&[f64]>,
        error: f64,
    ) -> Result<(), Failure> {
        self.solver.equations.limit.spend_iteration();
        let direction = self.direction(next, increment, error)?;
        let NonlinearSolver { settings, equations, linear, .. } = &mut *self.solver;
        let search = LineSearch { step: self.step, settings: *settings, targets };
        let full = search.advance(equations, &mut linear.factor, next, &direction)?;
        self.last_error = if full { error } else { 0.0 };
        self.solution.iterations += 1;
        self.solver.iterations += 1;
        Ok(())
    }

    /// Computes the direction with the lagged factor, with the factorisation of an earlier iteration of the step, or with a new one.
    fn direction(
        &mut self,
        next: &mut State,
        increment: Option<&[f64]>,
        error: f64,
    ) -> Result<NewtonDirection, Failure> {
        let (step, first) = (self.step, self.solution.iterations == 0);
        let takes_remainder = self.remainder.is_taken(error);
        let NonlinearSolver { settings, equations, linear, has_reused_factor, .. } = &mut *self.solver;
        let linearise = |equations: &mut Equations, next: &mut State| {
            equations.linearise(step, next, increment)?;
            if !takes_remainder {
                equations.sums.remainder.entries.clear();
            }
            Ok::<_, Failure>(())
        };
        if self.may_reuse_factor {
            linearise(equations, next)?;
            let problem = LinearProblem { step, equations, state: next, increment };
            // Below the tolerance, it is the displacements that are not accurate yet
            let tolerance = if error > settings.tolerance { settings.tolerance } else { BELOW * error };
            let found = linear.direction_by_lagged_factor(&problem, tolerance, error, first);
            if let Some(direction) = found {
                (*has_reused_factor, self.schur, self.is_shifted) = (true, None, false);
                return Ok(direction);
            }
        }
        let contracts = error < CHORD_CONTRACTION * self.last_error;
        let may_be_chord = settings.reuse_factor && !self.may_reuse_factor && increment.is_none();
        // The remainder changes with every state
        let is_chord = may_be_chord && contracts && equations.sums.remainder.is_empty();
        let schur = match self.schur.take().filter(|_| is_chord) {
            Some(schur) => {
                *has_reused_factor = true;
                schur
            }
            None => {
                if !self.may_reuse_factor {
                    linearise(equations, next)?;
                }
                let shifted = linear.shifted;
                let schur = linear.factorise(step, next, equations, self.may_reuse_factor, &mut self.solution)?;
                self.is_shifted = linear.is_shifted_since(shifted);
                schur
            }
        };
        let problem = LinearProblem { step, equations, state: next, increment };
        let mut direction = problem.solve(&mut linear.factor, &schur)?;
        self.schur = Some(schur);
        if !equations.sums.remainder.is_empty() && !descends(step, equations, &direction) {
            equations.sums.remainder.entries.clear();
            let schur = linear.schur(step.system, &equations.sums)?;
            direction = LinearProblem { step, equations, state: next, increment }.solve(&mut linear.factor, &schur)?;
            self.schur = Some(schur);
        }
        Ok(direction)
    }
}

/// Whether the direction is a descent direction, which a line search can follow.
fn descends(step: &Step, equations: &Equations, direction: &NewtonDirection) -> bool {
    let dofs = &step.system.dofs;
    let moving = dofs.free.iter().filter(|dof| **dof < dofs.displacements).map(|dof| *dof as usize);
    moving.map(|dof| equations.sums.r[dof] * direction.x[dof]).sum::<f64>() < 0.0
}
