//! Options of a run: its start, the controller that sets its signals, callbacks that follow it, and the states that it saves.

use super::checkpoint::Checkpoint;
use crate::scene::control::Controller;
use crate::scene::sensitivity::columns::SensitivityRecorder;
use crate::solve::OnIteration;
use crate::system::State;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Time of the last accepted state \[s\]
    pub t: f64,
    /// End of the last stage \[s\]
    pub end: f64,
}

/// Receives a saved state with its label.
pub type OnSave<'a> = dyn FnMut(&Checkpoint, &str) + 'a;
/// Receives the progress after each accepted step; returns `false` to stop the run.
pub type OnProgress<'a> = dyn FnMut(Progress) -> bool + 'a;
/// Receives each state on the time grid, including the first one.
pub type OnState<'a> = dyn FnMut(&State) + 'a;

/// Receives an amount of memory \[bytes\]; returns `false` to stop the run.
pub type OnSized<'a> = dyn FnMut(u64) -> bool + 'a;

/// Receives each recorded row as it is recorded, including the first one; returns `false` to stop the run.
pub type OnRow<'a> = dyn FnMut(&[f64]) -> bool + 'a;
/// Label of the states that are saved periodically.
pub const PARTIAL: &str = "partial";

/// Options of [`Scene::run_with`](crate::scene::Scene::run_with); a plain run needs none of them.
#[derive(Default)]
pub struct RunOptions<'a> {
    pub on_progress: Option<&'a mut OnProgress<'a>>,
    pub on_state: Option<&'a mut OnState<'a>>,
    /// Receives the iterations of Newton's method in the steps that it solves
    pub on_iteration: Option<OnIteration>,
    /// Receives the memory that the linear systems will need \[bytes\], before the first step; returns `false` to stop
    pub on_sized: Option<&'a mut OnSized<'a>>,
    /// Flag that stops the run, also within a step
    pub stop: Option<Arc<AtomicBool>>,
    pub on_row: Option<&'a mut OnRow<'a>>,
    /// Largest number of iterations, including those of failed steps, after which the run is interrupted
    pub most_iterations: Option<usize>,
    /// Whether to skip the search for the reason why no step is possible, which a search over many runs does not need
    pub undiagnosed: bool,
    /// Saved state of this scene from which to continue; title, numerics, output and comparisons may differ
    pub restart: Option<Checkpoint>,
    pub controller: Option<&'a mut (dyn Controller + 'a)>,
    /// Whether to continue from a saved state even with a controller different from the one that has set the signals so far
    pub other_controller: bool,
    /// Computes the derivatives of the recorded rows in the same pass; not together with `restart`
    pub sensitivities: Option<SensitivityRecorder<'a>>,
    /// Times \[s\] at which a state is saved: at the first grid point that is not before the time. Saved states go to `on_save`, or are otherwise kept in
    /// [`Run::saved`](crate::scene::Run::saved)
    pub save_at: Vec<f64>,
    /// Whether to save the last state too; for a run that ends between two grid points, that of the last point
    pub save_end: bool,
    /// Period in wall time at which a state is saved, with the label [`PARTIAL`]
    pub save_every: Option<Duration>,
    /// Receives the saved states, with distinct labels such as `0.5s` and `end`. States that an event or a controller asks for are saved only if this or one
    /// of the three options above is set
    pub on_save: Option<&'a mut OnSave<'a>>,
}

/// A saved state with a label that distinguishes it from others, such as `0.5s` or `end`.
pub type Saved = (String, Checkpoint);

impl RunOptions<'_> {
    /// Whether states are saved. For a run that is only followed no state is copied.
    pub(super) fn saves_states(&self) -> bool {
        self.on_save.is_some() || self.save_end || self.save_every.is_some() || !self.save_at.is_empty()
    }

    /// Whether the state at `t` \[s\] is to be saved; times that have passed are removed.
    pub(super) fn is_due(&mut self, t: f64) -> bool {
        let reached = |at: &f64| t >= at - 1e-9 * at.abs();
        let due = self.save_at.iter().any(reached);
        self.save_at.retain(|at| !reached(at));
        due
    }

    /// Passes a state to the receiver, or keeps it if there is none; of periodically saved states only the last one is kept.
    pub(in crate::scene) fn save(&mut self, checkpoint: &Checkpoint, label: &str, kept: &mut Vec<Saved>) {
        match &mut self.on_save {
            Some(on_save) => on_save(checkpoint, label),
            None => {
                kept.retain(|(known, _)| known != label);
                kept.push((label.into(), checkpoint.clone()));
            }
        }
    }
}
