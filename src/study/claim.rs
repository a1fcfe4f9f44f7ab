//! A value with its stated interval, as `summary.json` lists it for other programs and for comparisons.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A value and its error bar.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct Claim {
    /// `<case>: <column>`, or the constant or prediction in words
    pub what: String,
    /// The value, in `unit`
    pub value: f64,
    /// Ends of the error bar, in `unit`
    pub interval: [f64; 2],
    /// Unit of the value and the interval
    pub unit: String,
}

impl Claim {
    /// Returns a value of a case with an error bar of this half-width; `None` if the value or the half-width is not finite.
    pub fn of_case(case: &str, column: &str, value: f64, half_width: f64, unit: &str) -> Option<Self> {
        let is_known = value.is_finite() && half_width.is_finite();
        is_known.then(|| Self {
            what: format!("{case}: {column}"),
            value,
            interval: [value - half_width, value + half_width],
            unit: unit.into(),
        })
    }
}
