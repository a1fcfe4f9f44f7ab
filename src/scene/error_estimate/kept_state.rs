//! A state of a run from which a solution in the enriched space starts, and that solution.

use crate::math::signal::Known;
use crate::system::State;

/// The part of a state on which a static solution depends.
pub(super) struct Kept {
    pub t: f64,
    pub x: Vec<f64>,
    pub lambda: Vec<f64>,
    pub inputs: Vec<Known>,
}

impl Kept {
    pub fn new(state: &State) -> Self {
        let State { t, x, lambda, inputs, .. } = state;
        Self { t: *t, x: x.clone(), lambda: lambda.clone(), inputs: inputs.clone() }
    }
}

/// The solution in the enriched space at one time.
pub(super) struct Solved {
    /// State of the run as functions in the enriched space
    pub start: State,
    pub end: State,
    /// Columns at the solution
    pub values: Vec<f64>,
    /// Memory of the recorders there
    pub memory: Vec<f64>,
    pub factorisations: usize,
}

/// The start of a run in the enriched space.
pub(super) struct Start<'a> {
    pub state: State,
    /// Columns at the start
    pub row: Vec<f64>,
    /// Memory of the recorders of the run at the start
    pub memory: &'a [f64],
}
