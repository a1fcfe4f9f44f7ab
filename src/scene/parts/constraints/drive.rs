//! Drive of a cable or a cavity: its tension or pressure is a multiplier, or prescribed.

use crate::math::signal::Signal;
use crate::system::State;

/// Source of the tension of a cable or of the pressure of a cavity.
pub enum Drive {
    /// Index of the constraint whose multiplier it is
    Multiplier(usize),
    Prescribed(Signal),
}

impl Drive {
    /// Change of the tension or pressure: what is prescribed does not change.
    pub(in crate::scene) fn answer(&self, change: &State) -> f64 {
        match self {
            Self::Multiplier(c) => change.lambda[*c],
            Self::Prescribed(_) => 0.0,
        }
    }
}
