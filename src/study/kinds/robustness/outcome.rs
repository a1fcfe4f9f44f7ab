//! Outcome of a case of a robustness study.

use serde::Serialize;

/// Outcome of a case.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    Pass,
    Refused,
    Fail,
}

impl CaseOutcome {
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Refused => "refused",
            Self::Fail => "fail",
        }
    }
}
