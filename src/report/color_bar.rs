//! A colour bar of a field with its numbers.

use crate::report::axis::Axis;
use crate::report::canvas::{Area, At, INK, SMALL, block, line, mm, text};
use crate::report::surface::viridis;

/// Number of colours of a bar.
const COLORS: usize = 128;
/// Width of a bar \[mm\].
const WIDE: f64 = 3.5;
/// Width of a bar with its numbers \[mm\].
pub const ROOM: f64 = 14.0;

/// Draws the bar from its left edge between two heights \[mm\], with the smallest value at the bottom and the largest at the top.
pub fn color_bar(area: &Area, x: f64, (top, bottom): (f64, f64), axis: &Axis) {
    let y = |share: f64| mm(bottom - (bottom - top) * share);
    for k in 0..COLORS {
        let share = |k: f64| k / COLORS as f64;
        // Each colour extends to the top and is covered by the next ones, so that there is no seam between two colours
        block(area, (mm(x), mm(top)), (mm(x + WIDE), y(share(k as f64))), viridis(share(k as f64 + 0.5)));
    }
    for (value, name) in axis.ticks() {
        let y = y(axis.place(value));
        line(area, &[(mm(x + WIDE), y), (mm(x + WIDE + 0.9), y)], INK, 5);
        text(area, &name, (mm(x + WIDE + 1.7), y), At::Left, SMALL, INK);
    }
}
