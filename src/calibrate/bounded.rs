//! A fitted value with its interval.

use super::within;
use serde::{Deserialize, Serialize};

/// A value with its 95 % interval.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Bounded {
    pub value: f64,
    pub interval: [f64; 2],
}

impl Bounded {
    /// The interval cut to what is possible.
    pub(super) fn within(self, low: f64, high: f64) -> Self {
        Self { interval: self.interval.map(|end| end.clamp(low, high)), ..self }
    }

    /// The value with the smallest interval that holds both intervals.
    pub(super) fn with(self, other: &Self) -> Self {
        let ([a, b], [c, d]) = (self.interval, other.interval);
        Self { interval: [a.min(c), b.max(d)], ..self }
    }

    /// Larger distance of an end from the value.
    pub fn half_width(&self) -> f64 {
        (self.interval[1] - self.value).max(self.value - self.interval[0])
    }

    /// Describes the value with its interval and unit, as in `0.213 (0.198 to 0.228)`; pascals are scaled to a fitting unit. An infinite end is
    /// printed as open.
    pub fn words(&self, unit: &str) -> String {
        let printed = within(self.value, unit, Some(self.interval));
        let [low, high] = self.interval.map(|end| printed.end(end));
        format!("{} ({low} to {high}){}", printed.number(self.value), printed.suffix())
    }
}
