//! The answer of an inverse analysis, as it is stored with its case.

use super::Measured;
use super::bound::Bound;
use super::search::End;
use crate::calibrate::ErrorModel;
use serde::{Deserialize, Serialize};

/// Relative change of a constant up to which it is said to be at its start \[–\]
const STAYS: f64 = 0.01;

/// Constants of the laws of a scene, found from measured curves. SI units; curves in the units of the scene's columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    pub constants: Vec<FittedConstant>,
    /// \[constants × constants\] of their errors \[SI\]; none where a direction is not determined
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Directions that the curves do not determine, or hardly, and constants that are held at a bound, in words
    pub unidentified: Vec<String>,
    /// Errors of the data points, as the residuals show them
    pub errors: ErrorModel,
    /// Degrees of freedom of Student's t in the intervals
    pub free: usize,
    pub curves: Vec<FittedCurve>,
    /// Result of a fit of the first curve with a gauge length, where one is given
    pub gauge: Option<Gauge>,
    /// Forward solves of the search, failed ones among them, and of the profiles; each of one curve
    pub solves: usize,
    pub profile_solves: usize,
    pub failed: usize,
    pub end: End,
    /// Wall time of a forward solve of all curves, and additional time of the derivatives \[s\]
    pub forward_s: f64,
    pub gradient_s: f64,
    /// Wall time of all \[s\]
    pub wall_s: f64,
}

/// A measured curve next to what the scene says at the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedCurve {
    pub name: String,
    /// Signal or `t_s`
    pub x: String,
    /// Recorded column
    pub y: String,
    pub measured: Measured,
    /// \[data points\] the scene with the constants found, and the offsets
    pub predicted: Vec<f64>,
    /// The scene at the steps of its protocol: x and y
    pub curve: Vec<[f64; 2]>,
    /// √(Σr²/Σy²) \[–\]
    pub rms_relative: f64,
    /// √(Σr²/n), unit of y
    pub rms: f64,
    /// Probability that signs in random order show as few runs over x, the correlation of neighbours taken out; none where all are
    /// equal, and with several specimens of one test
    pub runs_p: Option<f64>,
    /// Offsets of this curve, in the units of its columns
    pub offsets: Vec<FittedConstant>,
    /// Largest principal stretch in the body at the end, volume percentiles 50, 95 and the largest \[–\]
    pub stretch: [f64; 3],
    pub stability: Vec<Stable>,
}

/// A constant with its interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedConstant {
    /// `laws.rubber.mu`
    pub key: String,
    pub symbol: String,
    /// SI unit
    pub unit: String,
    pub start: f64,
    pub value: f64,
    /// None where the data do not determine the constant, and of one that is held at a bound
    pub std_error: Option<f64>,
    /// 95 % by the errors as the residuals show them
    pub interval: Option<[f64; 2]>,
    /// 95 % by profile likelihood, where it was asked for; an end that was not found is open
    pub profile: Option<[Option<f64>; 2]>,
    pub bound: Bound,
    /// The search left it at its start: the curves hardly see it, and their misfit does not fall along it by more than the scatter of the data
    #[serde(default)]
    pub left: bool,
}

/// The unknowns of the law of an inverse fit, fitted as if the travel stretched a gauge length alone, incompressible and homogeneous; the other constants are
/// those of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gauge {
    pub length_m: f64,
    pub section_m2: f64,
    /// Its value of each constant, where that fit has it
    pub values: Vec<Option<f64>>,
    pub rms_relative: Option<f64>,
    /// Why there is no such fit
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<String>,
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

impl Calibration {
    /// Whether the search came to its end.
    pub fn settled(&self) -> bool {
        self.end == End::Settled
    }

    /// Keys of the constants that the search left at their starting values.
    pub fn left(&self) -> Vec<&str> {
        self.constants.iter().filter(|f| f.left).map(|f| f.key.as_str()).collect()
    }

    /// Values of the constants and of the offsets of the curves, in the order of the search.
    pub fn values(&self) -> Vec<f64> {
        let offsets = self.curves.iter().flat_map(|c| &c.offsets);
        self.constants.iter().chain(offsets).map(|f| f.value).collect()
    }
}

impl FittedConstant {
    /// The smallest interval that holds all of them; none where an end by profile likelihood was asked for and is open.
    pub fn widest(&self) -> Option<[f64; 2]> {
        let [a, b] = self.interval?;
        let [c, d] = match self.profile {
            None => [a, b],
            Some([c, d]) => [c?, d?],
        };
        Some([a.min(c), b.max(d)])
    }

    /// Says where an end of the interval by profile likelihood is open.
    pub fn open_end(&self) -> Option<String> {
        let side = match self.profile? {
            [None, None] => "both ends of its 95 % interval by profile likelihood are open",
            [None, _] => "the lower end of its 95 % interval by profile likelihood is open",
            [_, None] => "the upper end of its 95 % interval by profile likelihood is open",
            _ => return None,
        };
        self.interval.map(|_| format!("{}: {side}, so that no interval is stated", self.key))
    }

    /// Says where the interval has values that the constant cannot have, such as a modulus below zero.
    pub fn beyond(&self, (lower, upper): (f64, f64)) -> Option<String> {
        let [low, high] = self.widest()?;
        (low < lower || high > upper).then(|| {
            format!(
                "{}: its 95 % interval, {low} to {high} in SI units, reaches beyond its possible values, {lower} to {upper}: the data hardly determine it",
                self.key
            )
        })
    }

    /// Whether a constant that was left has changed all the same, with others.
    pub fn moved(&self) -> bool {
        (self.value - self.start).abs() > STAYS * self.start.abs()
    }

    /// Says where the search left the constant at its start.
    pub fn left_at_start(&self) -> Option<String> {
        self.left.then(|| {
            let because = "because the misfit does not fall along it by more than the scatter of the data";
            let (key, start) = (&self.key, self.start);
            match self.moved() {
                true => format!(
                    "{key}: from its starting value, {start} in SI units, it changed to {} with others only, {because}",
                    self.value
                ),
                false => format!(
                    "{key}: the search left it at its starting value, {start} in SI units, {because}; the values of the others go with it"
                ),
            }
        })
    }

    /// Says where the constant is held at a bound.
    pub fn held(&self) -> Option<String> {
        let side = match self.bound {
            Bound::Free => return None,
            Bound::Upper => "upper",
            Bound::Lower => "lower",
        };
        Some(format!(
            "{} is held at its {side} bound, {} in SI units: the data would take it further, it has no interval, and those of the others \
             take it as known",
            self.key, self.value
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant that has changed along a direction that was searched is not said to be at its start.
    #[test]
    fn what_moved_with_others_was_not_left_at_its_start() {
        let words = |value: f64| {
            let found = FittedConstant {
                key: "laws.rubber.E".into(),
                symbol: "E".into(),
                unit: "Pa".into(),
                start: 250e3,
                value,
                std_error: None,
                interval: None,
                profile: None,
                bound: Bound::Free,
                left: true,
            };
            found.left_at_start().expect("it was left")
        };
        assert!(words(250.1e3).contains("the search left it at its starting value"), "{}", words(250.1e3));
        let moved = words(273e3);
        assert!(moved.contains("it changed to 273000 with others only") && !moved.contains("left it"), "{moved}");
    }
}
