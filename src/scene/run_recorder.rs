//! Follows a run of a scene: decides its inputs at the points of the time grid, and records rows, energies, cables, states.

use super::build::Scene;
use super::checkpoint::{Checkpoint, Snapshot};
use super::control::{ControlError, Opening, Orders};
use super::run_options::{Progress, RunOptions};
use crate::solve::{AcceptedStep, GridPoint, Status, Step, StepObserver, TimeSpan};
use crate::system::State;
use std::ops::ControlFlow;

/// The observer of a scene's run.
pub(super) struct RunRecorder<'a, 'o> {
    scene: &'a Scene,
    options: RunOptions<'o>,
    /// Records so far. Its state, position and memory are those of the last point of the grid that may be saved
    pub checkpoint: Checkpoint,
    /// The last point of the grid, for a run that ends between two; only where the end is saved
    last_point: Option<Checkpoint>,
    /// Error of a signal or of the controller, which ended the run
    pub failure: Option<ControlError>,
    /// Iterations since the last recorded row
    iterations: usize,
    /// Numbers that the recorders keep, at the last accepted state
    memory: Vec<f64>,
}

impl<'a, 'o> RunRecorder<'a, 'o> {
    /// Before the first step of a run, or of the rest of one. The state to start from is that of the checkpoint.
    pub fn new(scene: &'a Scene, mut options: RunOptions<'o>) -> Self {
        let restart = options.restart.take();
        let last_point = restart.clone().filter(|_| options.save_end);
        let restarted = restart.is_some();
        let (checkpoint, outcome) = restart.map_or_else(|| Checkpoint::new(scene), |checkpoint| (checkpoint, Ok(())));
        if let (Some(on_state), false) = (&mut options.on_state, restarted) {
            on_state(&checkpoint.state);
        }
        let mut failure = outcome.err();
        if let (Some(controller), None) = (&mut options.controller, &failure) {
            let (columns, signals) = (scene.columns(), scene.controls.controlled());
            let Checkpoint { state, control, .. } = &checkpoint;
            let opening = Opening { columns: &columns, signals: &signals, t: state.t, memory: &control.controller };
            failure = controller.begin(&opening).err();
        }
        let memory = checkpoint.memories.last().cloned().unwrap_or_default();
        Self { scene, options, checkpoint, last_point, failure, iterations: 0, memory }
    }

    /// After the last step: saves the end, and tells the controller.
    pub fn finish(mut self, status: &Status) -> (Checkpoint, RunOptions<'o>, Option<ControlError>) {
        if let Some(checkpoint) = self.last_point.take() {
            self.options.save(&checkpoint, "end");
        }
        if let (Some(controller), Some(row)) = (&mut self.options.controller, self.checkpoint.rows.last()) {
            controller.end(row, status.name());
        }
        (self.checkpoint, self.options, self.failure)
    }

    /// Events, the controller and the inputs up to the time `next`.
    fn decide(&mut self, state: &mut State, next: Option<f64>) -> Result<Orders, ControlError> {
        let Checkpoint { control, rows, .. } = &mut self.checkpoint;
        let row = rows.last().expect("the first row is the state at rest");
        self.scene.controls.decide(control, state, row, next, self.options.controller.as_deref_mut())
    }

    /// Takes the point of the grid over into the checkpoint, and saves it if it is due or `asked` for.
    fn save(&mut self, point: &GridPoint, state: &State, asked: bool) {
        self.checkpoint.state.clone_from(state);
        self.checkpoint.position = point.position;
        self.checkpoint.memory = (point.memory)();
        let due = self.options.is_due(state.t);
        if due || asked {
            self.options.save(&self.checkpoint, &format!("{}s", state.t));
        }
        self.last_point = self.options.save_end.then(|| self.checkpoint.clone());
    }

    fn record(&mut self, step: &AcceptedStep) {
        let AcceptedStep { integrator, past, now, sums, on_grid, .. } = *step;
        let (scene, Checkpoint { balance, rows, signals, memories, peak, .. }) = (self.scene, &mut self.checkpoint);
        let iterations = std::mem::take(&mut self.iterations);
        let step = Step { system: &scene.system, integrator, past, dt: now.t - past.t };
        let at = step.at(now);
        rows.push(scene.record(now, Some(&at), &sums.r, balance.energies, iterations, &self.memory));
        memories.push(self.memory.clone());
        signals.push(scene.signal_values(now));
        if let (Some(on_state), true) = (&mut self.options.on_state, on_grid) {
            on_state(now);
        }
        if scene.largest_displacement(&now.x) > scene.largest_displacement(&peak.x) {
            *peak = Snapshot { t: now.t, x: now.x.clone() };
        }
    }
}

impl StepObserver for RunRecorder<'_, '_> {
    fn span_begins(&mut self, span: &TimeSpan, state: &State) {
        if let Some(sensitivities) = &mut self.options.sensitivities {
            sensitivities.begin(span.integrator, state);
        }
    }

    fn grid_point(&mut self, point: &GridPoint, state: &mut State) -> ControlFlow<Status> {
        let orders = match self.decide(state, point.next) {
            Ok(orders) => orders,
            Err(why) => {
                self.failure = Some(why);
                return ControlFlow::Break(Status::Interrupted { t: state.t });
            }
        };
        if self.options.saves_states() {
            self.save(point, state, orders.save);
        }
        if orders.stop {
            return ControlFlow::Break(Status::Converged);
        }
        ControlFlow::Continue(())
    }

    fn accepted(&mut self, step: &AcceptedStep) -> ControlFlow<()> {
        let scene = self.scene;
        self.checkpoint.balance.add_step(&scene.system, step);
        self.checkpoint.cables.note(&scene.cables, step.now);
        scene.remember(step.now, &mut self.memory);
        // With steps of controlled error, each of them is a row.
        let recorded = step.on_grid || scene.spec.numerics.time_error.is_some() && !step.integrator.is_static();
        if let Some(sensitivities) = &mut self.options.sensitivities {
            sensitivities.step(step, &self.memory, recorded);
        }
        self.iterations += step.iterations;
        if recorded {
            self.record(step);
        }
        let end = scene.spans.last().map_or(0.0, |span| span.end);
        let progress = Progress { t: step.now.t, end };
        let go_on = self.options.on_progress.as_mut().is_none_or(|on_progress| on_progress(progress));
        if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}
