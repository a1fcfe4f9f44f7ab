//! Axes on the sheet: a frame with grid, ticks, numbers and labels.

pub use crate::report::axis::Axis;
use crate::report::canvas::{Area, At, INK, PALE, Point, SMALL, line, mm, text};
use crate::report::measure::{label_lines, label_within, width};
use crate::report::numbers::percent;
use crate::report::panels::{Letter, headed};
use crate::wording::all;

/// Smallest distances between the numbers of neighbouring ticks along x, and between their lines along y \[units\].
const APART: i32 = 25;
const LINE: i32 = 80;

/// Width to the left of a frame that every figure leaves free \[mm\].
const SIDE: f64 = 14.0;

/// Words of a caption about marks that are [on the axis](Plot::floored).
pub const BELOW: &str = "a mark on the axis is of an error below it";

/// Returns the end of a caption that names quantities without a panel, because their errors are [below any axis](Axis::below), with the largest error
/// of each \[%\].
pub fn without_panel(left_out: &[(String, f64)]) -> String {
    let words = |(what, largest): &(String, f64)| format!("{what} (at most {})", percent(0.01 * largest));
    let words: Vec<String> = left_out.iter().map(words).collect();
    if words.is_empty() { String::new() } else { format!(" Too small for a panel are the errors of {}.", all(&words)) }
}

/// A frame between two corners of the sheet, with its axes.
pub struct Plot<'a, 'b> {
    pub area: &'a Area<'b>,
    /// Left, top, right, bottom \[units\]
    pub frame: [i32; 4],
    pub x: Axis,
    pub y: Axis,
}

impl Plot<'_, '_> {
    pub fn at(&self, x: f64, y: f64) -> Point {
        let [l, t, r, b] = self.frame.map(f64::from);
        // Far outside of the sheet is as good as farther
        let unit = |v: f64| v.round().clamp(-1e6, 1e6) as i32;
        (unit(l + self.x.place(x) * (r - l)), unit(b - self.y.place(y) * (b - t)))
    }

    pub fn path(&self, x: &[f64], y: &[f64]) -> Vec<Point> {
        x.iter().zip(y).filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| self.at(*a, *b)).collect()
    }

    /// Place of a mark: that of the value, or on the axis for a value below its range.
    pub fn floored(&self, x: f64, y: f64) -> Point {
        self.at(x, y.max(self.y.lo))
    }

    /// Ticks along x, with the numbers that have room next to each other.
    fn ticks_of_x(&self) -> Vec<(f64, String)> {
        let fits = |ticks: &[(f64, String)]| {
            let named = ticks.iter().filter(|t| !t.1.is_empty());
            let spans: Vec<(i32, i32)> =
                named.map(|(v, name)| (self.at(*v, self.y.lo).0, width(name, SMALL))).collect();
            spans.windows(2).all(|w| (w[1].0 - w[0].0).abs() >= (w[0].1 + w[1].1) / 2 + APART)
        };
        self.x.ticks_where(fits)
    }

    /// Ticks along y, with the numbers that have room above each other.
    fn ticks_of_y(&self) -> Vec<(f64, String)> {
        let fits = |ticks: &[(f64, String)]| {
            let named = ticks.iter().filter(|t| !t.1.is_empty());
            let places: Vec<i32> = named.map(|(v, _)| self.at(self.x.lo, *v).1).collect();
            places.windows(2).all(|w| (w[1] - w[0]).abs() >= LINE)
        };
        self.y.ticks_where(fits)
    }

    /// Draws the grid, to be called before the data.
    pub fn grid(&self) {
        let [l, _, r, _] = self.frame;
        for (v, name) in self.ticks_of_y() {
            if !name.is_empty() {
                let y = self.at(self.x.lo, v).1;
                line(self.area, &[(l, y), (r, y)], PALE, 4);
            }
        }
        self.grid_x();
    }

    /// Draws the vertical grid lines only.
    pub fn grid_x(&self) {
        let [_, t, _, b] = self.frame;
        for (v, name) in self.ticks_of_x() {
            if !name.is_empty() {
                let x = self.at(v, self.y.lo).0;
                line(self.area, &[(x, t), (x, b)], PALE, 4);
            }
        }
    }

    /// Draws both axes, to be called after the data. `names` adds numbers and label along x.
    pub fn axes(&self, names: bool) {
        self.ticks_x(names);
        self.axis_y();
    }

    /// Draws the axis along y with its numbers, and the line of the axis along x.
    pub fn axis_y(&self) {
        let [l, t, r, b] = self.frame;
        line(self.area, &[(l, t), (l, b), (r, b)], INK, 6);
        let mut widest = width("0.00", SMALL);
        for (v, name) in self.ticks_of_y() {
            let y = self.at(self.x.lo, v).1;
            let long = if name.is_empty() { 12 } else { 25 };
            line(self.area, &[(l - long, y), (l, y)], INK, 5);
            if !name.is_empty() {
                widest = widest.max(width(&name, SMALL));
                text(self.area, &name, (l - 38, y), At::Right, SMALL, INK);
            }
        }
        let (room, place) = (b - t + mm(4.0), l - 60 - widest);
        let (size, lines) = match l - place + 2 * LINE <= mm(SIDE) {
            true => label_lines(&self.y.label, room),
            false => {
                let (size, label) = label_within(&self.y.label, room);
                (size, vec![label])
            }
        };
        for (k, words) in lines.iter().rev().enumerate() {
            text(self.area, words, (place - LINE * k as i32, (t + b) / 2), At::Turned, size, INK);
        }
    }

    /// Draws the axis along x only.
    pub fn axis_x(&self) {
        let [l, _, r, b] = self.frame;
        line(self.area, &[(l, b), (r, b)], INK, 6);
        self.ticks_x(true);
    }

    fn ticks_x(&self, names: bool) {
        let [l, _, r, b] = self.frame;
        for (v, name) in self.ticks_of_x() {
            let x = self.at(v, self.y.lo).0;
            let long = if name.is_empty() { 12 } else { 25 };
            line(self.area, &[(x, b), (x, b + long)], INK, 5);
            if names && !name.is_empty() {
                // The last number ends at the edge of the sheet
                let end = self.area.dim_in_pixel().0 as i32 - width(&name, SMALL) / 2;
                text(self.area, &name, (x.min(end), b + 38), At::Below, SMALL, INK);
            }
        }
        if names {
            let (size, label) = label_within(&self.x.label, r - l + mm(6.0));
            text(self.area, &label, ((l + r) / 2, b + 125), At::Below, size, INK);
        }
    }

    /// Draws a title with the letter of the panel above the frame.
    pub fn title(&self, letter: Option<Letter>, words: &str) {
        let [l, t, r, _] = self.frame;
        headed(self.area, (l, t), r - l, letter, words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_names_what_has_no_panel_with_its_largest_error() {
        assert_eq!(without_panel(&[]), "");
        let words = without_panel(&[("weight".into(), 1.5e-6), ("load".into(), 0.0)]);
        assert_eq!(words, " Too small for a panel are the errors of weight (at most 1.5e-6 %) and load (at most 0 %).");
    }
}
