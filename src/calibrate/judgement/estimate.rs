//! Fitted constants with their intervals, and directions that the data do not determine.

use serde::Serialize;

/// A parameter with its 95 % interval \[SI\].
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Estimate {
    pub name: &'static str,
    pub symbol: &'static str,
    /// SI unit
    pub unit: &'static str,
    pub value: f64,
    /// Infinite where the data do not determine the constant
    pub std_error: f64,
    pub interval: [f64; 2],
}

impl Estimate {
    /// Whether both ends of the interval are finite.
    pub fn is_bounded(&self) -> bool {
        self.std_error.is_finite() && self.interval.iter().all(|end| end.is_finite())
    }

    /// Whether the interval includes zero; an interval without a width does not.
    pub fn may_be_zero(&self) -> bool {
        let [low, high] = self.interval;
        low <= 0.0 && high >= 0.0 && low < high
    }
}

/// A direction of change of the constants that the data do not determine, or hardly determine.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Direction {
    /// `changing C10 by +1 %, C01 by −0.97 % together`, or the name of a single constant
    pub changes: String,
    /// The combination that the data determine, if there is exactly one
    pub known: Option<String>,
    /// Half-width of the 95 % interval along the direction, relative to the constants \[–\]; `None` if the data do not depend on the direction at all
    pub half_width: Option<f64>,
}
