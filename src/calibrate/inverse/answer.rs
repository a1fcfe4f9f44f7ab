//! The answer of an inverse analysis, as it is stored with its case.

use super::Measured;
use super::bound::Bound;
use super::search::End;
use crate::calibrate::ErrorModel;
use serde::{Deserialize, Serialize};

/// Relative change of a constant up to which it counts as being at its start \[–\]
const STAYS: f64 = 0.01;

/// Constants of the laws of a scene, found from measured curves. SI units; curves in the units of the scene's columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    pub constants: Vec<FittedConstant>,
    /// \[constants × constants\] covariance of the errors \[SI\]; `None` if a direction is not determined
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Sentences about directions that the curves do not determine, or hardly determine, and about constants that are held at a bound
    pub unidentified: Vec<String>,
    /// Error model of the data points, as the residuals show it
    pub errors: ErrorModel,
    /// Degrees of freedom of Student's t for the intervals
    pub free: usize,
    pub curves: Vec<FittedCurve>,
    /// Result of a fit of the first curve with a gauge length, if one is given
    pub gauge: Option<Gauge>,
    /// Forward solves of the search, including failed ones, and of the profiles; each of one curve
    pub solves: usize,
    pub profile_solves: usize,
    pub failed: usize,
    pub end: End,
    /// Wall time of a forward solve of all curves, and the additional time of the derivatives \[s\]
    pub forward_s: f64,
    pub gradient_s: f64,
    /// Total wall time \[s\]
    pub wall_s: f64,
}

/// A measured curve with the prediction of the scene at the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedCurve {
    pub name: String,
    /// Signal or `t_s`
    pub x: String,
    /// Recorded column
    pub y: String,
    pub measured: Measured,
    /// \[data points\] prediction of the scene with the fitted constants and offsets
    pub predicted: Vec<f64>,
    /// x and y of the scene at the steps of its protocol
    pub curve: Vec<[f64; 2]>,
    /// √(Σr²/Σy²) \[–\]
    pub rms_relative: f64,
    /// √(Σr²/n), unit of y
    pub rms: f64,
    /// Probability that signs in random order show as few runs over x, with the correlation of neighbours removed; `None` if all signs are equal, and
    /// with several specimens of one test
    pub runs_p: Option<f64>,
    /// Offsets of this curve, in the units of its columns
    pub offsets: Vec<FittedConstant>,
    /// Largest principal stretch in the body at the end: volume percentiles 50 and 95, and the maximum \[–\]
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
    /// `None` if the data do not determine the constant, or if it is held at a bound
    pub std_error: Option<f64>,
    /// 95 % interval from the errors as the residuals show them
    pub interval: Option<[f64; 2]>,
    /// 95 % interval by profile likelihood, if requested; an end that was not found is open
    pub profile: Option<[Option<f64>; 2]>,
    pub bound: Bound,
    /// The search left the constant at its start: the curves hardly depend on it, and their misfit does not fall along it by more than the scatter of
    /// the data
    #[serde(default)]
    pub left: bool,
}

/// The unknowns of the law of an inverse fit, fitted as if the travel stretched a gauge length alone, incompressible and homogeneous; the other
/// constants keep their values in the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gauge {
    pub length_m: f64,
    pub section_m2: f64,
    /// Value of each constant; `None` for a constant that this fit does not have
    pub values: Vec<Option<f64>>,
    pub rms_relative: Option<f64>,
    /// The reason why there is no such fit
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
    /// Whether the search converged.
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
    /// The smallest interval that holds all intervals of the constant; `None` if an end by profile likelihood was requested and is open.
    pub fn widest(&self) -> Option<[f64; 2]> {
        let [a, b] = self.interval?;
        let [c, d] = match self.profile {
            None => [a, b],
            Some([c, d]) => [c?, d?],
        };
        Some([a.min(c), b.max(d)])
    }

    /// Describes which end of the interval by profile likelihood is open.
    pub fn open_end(&self) -> Option<String> {
        let side = match self.profile? {
            [None, None] => "both ends of its 95 % interval by profile likelihood are open",
            [None, _] => "the lower end of its 95 % interval by profile likelihood is open",
            [_, None] => "the upper end of its 95 % interval by profile likelihood is open",
            _ => return None,
        };
        self.interval.map(|_| format!("{}: {side}, so that no interval is stated", self.key))
    }

    /// Describes an interval that includes values that the constant cannot have, such as a negative modulus.
    pub fn beyond(&self, (lower, upper): (f64, f64)) -> Option<String> {
        let [low, high] = self.widest()?;
        (low < lower || high > upper).then(|| {
            format!(
                "{}: its 95 % interval, {low} to {high} in SI units, reaches beyond its possible values, {lower} to {upper}: the data hardly determine it",
                self.key
            )
        })
    }

    /// Whether a constant that the search left has nevertheless changed, together with others.
    pub fn moved(&self) -> bool {
        (self.value - self.start).abs() > STAYS * self.start.abs()
    }

    /// Describes that the search left the constant at its start.
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

    /// Describes at which bound the constant is held.
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

    /// A constant that has changed along a direction that was searched is not reported as left at its start.
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
