//! The answer of an inverse analysis, as it is stored with its case.

use super::Measured;
use serde::{Deserialize, Serialize};

/// Constants of the laws of a scene, found from a measured curve. SI units; curves in the units of the scene's columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Signal or `t_s`
    pub x: String,
    /// Recorded column
    pub y: String,
    pub constants: Vec<Found>,
    /// \[constants × constants\] of the errors as if data points were independent \[SI\]; none where a direction is not determined
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Directions that the curve does not determine, or hardly, in words
    pub unidentified: Vec<String>,
    /// Block of neighbouring data points that the bootstrap drew \[data points\]
    pub block: usize,
    pub measured: Measured,
    /// \[data points\] the scene with the constants found
    pub predicted: Vec<f64>,
    /// The scene at the steps of its protocol: x and y
    pub curve: Vec<[f64; 2]>,
    /// √(Σr²/Σy²) \[–\]
    pub rms_relative: f64,
    /// √(Σr²/n), unit of y
    pub rms: f64,
    /// Probability that signs in random order show as few runs over x; none where all are equal
    pub runs_p: Option<f64>,
    /// Result of a fit with a gauge length, where there is one
    pub gauge: Option<Gauge>,
    /// Largest principal stretch in the body at the end, volume percentiles 50, 95 and the largest \[–\]
    pub stretch: [f64; 3],
    pub stability: Vec<Stable>,
    /// Forward solves of the search, failed ones among them, and of the profiles
    pub solves: usize,
    pub profile_solves: usize,
    pub failed: usize,
    /// The search came to its end
    pub settled: bool,
    /// Mean wall time of a forward solve, and additional time of the derivatives \[s\]
    pub forward_s: f64,
    pub gradient_s: f64,
    /// Wall time of all \[s\]
    pub wall_s: f64,
}

/// A constant with its interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// `laws.rubber.mu`
    pub key: String,
    pub symbol: String,
    /// SI unit
    pub unit: String,
    pub start: f64,
    pub value: f64,
    /// None where the data do not determine the constant
    pub std_error: Option<f64>,
    /// 95 % as if data points were independent
    pub interval: Option<[f64; 2]>,
    /// 95 % by profile likelihood, where it was asked for; an end that was not found is open
    pub profile: Option<[Option<f64>; 2]>,
    /// 95 % from resampled blocks of data points
    pub bootstrap: Option<[f64; 2]>,
}

/// The same law fitted as if the travel stretched a gauge length alone, incompressible and homogeneous.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gauge {
    pub length_m: f64,
    pub section_m2: f64,
    /// Its value of each constant, where that fit has it
    pub values: Vec<Option<f64>>,
    pub rms_relative: f64,
}

/// Range of a mode in which the law is stable (Drucker); amounts are λ, in simple shear γ \[–\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stable {
    pub law: String,
    pub mode: String,
    pub looked: [f64; 2],
    pub below: Option<f64>,
    pub above: Option<f64>,
}

impl Found {
    /// The smallest interval that holds all of them; none where an end by profile likelihood was asked for and is open.
    pub fn widest(&self) -> Option<[f64; 2]> {
        let [a, b] = self.interval?;
        let [c, d] = self.bootstrap.unwrap_or([a, b]);
        let [e, f] = match self.profile {
            None => [a, b],
            Some([e, f]) => [e?, f?],
        };
        Some([a.min(c).min(e), b.max(d).max(f)])
    }

    /// In words, where an end of the interval by profile likelihood is open.
    pub fn open_end(&self) -> Option<String> {
        let side = match self.profile? {
            [None, None] => "both ends of its 95 % interval by profile likelihood are open",
            [None, _] => "the lower end of its 95 % interval by profile likelihood is open",
            [_, None] => "the upper end of its 95 % interval by profile likelihood is open",
            _ => return None,
        };
        self.interval.map(|_| format!("{}: {side}, so that no interval is stated", self.key))
    }
}
