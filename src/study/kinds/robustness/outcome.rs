//! Outcome of a case of a robustness study.

use serde::Serialize;

/// Outcome of a case.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    Pass,
    /// Ended with a stated reason in place of an answer, where the study accepts that
    Stopped,
    /// A point of a map that converged farther off its reference than the tolerance
    Inaccurate,
    Fail,
}

impl CaseOutcome {
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Stopped => "stopped",
            Self::Inaccurate => "inaccurate",
            Self::Fail => "fail",
        }
    }
}
