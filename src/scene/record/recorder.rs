//! Recorders: what a run writes into its table at every accepted step, one value per column.

use super::features::Features;
use crate::scene::body::Body;
use crate::system::{At, Gradient, State};

/// Energies since the start \[J\]: stored and kinetic at the state, dissipated and put in along the path.
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
    /// The step that led to the state; none at the start of a run
    pub step: Option<&'a At<'a>>,
    /// \[3 × nodes\] residual: at prescribed dofs the reaction \[N\]
    pub residual: &'a [f64],
    pub energies: Energies,
    /// Numbers that the recorder keeps, with this state taken over: [`Recorder::remember`]
    pub memory: &'a [f64],
}

/// A quantity by which runs of one scene are compared where a study names none.
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

    /// Values of the columns, in SI but for angles in degrees.
    fn record(&self, now: &Moment) -> Vec<f64>;

    /// The numbers that it keeps from one accepted state to the next, before the first one; none of a function of the state. They
    /// are part of a saved state.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes an accepted state over into these numbers.
    fn remember(&self, _: &Body, _: &State, _memory: &mut [f64]) {}

    /// The numbers that it keeps at a state of which these columns were recorded, as far as [`Recorder::gradients`] reads them.
    fn memory_at(&self, body: &Body, state: &State, _recorded: &[Option<f64>]) -> Vec<f64> {
        let mut memory = self.memory();
        self.remember(body, state, &mut memory);
        memory
    }

    /// Gradients of the columns at a state that the memory has taken over; none of a column that has no derivative there. Empty if
    /// the recorder is not differentiable.
    fn gradients(&self, _: &Body, _: &State, _memory: &[f64]) -> Vec<Option<Gradient>> {
        Vec::new()
    }

    /// Whether [`Recorder::gradients`] gives values.
    fn is_differentiable(&self) -> bool {
        false
    }

    /// The columns as functions of polynomials of the displacement, where they are.
    fn features(&self) -> Option<Features> {
        None
    }

    /// Values of these polynomials at displacement x.
    fn feature_values(&self, _: &Body, _x: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
