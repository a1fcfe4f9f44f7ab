//! The extreme of a recorded column: the value farthest from the first one, a minimum or a maximum.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Side on which an extreme lies.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ExtremeKind {
    /// Below the first value
    Minimum,
    /// Above the first value
    Maximum,
    /// No value differs from the first one, or some value is not finite
    Constant,
}

impl ExtremeKind {
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Minimum => "minimum",
            Self::Maximum => "maximum",
            Self::Constant => "constant",
        }
    }

    /// The other side of the first value.
    pub fn opposite(self) -> Self {
        match self {
            Self::Minimum => Self::Maximum,
            Self::Maximum => Self::Minimum,
            Self::Constant => Self::Constant,
        }
    }
}

/// The value farthest from the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// Index of the value; the last one of equal values
    pub at: usize,
    pub value: f64,
    pub kind: ExtremeKind,
}

/// The extreme of the values of a column; `None` for an empty column.
pub fn extreme(values: impl IntoIterator<Item = f64>) -> Option<Extreme> {
    let mut values = values.into_iter();
    let first = values.next()?;
    let farther = |a: (usize, f64), b: (usize, f64)| if is_as_far(first, b.1, a.1) { b } else { a };
    let (at, value) = (1..).zip(values).fold((0, first), farther);
    let kind = match value.partial_cmp(&first) {
        Some(std::cmp::Ordering::Less) => ExtremeKind::Minimum,
        Some(std::cmp::Ordering::Greater) => ExtremeKind::Maximum,
        _ => ExtremeKind::Constant,
    };
    Some(Extreme { at, value, kind })
}

/// The value farthest from the first one on one side of it; `None` if no value lies on this side.
pub fn extreme_on(side: ExtremeKind, values: impl IntoIterator<Item = f64>) -> Option<Extreme> {
    let mut values = values.into_iter();
    let first = values.next()?;
    let is_there = |value: &f64| match side {
        ExtremeKind::Minimum => *value < first,
        ExtremeKind::Maximum => *value > first,
        ExtremeKind::Constant => false,
    };
    let there = values.map(|value| if is_there(&value) { value } else { first });
    extreme(std::iter::once(first).chain(there)).filter(|e| e.kind != ExtremeKind::Constant)
}

/// Whether a value is at least as far from the first one as another value is.
pub(super) fn is_as_far(first: f64, value: f64, other: f64) -> bool {
    (value - first).abs().total_cmp(&(other - first).abs()).is_ge()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extreme_is_on_one_side_of_the_first_value() {
        let of = |values: &[f64]| extreme(values.iter().copied()).map(|e| (e.at, e.value, e.kind));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[0.1, 0.1]), Some((1, 0.1, ExtremeKind::Constant)));
        // A cable that is shortened, and one that is first let out a little
        assert_eq!(of(&[0.1, 0.09, 0.085, 0.085, 0.1]), Some((3, 0.085, ExtremeKind::Minimum)));
        assert_eq!(of(&[0.1, 0.11, 0.08]), Some((2, 0.08, ExtremeKind::Minimum)));
        assert_eq!(of(&[0.0, -3.0, 4.0]), Some((2, 4.0, ExtremeKind::Maximum)));
    }

    #[test]
    fn each_side_of_the_first_value_has_its_extreme() {
        let on = |side, values: &[f64]| extreme_on(side, values.iter().copied()).map(|e| (e.at, e.value, e.kind));
        let (low, high) = (ExtremeKind::Minimum, ExtremeKind::Maximum);
        assert_eq!(on(low, &[1.0, -2.0, 5.0, 0.0]), Some((1, -2.0, low)));
        assert_eq!(on(high, &[1.0, -2.0, 5.0, f64::NAN]), Some((2, 5.0, high)));
        assert_eq!(on(low, &[1.0, 2.0]), None);
        assert_eq!(on(ExtremeKind::Constant, &[1.0, 1.0]), None);
    }
}
