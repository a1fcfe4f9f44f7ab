//! Outcome of a case in a study that judges its cases individually.

use serde::Serialize;

/// Outcome of a case that is judged individually.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    /// Converged, and matches every reference
    Pass,
    /// Converged, but without anything to compare it with: no statement about its answer
    Unchecked,
    /// Ended with a stated reason instead of an answer, as the study demands
    Demanded,
    /// Ended with a stated reason instead of an answer, which the study accepts
    Stopped,
    /// A point of a map that converged, but differs from its reference by more than the tolerance
    Inaccurate,
    /// A wrong answer, no answer where one is required, or a crash
    Fail,
}

impl CaseOutcome {
    /// All outcomes, in the order of reports.
    pub const ALL: [Self; 6] =
        [Self::Pass, Self::Unchecked, Self::Demanded, Self::Stopped, Self::Inaccurate, Self::Fail];

    /// The name used in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Unchecked => "unchecked",
            Self::Demanded => "demanded",
            Self::Stopped => "stopped",
            Self::Inaccurate => "inaccurate",
            Self::Fail => "fail",
        }
    }
}
