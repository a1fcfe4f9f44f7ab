//! Common parts of figures: the figure itself, its legend, marks and colours by number.

use crate::report::canvas::{Area, At, INK, MARKS, Mark, PALETTE, Point, RGB, SMALL, line, mark, mm, text};

/// A drawn figure: file name, SVG, and what it shows.
pub struct Figure {
    pub name: String,
    pub svg: String,
    pub caption: String,
}

/// Appearance of the sample of a legend entry.
pub enum Sample {
    Line(RGB),
    Dashed(RGB),
    Mark(Mark, RGB),
    Hollow(Mark, RGB),
    Block(RGB),
}

/// A legend downwards from a point, outside of the data.
pub fn legend(area: &Area, (x, mut y): Point, entries: &[(Sample, String)]) {
    for (sample, words) in entries {
        let (a, b) = ((x, y), (x + mm(5.0), y));
        match sample {
            Sample::Line(c) => line(area, &[a, b], *c, 12),
            Sample::Dashed(c) => crate::report::canvas::dashed(area, &[a, b], *c, 12, 28.0),
            Sample::Mark(m, c) => mark(area, *m, (x + mm(2.5), y), 26, *c),
            Sample::Hollow(m, c) => crate::report::canvas::hollow(area, *m, (x + mm(2.5), y), 24, *c),
            Sample::Block(c) => crate::report::canvas::block(area, (x, y - mm(1.1)), (x + mm(5.0), y + mm(1.1)), *c),
        }
        text(area, words, (x + mm(6.5), y), At::Left, SMALL, INK);
        y += mm(4.2);
    }
}

/// `sizes (tet4)`, but `tet10` for a family named after its element.
pub fn family_label(family: &str, formulation: &str) -> String {
    if family == formulation { family.into() } else { format!("{} ({formulation})", family.replace('_', " ")) }
}

/// Colour of a region below what a reference can resolve.
pub const UNRESOLVED: RGB = RGB(0xee, 0xee, 0xee);

/// Mark and colour of the `family`-th family.
pub fn style(family: usize) -> (Mark, RGB) {
    (MARKS[family % MARKS.len()], PALETTE[family % PALETTE.len()])
}
