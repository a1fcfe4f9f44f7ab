//! How a run is steered: where it starts, who sets its signals, which states it leaves behind.

use super::control::Controller;
use super::course::Course;

/// Receives a state with its label.
pub type Save<'a> = dyn FnMut(&Course, &str) + 'a;

/// Nothing of it is needed for a plain run.
#[derive(Default)]
pub struct Steering<'a> {
    /// A saved state to go on from
    pub from: Option<Course>,
    pub controller: Option<&'a mut dyn Controller>,
    /// Times at which a state is saved: at the first point of the grid that is not before [s]
    pub at: Vec<f64>,
    /// Save the last state too; of a run that ends between two points of the grid, that of the last point
    pub at_end: bool,
    /// Receives the states, with what tells them apart: `0.5s`, `end`
    pub saved: Option<&'a mut Save<'a>>,
}

impl Steering<'_> {
    pub(super) fn wants_states(&self) -> bool {
        self.saved.is_some()
    }

    /// Hands the state over if it is time, or if an event asks for it.
    pub(super) fn save(&mut self, course: &Course, asked: bool) {
        let t = course.state.t;
        let due = self.at.iter().any(|at| t >= at - 1e-9 * at.abs());
        self.at.retain(|at| t < at - 1e-9 * at.abs());
        if let (Some(saved), true) = (&mut self.saved, due || asked) {
            saved(course, &format!("{t}s"));
        }
    }

    pub(super) fn save_end(&mut self, course: Option<&Course>) {
        if let (Some(saved), Some(course), true) = (&mut self.saved, course, self.at_end) {
            saved(course, "end");
        }
    }
}
