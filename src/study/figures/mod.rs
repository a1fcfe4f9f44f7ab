//! Figures that several kinds of study draw.

pub mod time;

use crate::report::canvas::italic;
use crate::study::store::record::Quantity;

/// `bending angle θ [°]`, for an axis.
pub fn axis_label(q: &Quantity, prefix: &str) -> String {
    let unit = if q.unit.is_empty() { String::new() } else { format!(" [{}]", q.unit) };
    format!("{prefix}{} {}{unit}", q.label, italic(&q.symbol))
}
