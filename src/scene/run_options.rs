//! How a run is steered: where it starts, who sets its signals, which states it leaves behind.

use super::checkpoint::Checkpoint;
use super::control::Controller;

/// Receives a state with its label.
pub type Save<'a> = dyn FnMut(&Checkpoint, &str) + 'a;

/// Nothing of it is needed for a plain run.
#[derive(Default)]
pub struct RunOptions<'a> {
    /// A saved state to go on from
    pub from: Option<Checkpoint>,
    pub controller: Option<&'a mut dyn Controller>,
    /// Times at which a state is saved: at the first point of the grid that is not before \[s\]
    pub at: Vec<f64>,
    /// Save the last state too; of a run that ends between two points of the grid, that of the last point
    pub at_end: bool,
    /// Receives the states, with what tells them apart: `0.5s`, `end`
    pub saved: Option<&'a mut Save<'a>>,
}

impl RunOptions<'_> {
    pub(super) fn wants_states(&self) -> bool {
        self.saved.is_some()
    }

    /// Hands the state over if it is time, or if an event asks for it.
    pub(super) fn save(&mut self, checkpoint: &Checkpoint, asked: bool) {
        let t = checkpoint.state.t;
        let due = self.at.iter().any(|at| t >= at - 1e-9 * at.abs());
        self.at.retain(|at| t < at - 1e-9 * at.abs());
        if let (Some(saved), true) = (&mut self.saved, due || asked) {
            saved(checkpoint, &format!("{t}s"));
        }
    }

    pub(super) fn save_end(&mut self, checkpoint: Option<&Checkpoint>) {
        if let (Some(saved), Some(checkpoint), true) = (&mut self.saved, checkpoint, self.at_end) {
            saved(checkpoint, "end");
        }
    }
}
