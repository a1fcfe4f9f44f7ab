//! Steps by arc length: the path of equilibria is followed from the start of a span until the loads are those of its end.

pub(super) mod limit_points;
pub(super) mod path;

use super::diagnosis::diagnose_path;
use super::step_solver::StepSolver;
use super::step_strategy::{SolvedStep, Stability, StepOutcome, StepStrategy};
use super::{Failure, Solution, Status, TimeSpan, TurningPoint};
use crate::system::State;
use path::PathTracer;

/// Steps of given length along the path, at most `max_steps` of them.
pub(super) struct ArcLengthSteps<'a> {
    span: TimeSpan,
    max_steps: usize,
    tracer: Option<PathTracer<'a>>,
    taken: usize,
    /// Number of cuts of the current step
    cuts: u32,
    /// Time of the largest loads so far at which the path turned \[s\]
    limit: Option<f64>,
    done: bool,
}

impl ArcLengthSteps<'_> {
    pub fn new(span: TimeSpan, max_steps: usize) -> Self {
        Self { span, max_steps, tracer: None, taken: 0, cuts: 0, limit: None, done: false }
    }

    /// The status if all steps are used up before the end of the span is reached.
    fn exhausted(&self, t: f64) -> Status {
        match self.limit {
            Some(limit) => Status::LimitPoint { t, limit },
            None => Status::StepTooSmall { t, why: Failure::MaxSteps, by_force: false },
        }
    }
}

impl<'a> StepStrategy<'a> for ArcLengthSteps<'a> {
    fn begin(&mut self, steps: &mut StepSolver<'a>, state: &State, _: f64) -> Result<(), Status> {
        let tracer = PathTracer::new(&mut steps.solver, steps.system, state, self.span.end, self.span.dt);
        match tracer {
            Ok(tracer) => self.tracer = Some(tracer),
            Err(why) => return Err(diagnose_path(steps, self.span, state, why)),
        }
        Ok(())
    }

    fn step(&mut self, steps: &mut StepSolver<'a>, state: &State) -> StepOutcome {
        let tracer = self.tracer.as_mut().expect("begin makes it");
        if self.taken == self.max_steps {
            let is_unloaded = tracer.is_unloaded(&mut steps.solver);
            let unloaded = || Status::StepTooSmall { t: state.t, why: Failure::Unloaded, by_force: false };
            return StepOutcome::Failed(if is_unloaded { unloaded() } else { self.exhausted(state.t) });
        }
        let point = match tracer.step(&mut steps.solver) {
            Ok(point) => point,
            Err(why) if why.is_of_memory() || self.cuts == steps.settings.cuts => {
                return StepOutcome::Failed(diagnose_path(steps, self.span, state, why));
            }
            Err(_) => {
                self.cuts += 1;
                tracer.cut();
                return StepOutcome::Cut;
            }
        };
        (self.cuts, self.taken) = (0, self.taken + 1);
        if point.state.t < self.span.start && self.span.start > 0.0 {
            // Smaller loads are those of the stage before
            let limit = self.limit.unwrap_or(state.t);
            return StepOutcome::Failed(Status::LimitPoint { t: state.t, limit });
        }
        StepOutcome::Solved(Box::new(SolvedStep {
            next: point.state,
            solution: point.solution,
            on_grid: true,
            coarse: false,
        }))
    }

    fn accepted(
        &mut self,
        steps: &mut StepSolver<'a>,
        _: &State,
        now: &State,
        solution: &Solution,
    ) -> (Stability, Option<TurningPoint>) {
        let tracer = self.tracer.as_ref().expect("begin makes it");
        let turn = tracer.turning_point(&mut steps.solver);
        if let Some(turn) = &turn {
            self.limit = Some(self.limit.map_or(turn.t, |known: f64| known.max(turn.t)));
        }
        self.done = now.t == self.span.end;
        (solution.unstable_modes.into(), turn)
    }

    fn is_done(&self) -> bool {
        self.done
    }

    fn ignores_grid(&self) -> bool {
        true
    }
}
