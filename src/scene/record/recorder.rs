//! Recorders: the quantities that a run writes into its table at every accepted step, one value per column.

use super::features::Features;
use crate::scene::body::Body;
use crate::system::{At, Gradient, State};

/// Energies since the start \[J\]: stored and kinetic at the state, dissipated energy and work along the path.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Energies {
    pub elastic: f64,
    pub kinetic: f64,
    pub dissipated: f64,
    pub work: f64,
}

/// An accepted state with the quantities known there.
pub struct Moment<'a> {
    pub body: &'a Body,
    pub state: &'a State,
    /// The step that led to the state; `None` at the start of a run
    pub step: Option<&'a At<'a>>,
    /// Residual \[3 × nodes\]: at prescribed dofs the reaction \[N\]
    pub residual: &'a [f64],
    pub energies: Energies,
    /// Memory of the recorder, updated with this state: [`Recorder::remember`]
    pub memory: &'a [f64],
}

/// The quantity by which runs of one scene are compared if a study names none.
#[derive(Clone, Debug, PartialEq)]
pub struct Headline {
    /// Recorded column
    pub column: String,
    pub label: &'static str,
    pub symbol: &'static str,
    pub unit: &'static str,
}

/// Columns of the table of a run.
///
/// ```
/// use durometer::scene::{Moment, Recorder};
///
/// /// Largest displacement in x.
/// struct Reach;
///
/// impl Recorder for Reach {
///     fn columns(&self) -> Vec<String> {
///         vec!["reach_m".into()]
///     }
///
///     fn record(&self, now: &Moment) -> Vec<f64> {
///         let nodes = now.body.mesh.points.len();
///         vec![(0..nodes).map(|k| now.state.x[3 * k]).fold(0.0, f64::max)]
///     }
/// }
/// ```
pub trait Recorder: Send + Sync {
    /// Names of the columns, with the unit at the end.
    fn columns(&self) -> Vec<String>;

    /// Values of the columns, in SI except for angles in degrees.
    fn record(&self, now: &Moment) -> Vec<f64>;

    /// The memory that the recorder keeps from one accepted state to the next, before the first one; empty for a function of the state. It is a part of saved
    /// states.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Updates the memory with an accepted state.
    fn remember(&self, _: &Body, _: &State, _memory: &mut [f64]) {}

    /// The memory at a state for which these columns were recorded, as far as [`Recorder::gradients`] needs it.
    fn memory_at(&self, body: &Body, state: &State, _recorded: &[Option<f64>]) -> Vec<f64> {
        let mut memory = self.memory();
        self.remember(body, state, &mut memory);
        memory
    }

    /// Gradients of the columns at a state with which the memory has been updated; `None` for a column that has no derivative there. Empty if the recorder is
    /// not differentiable.
    fn gradients(&self, _: &Body, _: &State, _memory: &[f64]) -> Vec<Option<Gradient>> {
        Vec::new()
    }

    /// Whether [`Recorder::gradients`] returns gradients.
    fn is_differentiable(&self) -> bool {
        false
    }

    /// The columns as functions of polynomials of the displacement, if they have this form.
    fn features(&self) -> Option<Features> {
        None
    }

    /// Values of these polynomials at displacement x.
    fn feature_values(&self, _: &Body, _x: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
