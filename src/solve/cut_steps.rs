//! Nominal steps, which are cut if they do not converge or if their time error is too large, and doubled again later. A cut halves the step;
//! [`StepSettings::cuts`](super::StepSettings::cuts) limits the number of cuts.

use super::arc_length::limit_points::jumped;
use super::diagnosis::{diagnose, pushes_unheld_body};
use super::step_settings::{MOST_CUTS, StepSettings};
use super::step_solver::StepSolver;
use super::step_strategy::{SolvedStep, Stability, StepOutcome, StepStrategy};
use super::{Failure, Solution, Status, Step, TimeSpan, TurningPoint};
use crate::system::State;

/// Share of the allowed time error at which the next step aims.
const SAFE: f64 = 0.8;
/// Smallest length of a part of a step, in units of the rounding of the time, ε t.
const RESOLVED: f64 = 16.0;

/// Steps of length (nominal step)/2^cuts, with as many cuts as convergence and time error require.
pub(super) struct CutSteps {
    span: TimeSpan,
    /// Current number of cuts of the nominal step
    cuts: u32,
    /// Number of completed parts, of 2^cuts, of the nominal step
    done: u64,
    /// Start and end of the nominal step \[s\]
    origin: f64,
    goal: f64,
    /// Time error of the last step relative to the allowed one
    excess: f64,
}

impl CutSteps {
    pub fn new(span: TimeSpan, cuts: u32) -> Self {
        Self { span, cuts, done: 0, origin: 0.0, goal: 0.0, excess: 0.0 }
    }

    /// Largest number of cuts of the current nominal step, such that its parts are resolved by the rounding of the time.
    fn most_cuts(&self, settings: &StepSettings) -> u32 {
        let rounding = RESOLVED * f64::EPSILON * self.goal.abs();
        let resolved = ((self.goal - self.origin) / rounding).log2().max(0.0) as u32;
        settings.cuts.min(MOST_CUTS).min(resolved)
    }

    /// Cuts a step that did not converge, or fails with the reason.
    fn cut(&mut self, steps: &mut StepSolver, state: &State, t: f64, why: Failure) -> StepOutcome {
        if why.is_of_memory() {
            return StepOutcome::Failed(Status::stopped(state.t, why, false));
        }
        let first = self.cuts == 0 && self.done == 0;
        if first
            && steps.settings.diagnosis
            && let Some(status) = pushes_unheld_body(steps, self.span.integrator, state, self.goal)
        {
            return StepOutcome::Failed(status);
        }
        if self.cuts >= self.most_cuts(&steps.settings) {
            return StepOutcome::Failed(diagnose(steps, self.span, state, t, why));
        }
        self.cuts += 1;
        self.done *= 2;
        StepOutcome::Cut
    }
}

impl<'a> StepStrategy<'a> for CutSteps {
    fn begin(&mut self, _: &mut StepSolver<'a>, state: &State, goal: f64) -> Result<(), Status> {
        (self.done, self.origin, self.goal) = (0, state.t, goal);
        Ok(())
    }

    fn step(&mut self, steps: &mut StepSolver<'a>, state: &State) -> StepOutcome {
        let (integrator, whole) = (self.span.integrator, 1u64 << self.cuts);
        let on_grid = self.done + 1 == whole;
        let part = || self.origin + (self.goal - self.origin) * (self.done + 1) as f64 / whole as f64;
        let t = if on_grid { self.goal } else { part() };
        let (next, solution) = match steps.solve(integrator, state, t) {
            Ok(solved) => solved,
            Err(why) => return self.cut(steps, state, t, why),
        };
        self.excess = steps.time_error(integrator, state, &next, solution.anew);
        let most = self.most_cuts(&steps.settings);
        // A NaN error is not within the bound
        let coarse = self.excess.is_nan() || self.excess > 1.0;
        if coarse && self.cuts < most {
            let more = (integrator.cuts_for(self.excess / SAFE).ceil() as u32).clamp(1, most - self.cuts);
            self.cuts += more;
            self.done <<= more;
            return StepOutcome::Repeat;
        }
        match jumped(steps, self.span, state, &next, &solution) {
            Some(status) => StepOutcome::Failed(status),
            None => StepOutcome::Solved(Box::new(SolvedStep { next, solution, on_grid, coarse })),
        }
    }

    /// The negative eigenvalues at the end of a static step are counted if its last tangent, which was formed before the end, had some, if it needed
    /// no tangent at all, and at the end of the stage.
    fn accepted(
        &mut self,
        steps: &mut StepSolver<'a>,
        past: &State,
        now: &State,
        solution: &Solution,
    ) -> (Stability, Option<TurningPoint>) {
        self.done += 1;
        let integrator = self.span.integrator;
        let last = self.goal == self.span.end && self.is_done();
        let mut modes = solution.unstable_modes;
        if integrator.is_static() && (modes.is_some_and(|n| n > 0) || solution.iterations == 0 || last) {
            let step = Step { system: steps.system, integrator, past, dt: now.t - past.t };
            modes = steps.solver.unstable_modes(&step, now, modes.is_some_and(|n| n > 0));
        }
        // Double the step again after two steps in a row, as far as the time error allows
        let mut allowed = integrator.cuts_for(SAFE / self.excess);
        while self.cuts > 0 && self.done.is_multiple_of(2) && allowed >= 1.0 {
            self.cuts -= 1;
            self.done /= 2;
            allowed -= 1.0;
        }
        (modes.into(), None)
    }

    fn is_done(&self) -> bool {
        self.done == 1u64 << self.cuts
    }

    fn cuts(&self) -> u32 {
        self.cuts
    }
}
