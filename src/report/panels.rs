//! Layout of equal panels in rows as long as the page allows, so that the type size is never reduced.

use crate::report::canvas::{Area, At, INK, Point, mm, page_height, page_width, text};
use crate::report::measure::heading_lines;
use std::fmt::{self, Display, Write};

/// The panels of a figure in rows. All lengths are on the sheet \[mm\].
#[derive(Clone, Copy, Debug)]
pub struct Panels {
    count: usize,
    /// Number of panels in a row
    pub columns: usize,
    /// Width of a panel
    pub each: f64,
    left: f64,
    gap: f64,
    right: f64,
}

impl Panels {
    /// Lays out `count` panels with room to the left of a row, between two panels and to the right of a row. A row has as many panels of at least
    /// `least` width as fit on the page; they are as wide as it allows, up to `most`.
    pub fn new(count: usize, (left, gap, right): (f64, f64, f64), (least, most): (f64, f64)) -> Self {
        let room = page_width() - left - right;
        let columns = (((room + gap + 1e-9) / (least + gap)).floor().max(1.0) as usize).min(count.max(1));
        let n = columns as f64;
        let each = ((room - gap * (n - 1.0)) / n).clamp(MINIMUM, most.max(MINIMUM));
        Self { count, columns, each, left, gap, right }
    }

    /// Returns the left edge of panel `k`.
    pub fn x(&self, k: usize) -> f64 {
        self.left + (k % self.columns) as f64 * (self.each + self.gap)
    }

    /// Returns the row of panel `k`, counted from zero.
    pub fn row(&self, k: usize) -> f64 {
        (k / self.columns) as f64
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> f64 {
        self.count.div_ceil(self.columns).max(1) as f64
    }

    /// Returns left, top, right and bottom of panel `k` with height `tall`: the first row begins at `top`, and each further one `row` below.
    pub fn frame(&self, k: usize, (top, row): (f64, f64), tall: f64) -> [f64; 4] {
        let (x, y) = (self.x(k), top + row * self.row(k));
        [x, y, x + self.each, y + tall]
    }

    /// Returns the height of a panel, see [`row_height`].
    pub fn tall(&self, usual: f64, room: (f64, f64)) -> f64 {
        row_height(usual, self.rows(), room)
    }

    /// Returns the width of the figure.
    pub fn width(&self) -> f64 {
        self.left + self.columns as f64 * (self.each + self.gap) - self.gap + self.right
    }

    /// Whether panel `k` is the first of its row.
    pub fn begins_row(&self, k: usize) -> bool {
        k.is_multiple_of(self.columns)
    }
}

/// Returns the height of each of `rows` rows of panels \[mm\]: `usual`, or less if a page has no room for them with `between` two rows and `other`
/// for everything else.
pub fn row_height(usual: f64, rows: f64, (between, other): (f64, f64)) -> f64 {
    usual.min((page_height() - other + between) / rows - between).max(LOWEST)
}

/// The letter of a panel by its index: a to z, then aa, ab and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Letter(usize);

impl Display for Letter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(before) = (self.0 / 26).checked_sub(1) {
            write!(f, "{}", Self(before))?;
        }
        f.write_char(char::from(b'a' + (self.0 % 26) as u8))
    }
}

/// Returns the letter of panel `k` of a figure; a single panel has none.
pub fn letter(k: usize, count: usize) -> Option<Letter> {
    (count > 1).then_some(Letter(k))
}

/// Returns the heading of a panel with its letter: `(b)  Cable tension`.
pub fn heading(letter: Option<Letter>, words: &str) -> String {
    letter.map_or_else(|| words.into(), |letter| format!("({letter})  {words}"))
}

/// Draws the heading of a panel above its upper left corner, as wide as the panel; a long one takes two lines.
pub fn headed(area: &Area, (left, top): Point, wide: i32, letter: Option<Letter>, words: &str) {
    let (size, lines) = heading_lines(&heading(letter, words), wide + mm(2.0));
    match &lines[..] {
        [first, second] => {
            text(area, first, (left, top - mm(4.55)), At::Left, size, INK);
            text(area, second, (left, top - mm(1.7)), At::Left, size, INK);
        }
        lines => lines.iter().for_each(|line| text(area, line, (left, top - mm(2.4)), At::Left, size, INK)),
    }
}

/// Smallest width and height at which a panel is readable \[mm\].
const MINIMUM: f64 = 20.0;
const LOWEST: f64 = 20.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::style::{Style, within};

    #[test]
    fn a_single_panel_has_no_letter() {
        assert_eq!(heading(letter(0, 1), "Lift"), "Lift");
        assert_eq!(heading(letter(1, 2), "Lift"), "(b)  Lift");
    }

    #[test]
    fn no_two_panels_have_one_letter() {
        let of = |k: usize| letter(k, 800).expect("of many panels").to_string();
        assert_eq!([0, 25, 26, 27, 51, 52, 701, 702].map(of), ["a", "z", "aa", "ab", "az", "ba", "zz", "aaa"]);
    }

    #[test]
    fn a_frame_is_in_the_column_and_the_row_of_its_panel() {
        let p = Panels { count: 5, columns: 2, each: 50.0, left: 15.0, gap: 20.0, right: 5.0 };
        assert_eq!(p.frame(0, (6.0, 60.0), 40.0), [15.0, 6.0, 65.0, 46.0]);
        assert_eq!(p.frame(3, (6.0, 60.0), 40.0), [85.0, 66.0, 135.0, 106.0]);
    }

    #[test]
    fn panels_are_as_wide_as_the_page_and_never_wider() {
        for (style, columns) in [("default", 2), ("two-column", 2), ("one-column", 1), ("slides", 1)] {
            let style = Style::named(style, None, None).expect("a style");
            let p = within(style, || Panels::new(2, (15.0, 18.0, 3.0), (60.0, 200.0)));
            assert_eq!(p.columns, columns);
            assert!((p.width() - style.sheet()).abs() < 1e-9, "{p:?}");
            let one = within(style, || Panels::new(2, (15.0, 18.0, 3.0), (60.0, 40.0)));
            assert!(one.each == 40.0 && one.width() < style.sheet(), "{one:?}");
        }
    }
}
