//! The loop over the spans of a run, the points of their time grids, and the steps in between. A step that did not converge is never accepted.

use super::arc_length::ArcLengthSteps;
use super::contact::corrected_steps::CorrectedSteps;
use super::cut_steps::CutSteps;
use super::diagnosis;
use super::limit::Reached;
use super::observer::{AcceptedStep, GridPoint, GridPosition, StepObserver};
use super::span_start::SpanStart;
use super::start::initial_acceleration_by;
use super::step_settings::StepSettings;
use super::step_solver::StepSolver;
use super::step_strategy::{StepOutcome, StepStrategy};
use super::{DriverMemory, Failure, Findings, Integrator, NonlinearSolver, Status, TimeSpan, Totals};
use crate::math::threads;
use crate::system::{State, System};
use std::ops::ControlFlow;

/// Advances a state in time, span by span.
pub struct Driver<'a> {
    pub steps: StepSolver<'a>,
    pub totals: Totals,
    pub findings: Findings,
    /// Current number of cuts of the nominal step
    cuts: u32,
}

impl<'a> Driver<'a> {
    pub fn new(system: &'a System, solver: NonlinearSolver, settings: StepSettings) -> Self {
        let steps = StepSolver::new(system, solver, settings);
        Self { steps, totals: Totals::default(), findings: Findings::default(), cuts: 0 }
    }

    /// Continues where another driver stopped.
    pub fn resume(&mut self, memory: DriverMemory) {
        let DriverMemory { prediction, cuts, stiffness, lagged_factor, totals } = memory;
        (self.steps.prediction, self.cuts, self.totals) = (prediction, cuts, totals);
        self.steps.solver.equations.stiffness = stiffness;
        self.steps.solver.linear.resume(lagged_factor, self.steps.system);
    }

    /// Runs one span from `state` to its end.
    pub fn run(&mut self, span: TimeSpan, state: &mut State, observer: &mut dyn StepObserver) -> Status {
        self.run_spans(&[span], None, state, observer)
    }

    /// Runs the spans from `state`. After a restart it starts at the position `from` in their grids, where no decision is repeated.
    pub fn run_spans(
        &mut self,
        spans: &[TimeSpan],
        from: Option<GridPosition>,
        state: &mut State,
        observer: &mut dyn StepObserver,
    ) -> Status {
        match self.all_spans(spans, from, state, observer) {
            ControlFlow::Continue(()) => Status::Converged,
            ControlFlow::Break(status) => status,
        }
    }

    fn all_spans(
        &mut self,
        spans: &[TimeSpan],
        from: Option<GridPosition>,
        state: &mut State,
        observer: &mut dyn StepObserver,
    ) -> ControlFlow<Status> {
        let mut resumed = from.is_some();
        let mut position = from.unwrap_or_default();
        while let Some(span) = spans.get(position.span) {
            if position.step == 0 && !resumed {
                let start = SpanStart { span, before: position.span.checked_sub(1).map(|k| &spans[k]) };
                self.begin(&start, state)?;
                observer.span_begins(&start, state);
            }
            let mut strategy = strategy(span, self.cuts);
            while position.step < span.steps() {
                let goal = span.point(position.step + 1);
                if !std::mem::take(&mut resumed) {
                    let point = GridPoint { position, next: Some(goal), memory: &|| self.memory() };
                    observer.grid_point(&point, state)?;
                }
                self.advance(span, strategy.as_mut(), state, goal, observer)?;
                position.step = if strategy.ignores_grid() { span.steps() } else { position.step + 1 };
            }
            position = GridPosition { span: position.span + 1, step: 0 };
        }
        if resumed {
            return ControlFlow::Continue(());
        }
        observer.grid_point(&GridPoint { position, next: None, memory: &|| self.memory() }, state)
    }

