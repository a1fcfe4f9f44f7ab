//! The tolerance of a quantity: relative to its value, and additionally absolute where the value may be near zero.
//!
//! ```text
//! allowed(f) = max(relative·|f|, absolute),   scale(f) = allowed(f)/relative = max(|f|, absolute/relative)
//! ```
//!
//! Percentage errors are relative to the scale, so that an error meets the relative tolerance exactly if it is allowed.

/// Largest accepted error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Error relative to the value \[–\]
    pub relative: f64,
    /// Error accepted whatever the value \[unit of the quantity\]; 0 if there is no absolute tolerance
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

    /// Value relative to which errors are given \[unit of the quantity\]; never zero with an absolute tolerance.
    pub fn scale(&self, value: f64) -> f64 {
        value.abs().max(self.absolute / self.relative)
    }

    /// Whether the absolute tolerance decides for this value.
    pub fn is_absolute(&self, value: f64) -> bool {
        self.absolute > self.relative * value.abs()
    }
}
