//! Follows a run of a scene: decides its inputs at the points of the time grid, and records rows, energies, cables, states.

use super::checkpoint::{Checkpoint, Snapshot};
use super::options::{OnRow, PARTIAL, Progress, RunOptions, Saved};
use crate::scene::build::Scene;
use crate::scene::control::{ControlError, ControllerRecord, Opening, Orders};
use crate::solve::{AcceptedStep, GridPoint, SpanStart, Status, Step, StepObserver};
use crate::system::State;
use std::ops::ControlFlow;
use std::time::Instant;

/// The observer of a scene's run.
pub(super) struct RunRecorder<'a, 'o> {
    scene: &'a Scene,
    options: RunOptions<'o>,
    /// Records so far. Its state, position and memory are those of the last grid point that can be saved
    pub checkpoint: Checkpoint,
    /// The last grid point, for a run that ends between two points; only if the end is saved
    last_point: Option<Checkpoint>,
    /// Saved states that no callback receives
    kept: Vec<Saved>,
    /// Whether states are saved
    saves: bool,
    /// Error of a signal or of the controller, which ended the run
    pub failure: Option<ControlError>,
    /// Column or signal whose value was not finite, which ended the run
    pub not_finite: Option<String>,
    /// Iterations since the last recorded row
    iterations: usize,
    /// Time at which a state was last saved periodically
    saved: Instant,
    /// Whether the receiver of the rows wants no more of them
    is_full: bool,
    /// Memory of the recorders at the last accepted state
    memory: Vec<f64>,
}

impl<'a, 'o> RunRecorder<'a, 'o> {
    /// A recorder before the first step of a run, or of the rest of one. The initial state is that of the checkpoint; `refused` ends the run there.
    pub fn new(scene: &'a Scene, mut options: RunOptions<'o>, refused: Option<ControlError>) -> Self {
        let restart = options.restart.take();
        let last_point = restart.clone().filter(|_| options.save_end);
        let restarted = restart.is_some();
        let (mut checkpoint, outcome) =
            restart.map_or_else(|| Checkpoint::new(scene), |checkpoint| (checkpoint, Ok(())));
        if let (Some(on_state), false) = (&mut options.on_state, restarted) {
            on_state(&checkpoint.state);
        }
        let mut failure = refused.or(outcome.err());
        // Such a row is not kept, not even the first one: no file contains values that are not finite
        let first = checkpoint.rows.last().zip(checkpoint.signals.last());
        let not_finite = first.and_then(|(row, signals)| not_finite(scene, row, signals));
        if not_finite.is_some() {
            [&mut checkpoint.rows, &mut checkpoint.signals, &mut checkpoint.memories]
                .into_iter()
                .for_each(|kept| drop(kept.pop()));
        }
        if let (Some(controller), None) = (&mut options.controller, &failure) {
            let (columns, signals) = (scene.columns(), scene.controls.controlled());
            let Checkpoint { state, control, .. } = &mut checkpoint;
            let is_last = |identity: &String| control.controllers.last().is_some_and(|last| last.identity == *identity);
            if let Some(identity) = controller.identity().filter(|identity| !is_last(identity)) {
                control.controllers.push(ControllerRecord { from_t_s: state.t, identity });
            }
            let opening = Opening { columns: &columns, signals: &signals, t: state.t, memory: &control.controller };
            failure = controller.begin(&opening).err();
        }
        let memory = checkpoint.memories.last().cloned().unwrap_or_default();
        let on_row = |on_row: &mut &mut OnRow| checkpoint.rows.iter().all(|row| on_row(row));
        let is_full = !options.on_row.as_mut().is_none_or(on_row);
        let (saves, kept, saved) = (options.saves_states(), vec![], Instant::now());
        let iterations = 0;
        Self {
            scene,
            options,
            checkpoint,
            last_point,
            kept,
            saves,
            failure,
            not_finite,
            iterations,
            saved,
            is_full,
            memory,
        }
    }

    /// Time of the last recorded row \[s\].
    pub fn last_time(&self) -> f64 {
        self.checkpoint.rows.last().map_or(0.0, |row| row[0])
    }

    /// Ends a run after its last step: saves the end, and tells the controller. Returns the records, the saved states, the options, and the error that ended
    /// the run.
    pub fn finish(mut self, status: &Status) -> (Checkpoint, Vec<Saved>, RunOptions<'o>, Option<ControlError>) {
        if let Some(checkpoint) = self.last_point.take() {
            self.options.save(&checkpoint, "end", &mut self.kept);
        }
        if let (Some(controller), Some(row)) = (&mut self.options.controller, self.checkpoint.rows.last()) {
            controller.end(row, status.name());
        }
        (self.checkpoint, self.kept, self.options, self.failure)
    }

