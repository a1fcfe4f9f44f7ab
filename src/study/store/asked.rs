//! The parts of a result that a study asks for in addition to curves.

use serde::{Deserialize, Serialize};

/// Everything that was asked of a case when it was computed.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Asked {
    /// Columns whose errors are estimated from the run alone
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<String>,
    /// Constants that the columns are differentiated by
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constants: Vec<String>,
    /// The derivatives are known along the curves, not at their extremes only
    #[serde(default)]
    pub along_curves: bool,
    /// Runs, for the scatter of their times
    pub repeats: usize,
    /// The states are kept
    #[serde(default)]
    pub states: bool,
}

impl Asked {
    /// Whether all of the other one is in this.
    pub fn has(&self, other: &Self) -> bool {
        let all = |wanted: &[String], known: &[String]| wanted.iter().all(|name| known.contains(name));
        all(&other.estimates, &self.estimates)
            && all(&other.constants, &self.constants)
            && self.along_curves >= other.along_curves
            && self.repeats >= other.repeats
            && self.states >= other.states
    }
}

/// Everything that a study asks of all its cases. The rest of a record, which an earlier form of the study has asked for, is in no report.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Asks {
    /// Errors from the run alone of every case but those of a reference
    pub error_estimates: bool,
    /// Derivatives by the constants that are known within intervals
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
