//! The parts of a result that a study requests in addition to curves.

use serde::{Deserialize, Serialize};

/// Everything that was requested of a case when it was computed.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Asked {
    /// Columns whose errors are estimated from the run alone
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<String>,
    /// Constants with respect to which the columns are differentiated
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constants: Vec<String>,
    /// Whether the derivatives are known along the curves, not only at their extremes
    #[serde(default)]
    pub along_curves: bool,
    /// Number of runs, for the scatter of their times
    pub repeats: usize,
    /// Whether the states are kept
    #[serde(default)]
    pub states: bool,
}

impl Asked {
    /// Whether it contains everything in `other`.
    pub fn has(&self, other: &Self) -> bool {
        let all = |wanted: &[String], known: &[String]| wanted.iter().all(|name| known.contains(name));
        all(&other.estimates, &self.estimates)
            && all(&other.constants, &self.constants)
            && self.along_curves >= other.along_curves
            && self.repeats >= other.repeats
            && self.states >= other.states
    }
}

/// Everything that a study requests of all its cases. Other parts of a record, which an earlier form of the study requested, do not appear in reports.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Asks {
    /// Errors from the run alone, for every case except references
    pub error_estimates: bool,
    /// Derivatives with respect to constants that are known within intervals
    pub input_uncertainty: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_is_asked_for_is_enough() {
        let asked = |estimates: &[&str], constants: &[&str], repeats, whole| {
            let [estimates, constants] =
                [estimates, constants].map(|all| all.iter().map(ToString::to_string).collect());
            Asked { estimates, constants, along_curves: whole, repeats, states: whole }
        };
        let all = asked(&["a", "b"], &["mu"], 2, true);
        for less in [all.clone(), asked(&["b"], &[], 1, false), Asked::default()] {
            assert!(all.has(&less), "{less:?}");
        }
        for more in [asked(&["c"], &[], 1, false), asked(&[], &["nu"], 1, false), asked(&[], &[], 3, false)] {
            assert!(!all.has(&more), "{more:?}");
        }
        for less in [Asked { along_curves: false, ..all.clone() }, Asked { states: false, ..all.clone() }] {
            assert!(!less.has(&all), "{less:?}");
        }
    }
}