    /// Decides events, the controller and the inputs up to the time `next`.
    fn decide(&mut self, state: &mut State, next: Option<f64>) -> Result<Orders, ControlError> {
        let Checkpoint { control, rows, .. } = &mut self.checkpoint;
        let row = rows.last().expect("the first row is the state at rest");
        self.scene.controls.decide(control, state, row, next, self.options.controller.as_deref_mut())
    }

    /// Stores the grid point in the checkpoint, and saves it if it is due or `asked` for.
    fn save(&mut self, point: &GridPoint, state: &State, asked: bool) {
        self.checkpoint.state.clone_from(state);
        self.checkpoint.position = point.position;
        self.checkpoint.memory = (point.memory)();
        let due = self.options.is_due(state.t);
        if due || asked {
            let before = self.checkpoint.rows.iter().rev().map(|row| row[0]).find(|t| *t < state.t);
            let label = format!("{}s", time_name(state.t, state.t - before.unwrap_or(0.0)));
            self.options.save(&self.checkpoint, &label, &mut self.kept);
        }
        if self.options.save_every.is_some_and(|every| self.saved.elapsed() >= every) {
            self.options.save(&self.checkpoint, PARTIAL, &mut self.kept);
            self.saved = Instant::now();
        }
        self.last_point = self.options.save_end.then(|| self.checkpoint.clone());
    }

    fn record(&mut self, accepted: &AcceptedStep) {
        let AcceptedStep { integrator, past, now, sums, on_grid, .. } = *accepted;
        let (scene, Checkpoint { balance, rows, signals, memories, peak, .. }) = (self.scene, &mut self.checkpoint);
        let iterations = std::mem::take(&mut self.iterations);
        let step = Step { system: &scene.system, integrator, past, dt: now.t - past.t };
        let at = step.at(now);
        let row = scene.record(now, Some(&at), &sums.r, balance.energies, iterations, &self.memory);
        let values = scene.signal_values(now);
        self.not_finite = not_finite(scene, &row, &values);
        if self.not_finite.is_some() {
            return;
        }
        self.is_full = self.options.on_row.as_mut().is_some_and(|on_row| !on_row(&row));
        rows.push(row);
        if let Some(sensitivities) = &mut self.options.sensitivities {
            sensitivities.recorded(rows, accepted, &self.memory);
        }
        memories.push(self.memory.clone());
        signals.push(values);
        if let (Some(on_state), true) = (&mut self.options.on_state, on_grid) {
            on_state(now);
        }
        if scene.largest_squared_displacement(&now.x) > scene.largest_squared_displacement(&peak.x) {
            *peak = Snapshot { t: now.t, x: now.x.clone() };
        }
    }
}

/// The time in the name of a state: the shortest decimal within a millionth of the step before it, so that two grid points have different names, and rounding
/// is not visible.
fn time_name(t: f64, step: f64) -> String {
    let is_near = |name: &String| name.parse::<f64>().is_ok_and(|named| (named - t).abs() <= 1e-6 * step);
    (0..=17).map(|decimals| format!("{t:.decimals$}")).find(is_near).unwrap_or_else(|| t.to_string())
}

/// The first column, or otherwise the first signal, whose value is not finite.
fn not_finite(scene: &Scene, row: &[f64], signals: &[f64]) -> Option<String> {
    let faulty = |values: &[f64]| values.iter().position(|value| !value.is_finite());
    faulty(row).map(|k| scene.columns().swap_remove(k)).or_else(|| Some(scene.signals[faulty(signals)?].name.clone()))
}

impl StepObserver for RunRecorder<'_, '_> {
    fn span_begins(&mut self, start: &SpanStart, state: &State) {
        let balance = &mut self.checkpoint.balance;
        balance.growth.begin(balance.energies);
        if let Some(sensitivities) = &mut self.options.sensitivities {
            sensitivities.begin(start, state);
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
        if self.saves {
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
        // With error-controlled steps, each of them is a row.
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
        if self.not_finite.is_some() || self.is_full {
            return ControlFlow::Break(());
        }
        let go_on = self.options.on_progress.as_mut().is_none_or(|on_progress| on_progress(progress));
        if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_times_are_short_and_tell_them_apart() {
        let (product, sum) = (41.0 * 0.005, (0..41).fold(0.0, |t, _| t + 0.005));
        for rounded in [product, sum] {
            assert_ne!(rounded.to_string(), "0.205", "it carries the rounding of its steps");
            assert_eq!(time_name(rounded, 0.005), "0.205");
        }
        assert_eq!([time_name(0.0, 0.0), time_name(2.0, 0.1), time_name(1.25e-7, 2.5e-8)], ["0", "2", "0.000000125"]);
        let (early, late) = (1000.0, 1000.0 + 1e-7);
        assert_ne!(time_name(early, 1e-7), time_name(late, 1e-7));
        // Steps that are lost in the rounding of the time
        assert_eq!(time_name(0.1, 1e-17), "0.1");
    }
}
