//! Drive of a cable or a cavity: its tension or pressure is a multiplier, or is prescribed.

use crate::math::signal::Signal;
use crate::system::{Gradient, State};

/// Source of the tension of a cable or of the pressure of a cavity.
#[derive(Clone)]
pub enum Drive {
    /// Index of the constraint whose multiplier it is
    Multiplier(usize),
    Prescribed(Signal),
}

impl Drive {
    /// The multiplier at a state, or the prescribed value.
    pub(in crate::scene) fn value(&self, state: &State) -> f64 {
        match self {
            Self::Multiplier(c) => state.lambda[*c],
            Self::Prescribed(signal) => signal.at(state.clock()),
        }
    }

    /// Gradient of the tension or pressure: zero if it is prescribed.
    pub(in crate::scene) fn gradient(&self) -> Gradient {
        match self {
            Self::Multiplier(c) => Gradient { lambda: vec![(*c, 1.0)], ..Gradient::default() },
            Self::Prescribed(_) => Gradient::default(),
        }
    }
}
