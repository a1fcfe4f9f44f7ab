//! A column of a table: how it is set, and its width.

use super::letters::escape;
use super::units::{Room, number, unit};
use super::widths::{self, longest_piece, pieces, width};
use crate::report::numbers::unsigned_zero;
use crate::report::table::Table;

/// Largest number of lines of a broken heading.
const HEADING_LINES: f64 = 4.0;
/// Smallest width of a column of paragraphs, in the usual type size \[pt\].
const LEAST_PARAGRAPH: f64 = 75.0;
/// Cells without a value.
pub(super) const EMPTY: [&str; 3] = ["", "–", "-"];

/// How a column is set.
pub struct Column {
    /// Column specifier: `l`, `r` or the `S` of siunitx
    spec: String,
    /// Width and source of each word of the heading, the last of which may be its unit
    words: Vec<(f64, String)>,
    /// Whether cells are read by siunitx
    numbers: bool,
    /// Width of the widest cell \[pt\]; all widths are in the usual type size
    cells: f64,
    /// Width of the widest unbreakable part of a cell \[pt\]
    piece: f64,
    /// Width of the whole heading \[pt\]
    heading: f64,
    /// Whether it belongs next to the previous column, such as the time of a value: `at, sag`
    pub follows: bool,
}

impl Column {
    /// Builds the column of a table with this index.
    pub fn of(t: &Table, index: usize) -> Self {
        let (name, si, is_number) = &t.columns[index];
        let cells = || t.rows.iter().filter_map(|row| row.get(index)).map(String::as_str);
        let read: Option<Vec<Option<String>>> = is_number
            .then(|| {
                cells()
                    .map(unsigned_zero)
                    .map(|c| if EMPTY.contains(&c) { Some(None) } else { number(c).map(Some) })
                    .collect()
            })
            .flatten();
        let room = read
            .filter(|read| read.iter().any(Option::is_some))
            .map(|read| read.iter().flatten().fold(Room::default(), |room, n| room.with(n)));
        let spec = match &room {
            Some(room) => room.column(),
            None if *is_number => "r".into(),
            None => "l".into(),
        };
        let mut words: Vec<(f64, String)> = name.split(' ').map(|w| (width(w), escape(w))).collect();
        if !si.is_empty() {
            words.push((width(&format!("[{si}]")), format!("[{}]", unit(si).unwrap_or_else(|| escape(si)))));
        }
        let heading = words.iter().map(|w| w.0).sum::<f64>() + width(" ") * (words.len() - 1) as f64;
        Self {
            spec,
            words,
            numbers: room.is_some(),
            cells: cells().map(width).chain(room.map(Room::width)).fold(0.0, f64::max),
            piece: if room.is_some() { f64::INFINITY } else { cells().map(longest_piece).fold(0.0, f64::max) },
            heading,
            follows: name.starts_with("at, "),
        }
    }

    /// Returns its width without line breaks \[pt\].
    pub fn width(&self) -> f64 {
        self.cells.max(self.heading)
    }

    /// Returns its width with a broken heading \[pt\].
    pub fn with_broken_heading(&self) -> f64 {
        let widest = self.words.iter().map(|w| w.0).fold(0.0, f64::max);
        self.cells.max(widest).max(self.heading / HEADING_LINES).min(self.width())
    }

    /// Returns the smallest width at which its texts can be set as paragraphs \[pt\]; for a column of numbers, its own width.
    pub fn least(&self) -> f64 {
        let whole = self.with_broken_heading();
        if self.cells <= LEAST_PARAGRAPH { whole } else { self.piece.max(LEAST_PARAGRAPH).min(whole) }
    }

    /// Whether its texts become paragraphs in this width \[pt\].
    fn breaks(&self, room: f64) -> bool {
        room < self.cells - 1e-6
    }

    /// Returns the number of lines of a cell in this width \[pt\].
    pub fn lines(&self, cell: &str, room: f64) -> usize {
        if self.breaks(room) { widths::lines(cell, room) } else { 1 }
    }

    /// Returns its column specifier, for this width in the usual type size and the scale of the size that is used.
    pub fn spec(&self, room: f64, scale: f64) -> String {
        if !self.breaks(room) {
            return self.spec.clone();
        }
        format!(">{{\\raggedright\\arraybackslash}}p{{{:.0}pt}}", (room * scale).floor())
    }

    /// Returns the number of lines of its heading within this width \[pt\], and the heading.
    pub fn head(&self, room: f64) -> (usize, String) {
        let joined = |words: &[String]| words.join(" ");
        let mut lines: Vec<(f64, Vec<String>)> = vec![];
        for (wide, source) in &self.words {
            match lines.last_mut().filter(|(long, _)| long + width(" ") + wide <= room + 0.01) {
                Some((long, words)) => {
                    *long += width(" ") + wide;
                    words.push(source.clone());
                }
                None => lines.push((*wide, vec![source.clone()])),
            }
        }
        let side = match (self.numbers, self.spec.as_str()) {
            (true, _) => "c",
            (_, "r") => "r",
            _ => "l",
        };
        let count = lines.len();
        let heading = match lines.as_slice() {
            [(_, words)] => joined(words),
            lines => {
                let lines: Vec<String> = lines.iter().map(|(_, words)| joined(words)).collect();
                format!("\\begin{{tabular}}[b]{{@{{}}{side}@{{}}}}{}\\end{{tabular}}", lines.join("\\\\{}"))
            }
        };
        (count, if self.numbers { format!("{{{heading}}}") } else { heading })
    }

    /// Returns a cell as set in this width \[pt\].
    pub fn cell(&self, cell: &str, room: f64) -> String {
        let cell = unsigned_zero(cell);
        if self.breaks(room) {
            let parts: Vec<String> = pieces(cell).map(escape).collect();
            // Lines break at spaces and hyphens without a command
            let joined =
                parts.iter().enumerate().map(|(k, part)| match part.ends_with([' ', '-']) || k + 1 == parts.len() {
                    true => part.clone(),
                    false => format!("{part}\\allowbreak{{}}"),
                });
            return joined.collect();
        }
        match number(cell) {
            Some(number) if self.numbers => number,
            _ if self.numbers => format!("{{{}}}", escape(cell)),
            _ => escape(cell),
        }
    }
}
