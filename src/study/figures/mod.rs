//! Figures that several kinds of study draw.

pub mod grid;
pub mod sheet;
pub mod time;
pub mod work_precision;

use crate::report::canvas::italic;
use crate::report::names::with_symbol;
use crate::report::unit::labelled;
use crate::study::store::record::StudyQuantity;

/// Largest number of quantities or axes in a figure with one panel for each.
pub const PANELS: usize = 6;

/// End of the caption of a figure that shows only the first of several things: ` Of 9 quantities the first 6.`
pub fn first_of(count: usize, shown: usize, things: &str) -> String {
    if count > shown { format!(" Of {count} {things} the first {shown}.") } else { String::new() }
}

/// Label of an axis: `bending angle θ [°]`.
pub fn axis_label(q: &StudyQuantity, prefix: &str) -> String {
    labelled(&format!("{prefix}{}", with_symbol(&q.label, &q.symbol, &italic(&q.symbol))), &q.unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_says_what_has_no_panel() {
        assert_eq!(first_of(PANELS, PANELS, "quantities"), "");
        assert_eq!(first_of(8, PANELS, "quantities"), " Of 8 quantities the first 6.");
        assert_eq!(first_of(7, 2, "axes"), " Of 7 axes the first 2.");
    }
}
