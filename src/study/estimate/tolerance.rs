//! The tolerance of a quantity: a share of its value, and where the value may be near zero an absolute one.
//!
//! ```text
//! allowed(f) = max(relative·|f|, absolute),   scale(f) = allowed(f)/relative = max(|f|, absolute/relative)
//! ```
//!
//! Errors in per cent are shares of the scale, so that they meet the relative tolerance exactly where the error is allowed.

/// Largest error that is accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Share of the value \[–\]
    pub relative: f64,
    /// Accepted whatever the value is \[unit of the quantity\]; 0 for none
    pub absolute: f64,
}

impl From<f64> for Tolerance {
    /// A relative tolerance alone.
    fn from(relative: f64) -> Self {
        Self { relative, absolute: 0.0 }
    }
}

impl Tolerance {
    /// Largest accepted error of this value \[unit of the quantity\].
    pub fn allowed(&self, value: f64) -> f64 {
        (self.relative * value.abs()).max(self.absolute)
    }

    /// Value that errors are related to \[unit of the quantity\]; never zero where there is an absolute tolerance.
    pub fn scale(&self, value: f64) -> f64 {
        value.abs().max(self.absolute / self.relative)
    }

    /// The absolute tolerance decides for this value.
    pub fn is_absolute(&self, value: f64) -> bool {
        self.absolute > self.relative * value.abs()
    }
}
