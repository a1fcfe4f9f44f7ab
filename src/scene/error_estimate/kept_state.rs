//! A state of a run from which a solution in the enriched space starts.

use crate::math::signal::Ramp;
use crate::system::State;

/// The part of a state that a static solution depends on.
pub(super) struct Kept {
    pub t: f64,
    pub x: Vec<f64>,
    pub lambda: Vec<f64>,
    pub inputs: Vec<Ramp>,
}

impl Kept {
    pub fn new(state: &State) -> Self {
        let State { t, x, lambda, inputs, .. } = state;
        Self { t: *t, x: x.clone(), lambda: lambda.clone(), inputs: inputs.clone() }
    }
}
