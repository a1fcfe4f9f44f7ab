//! Steps of free motion, each with one contact correction, as in simulators that search for contact between their steps.
//!
//! For comparison only: at the end of a step neither equilibrium nor distances hold to a tolerance, and planes are as old as the search, so that the
//! error is of first order in both step lengths, and nothing warns of it. There is nothing to cut, so that a step that fails ends the run.

use super::correction::{ContactPlanes, move_and_correct};
use crate::solve::diagnosis::stopped;
use crate::solve::step_solver::StepSolver;
use crate::solve::step_strategy::{SolvedStep, Stability, StepOutcome, StepStrategy};
use crate::solve::{Integrator, Solution, Status, Step, TimeSpan, TurningPoint};
use crate::system::State;

/// Steps with one correction each, a given number of them after each search for contact.
pub(in crate::solve) struct CorrectedSteps<'a> {
    integrator: Integrator,
    count: usize,
    /// Number of steps since the search
    done: usize,
    /// Start and end of the step of the time grid \[s\]
    origin: f64,
    goal: f64,
    planes: ContactPlanes<'a>,
}

impl CorrectedSteps<'_> {
    pub fn new(span: TimeSpan, count: usize) -> Self {
        let planes = ContactPlanes::default();
        Self { integrator: span.integrator, count, done: 0, origin: 0.0, goal: 0.0, planes }
    }
}

impl<'a> StepStrategy<'a> for CorrectedSteps<'a> {
    fn begin(&mut self, steps: &mut StepSolver<'a>, state: &State, goal: f64) -> Result<(), Status> {
        (self.done, self.origin, self.goal) = (0, state.t, goal);
        let dt = (goal - state.t) / self.count as f64;
        self.planes = ContactPlanes::new(&mut steps.solver, steps.system, [&state.x, &state.x], dt, 0.0);
        Ok(())
    }

    fn step(&mut self, steps: &mut StepSolver<'a>, state: &State) -> StepOutcome {
        let k = self.done + 1;
        let on_grid = k == self.count;
        let t =
            if on_grid { self.goal } else { self.origin + (self.goal - self.origin) * k as f64 / self.count as f64 };
        let step = Step { system: steps.system, integrator: self.integrator, past: state, dt: t - state.t };
        let mut next = State { t, ..state.clone() };
        match move_and_correct(&mut steps.solver, &step, &self.planes, &mut next) {
            Err(why) => StepOutcome::Failed(stopped(steps.system, state, t, why)),
            Ok(solution) => {
                self.integrator.finish(state, step.dt, &mut next);
                StepOutcome::Solved(Box::new(SolvedStep { next, solution, on_grid, coarse: false }))
            }
        }
    }

    fn accepted(
        &mut self,
        _: &mut StepSolver<'a>,
        _: &State,
        _: &State,
        _: &Solution,
    ) -> (Stability, Option<TurningPoint>) {
        self.done += 1;
        (Stability::NotJudged, None)
    }

    fn is_done(&self) -> bool {
        self.done == self.count
    }
}
