//! A bar of the colours of a field, with the numbers that they are for.

use crate::report::axis::Axis;
use crate::report::canvas::{Area, At, INK, SMALL, block, line, mm, text};
use crate::report::surface::viridis;

/// Colours of a bar.
const COLORS: usize = 128;
/// Width of a bar \[mm\].
const WIDE: f64 = 3.5;
/// Width of a bar with its numbers \[mm\].
pub const ROOM: f64 = 14.0;

/// Draws the bar from its left edge between two heights \[mm\], with the least value at the bottom and the largest at the top.
pub fn color_bar(area: &Area, x: f64, (top, bottom): (f64, f64), axis: &Axis) {
    let y = |share: f64| mm(bottom - (bottom - top) * share);
    for k in 0..COLORS {
        let share = |k: f64| k / COLORS as f64;
        // Up to the top, where the next ones lie over it: no seam is between two colours
        block(area, (mm(x), mm(top)), (mm(x + WIDE), y(share(k as f64))), viridis(share(k as f64 + 0.5)));
    }
    for (value, name) in axis.ticks() {
        let y = y(axis.place(value));
        line(area, &[(mm(x + WIDE), y), (mm(x + WIDE + 0.9), y)], INK, 5);
        text(area, &name, (mm(x + WIDE + 1.7), y), At::Left, SMALL, INK);
    }
}
