//! A damped vibration superposed on a slow motion: y = A e^{−δs} cos(2πfs + φ) + c₀ + c₁ g(s).

use crate::calibrate::Bounded;
use std::f64::consts::TAU;
use std::str::FromStr;

/// Slow motion underlying the vibration.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Creep {
    None,
    /// c₁ s
    Linear,
    /// c₁ ln(s/1 s); the window begins after the release
    #[default]
    Logarithmic,
}

impl Creep {
    /// Returns the creep function g at a time since the release \[s\].
    pub fn at(self, s: f64) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Linear => Some(s),
            Self::Logarithmic => Some(s.ln()),
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Self::None => "no creep",
            Self::Linear => "creep in proportion to time",
            Self::Logarithmic => "creep in proportion to the logarithm of time",
        }
    }
}

impl FromStr for Creep {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "none" => Ok(Self::None),
            "linear" => Ok(Self::Linear),
            "logarithmic" => Ok(Self::Logarithmic),
            _ => Err(format!("\"{word}\" is no creep; known: none, linear, logarithmic")),
        }
    }
}

/// A damped vibration fitted to a window of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct RingDown {
    /// Window of the rows \[s\]
    pub window_s: [f64; 2],
    /// Time of the release \[s\], at which amplitude and phase are given
    pub origin_s: f64,
    pub rows: usize,
    pub frequency_hz: Bounded,
    /// δ \[1/s\]
    pub decay_per_s: Bounded,
    /// A at the release, in the unit of the curve
    pub amplitude: Bounded,
    /// φ at the release \[rad\]
    pub phase: Bounded,
    /// c₀
    pub offset: Bounded,
    /// c₁ in the unit of the curve (per second if the creep is linear); zero without creep
    pub creep: Bounded,
    pub kind: Creep,
    /// Rms of the residual, in the unit of the curve
    pub rms: f64,
    /// Correlation of neighbouring residuals \[–\]
    pub correlation: f64,
    /// Degrees of freedom of Student's t
    pub free: usize,
}

impl RingDown {
    /// Returns the fitted curve at a time \[s\].
    pub fn at(&self, time_s: f64) -> f64 {
        let s = time_s - self.origin_s;
        let (f, d) = (self.frequency_hz.value, self.decay_per_s.value);
        let vibration = self.amplitude.value * (-d * s).exp() * (TAU * f * s + self.phase.value).cos();
        vibration + self.offset.value + self.creep.value * self.kind.at(s).unwrap_or(0.0)
    }
}
