//! Drive of a cable or a cavity: its tension or pressure is a multiplier, or prescribed.

use crate::math::signal::Signal;
use crate::system::Gradient;

/// Source of the tension of a cable or of the pressure of a cavity.
pub enum Drive {
    /// Index of the constraint whose multiplier it is
    Multiplier(usize),
    Prescribed(Signal),
}

impl Drive {
    /// Gradient of the tension or pressure: zero of what is prescribed.
    pub(in crate::scene) fn gradient(&self) -> Gradient {
        match self {
            Self::Multiplier(c) => Gradient { lambda: vec![(*c, 1.0)], ..Gradient::default() },
            Self::Prescribed(_) => Gradient::default(),
        }
    }
}
