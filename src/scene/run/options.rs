//! Options of a run: its start, who sets its signals, who follows it, and the states it saves.

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
/// Receives the progress after each accepted step; returns false to stop the run.
pub type OnProgress<'a> = dyn FnMut(Progress) -> bool + 'a;
/// Receives each state on the time grid, the first one included.
pub type OnState<'a> = dyn FnMut(&State) + 'a;

/// Receives a size of memory \[bytes\]; returns false to stop the run.
pub type OnSized<'a> = dyn FnMut(u64) -> bool + 'a;

/// Receives each recorded row as it comes, the first one included; returns false to stop the run.
pub type OnRow<'a> = dyn FnMut(&[f64]) -> bool + 'a;
/// Label of the states that are saved again and again.
pub const PARTIAL: &str = "partial";

/// Options of [`Scene::run_with`](crate::scene::Scene::run_with); a plain run needs none of them.
#[derive(Default)]
pub struct RunOptions<'a> {
    pub on_progress: Option<&'a mut OnProgress<'a>>,
    pub on_state: Option<&'a mut OnState<'a>>,
    /// Receives the iterations of Newton's method, in the steps that it solves
    pub on_iteration: Option<OnIteration>,
    /// Gets the memory that the linear systems are going to take \[bytes\], before the first step; returns false to stop
    pub on_sized: Option<&'a mut OnSized<'a>>,
    /// Set to stop the run, also within a step
    pub stop: Option<Arc<AtomicBool>>,
    pub on_row: Option<&'a mut OnRow<'a>>,
    /// Do not look for the reason where no step is possible: a search over many runs does not read it
    pub undiagnosed: bool,
    /// A saved state of this scene to go on from; title, numerics, output and comparisons may be others
    pub restart: Option<Checkpoint>,
    pub controller: Option<&'a mut (dyn Controller + 'a)>,
    /// Go on from a saved state also under another controller than the one that has set the signals so far
    pub other_controller: bool,
    /// Computes the derivatives of the recorded rows in the same pass; not together with `restart`
    pub sensitivities: Option<SensitivityRecorder<'a>>,
    /// Times at which a state is saved: at the first point of the grid that is not before \[s\]. Saved states go to `on_save`, or else are kept in
    /// [`Run::saved`](crate::scene::Run::saved)
    pub save_at: Vec<f64>,
    /// Save the last state too; of a run that ends between two points of the grid, that of the last point
    pub save_end: bool,
    /// Wall time after which a state is saved, again and again, with the label [`PARTIAL`]
    pub save_every: Option<Duration>,
    /// Receives the saved states, with labels that tell them apart: `0.5s`, `end`. Those that an event or a controller asks for are saved only here,
    /// and where one of the three options above is set
    pub on_save: Option<&'a mut OnSave<'a>>,
}

/// A saved state with the label that tells it from others: `0.5s`, `end`.
pub type Saved = (String, Checkpoint);

impl RunOptions<'_> {
    /// Whether states are saved. Of a run that is only to be followed none are copied.
    pub(super) fn saves_states(&self) -> bool {
        self.on_save.is_some() || self.save_end || self.save_every.is_some() || !self.save_at.is_empty()
    }

    /// Whether the state at `t` \[s\] is to be saved; times that have passed are forgotten.
    pub(super) fn is_due(&mut self, t: f64) -> bool {
        let reached = |at: &f64| t >= at - 1e-9 * at.abs();
        let due = self.save_at.iter().any(reached);
        self.save_at.retain(|at| !reached(at));
        due
    }

    /// Hands a state out, or keeps it where nothing receives it; of those that are saved again and again the last one.
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
