//! Figures that several kinds of study draw.

pub mod grid;
pub mod sheet;
pub mod time;
pub mod work_precision;

use crate::report::canvas::italic;
use crate::report::unit::labelled;
use crate::study::store::record::Quantity;

/// Quantities or axes that a figure with a panel for each shows.
pub const PANELS: usize = 6;

/// The end of a caption where there are more quantities than panels.
pub fn first_of(quantities: usize) -> String {
    first_panels(quantities, "quantities")
}

/// The end of a caption where there are more things than panels.
pub fn first_panels(count: usize, things: &str) -> String {
    if count > PANELS { format!(" Of {count} {things} the first {PANELS}.") } else { String::new() }
}

/// `bending angle θ [°]`, for an axis.
pub fn axis_label(q: &Quantity, prefix: &str) -> String {
    labelled(&format!("{prefix}{} {}", q.label, italic(&q.symbol)), &q.unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_says_what_has_no_panel() {
        assert_eq!(first_of(PANELS), "");
        assert_eq!(first_of(8), " Of 8 quantities the first 6.");
        assert_eq!(first_panels(7, "axes"), " Of 7 axes the first 6.");
    }
}
