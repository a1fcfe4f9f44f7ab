//! Outcome of a case in a study that judges its cases one by one.

use serde::Serialize;

/// Outcome of a case that is judged by itself.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    /// Converged, and every reference is matched
    Pass,
    /// Converged, and there is nothing to compare it with: no statement about its answer
    Unchecked,
    /// Ended with a stated reason in place of an answer, where the study demands that
    Demanded,
    /// Ended with a stated reason in place of an answer, where the study accepts that
    Stopped,
    /// A point of a map that converged farther off its reference than the tolerance
    Inaccurate,
    /// A wrong answer, no answer where one is due, or a computation that broke
    Fail,
}

impl CaseOutcome {
    /// All of them, as reports list them.
    pub const ALL: [Self; 6] =
        [Self::Pass, Self::Unchecked, Self::Demanded, Self::Stopped, Self::Inaccurate, Self::Fail];

    /// The name as `summary.json` writes it.
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