    /// Prepares `state` as the first state of a span.
    fn begin(&mut self, start: &SpanStart, state: &mut State) -> ControlFlow<Status> {
        if start.goes_on() {
            return ControlFlow::Continue(());
        }
        let (span, system) = (start.span, self.steps.system);
        start.give(system, &start.given_rates(system, state.clock()), state);
        if span.integrator.needs_initial_acceleration() {
            match initial_acceleration_by(self.steps.solver.linear.method.clone(), system, state) {
                Ok(a) => state.a = a,
                Err(why) if why.is_of_memory() => return ControlFlow::Break(Status::stopped(state.t, why, false)),
                Err(why @ Failure::Eval(_)) => {
                    return ControlFlow::Break(diagnosis::stopped(system, state, state.t, why));
                }
                Err(why) => return ControlFlow::Break(Status::StepTooSmall { t: state.t, why, by_force: false }),
            }
        }
        span.integrator.begin(state);
        self.cuts = 0;
        self.steps.prediction.recent.clear();
        self.steps.prediction.remember(state);
        ControlFlow::Continue(())
    }

    /// The status of a run that has reached its limit; `None` if it has not.
    fn reached(&self, state: &State) -> Option<Status> {
        let reached = self.steps.solver.equations.limit.reached()?;
        Some(match reached {
            Reached::Stopped => Status::Interrupted { t: state.t },
            Reached::TimeOver => Status::TimeBudget { t: state.t },
        })
    }

    /// Advances from `state` to `goal`, the next point of the time grid.
    fn advance(
        &mut self,
        span: &TimeSpan,
        strategy: &mut dyn StepStrategy<'a>,
        state: &mut State,
        goal: f64,
        observer: &mut dyn StepObserver,
    ) -> ControlFlow<Status> {
        if let Err(status) = strategy.begin(&mut self.steps, state, goal) {
            return ControlFlow::Break(self.reached(state).unwrap_or(status));
        }
        while !strategy.is_done() {
            if let Some(status) = self.reached(state) {
                return ControlFlow::Break(status);
            }
            let solved = match threads::inside(|| strategy.step(&mut self.steps, state)) {
                StepOutcome::Solved(solved) => *solved,
                StepOutcome::Cut => {
                    self.totals.cuts += 1;
                    continue;
                }
                StepOutcome::Repeat => {
                    self.totals.repeated += 1;
                    continue;
                }
                StepOutcome::Failed(status) => return ControlFlow::Break(self.reached(state).unwrap_or(status)),
            };
            let (integrator, solution) = (span.integrator, solved.solution);
            let mut past = std::mem::replace(state, solved.next);
            if solution.anew {
                integrator.forget(&mut past);
            }
            self.totals.add(&solution);
            self.totals.in_time += usize::from(!integrator.is_static());
            self.totals.coarse += usize::from(solved.coarse);
            self.steps.prediction.remember(state);
            let (iterations, sums, on_grid) = (solution.iterations, &self.steps.solver.equations.sums, solved.on_grid);
            let step = AcceptedStep { integrator, past: &past, now: state, iterations, sums, on_grid };
            if observer.accepted(&step).is_break() {
                return ControlFlow::Break(Status::Interrupted { t: state.t });
            }
            let (stability, turning_point) = strategy.accepted(&mut self.steps, &past, state, &solution);
            self.findings.note(&mut self.totals, integrator.is_static(), state.t, stability);
            self.findings.turning_points.extend(turning_point);
        }
        self.cuts = strategy.cuts();
        ControlFlow::Continue(())
    }

    /// The data that the next step needs in addition to the state to give bit-identical results.
    fn memory(&self) -> DriverMemory {
        DriverMemory {
            prediction: self.steps.prediction.clone(),
            cuts: self.cuts,
            stiffness: self.steps.solver.equations.stiffness,
            lagged_factor: self.steps.solver.linear.lagged_factor_record(),
            totals: self.totals,
        }
    }
}

/// The step strategy of a span, whose nominal step already has `cuts` cuts.
fn strategy<'a>(span: &TimeSpan, cuts: u32) -> Box<dyn StepStrategy<'a> + 'a> {
    match span.integrator {
        Integrator::ArcLength { max_steps } => Box::new(ArcLengthSteps::new(*span, max_steps)),
        Integrator::FreeMotion { integration_steps } => Box::new(CorrectedSteps::new(*span, integration_steps)),
        _ => Box::new(CutSteps::new(*span, cuts)),
    }
}
