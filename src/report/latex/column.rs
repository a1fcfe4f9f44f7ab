//! A column of a table: how it is set, and its width.

use super::letters::escape;
use super::units::{Room, number, unit};
use super::widths::{self, longest_piece, pieces, width};
use crate::report::numbers::unsigned_zero;
use crate::report::table::Table;

/// Lines of a heading that is broken.
const HEADING_LINES: f64 = 4.0;
/// Least width of a column whose texts are broken, in the usual size of type \[pt\].
const LEAST_PARAGRAPH: f64 = 75.0;
/// Cells that have no value.
pub(super) const EMPTY: [&str; 3] = ["", "–", "-"];

/// How a column is set.
pub struct Column {
    /// `l`, `r` or the `S` of siunitx
    spec: String,
    /// Words of the heading, the last of which may be its unit, with their source
    words: Vec<(f64, String)>,
    /// Cells are read by siunitx
    numbers: bool,
    /// Width of the widest cell \[pt\]; all widths are those in the usual size of type
    cells: f64,
    /// Width of the widest part of a cell that no line breaks \[pt\]
    piece: f64,
    /// Width of the whole heading \[pt\]
    heading: f64,
    /// It belongs next to the column before: `at, sag`, the time of a value
    pub follows: bool,
}

impl Column {
    /// The column of the table by its number.
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

    /// Its width without a break \[pt\].
    pub fn width(&self) -> f64 {
        self.cells.max(self.heading)
    }

    /// Its width where the heading is broken \[pt\].
    pub fn with_broken_heading(&self) -> f64 {
        let widest = self.words.iter().map(|w| w.0).fold(0.0, f64::max);
        self.cells.max(widest).max(self.heading / HEADING_LINES).min(self.width())
    }

    /// The least width at which its texts can be set in paragraphs \[pt\]; that of a column of numbers is its own.
    pub fn least(&self) -> f64 {
        let whole = self.with_broken_heading();
        if self.cells <= LEAST_PARAGRAPH { whole } else { self.piece.max(LEAST_PARAGRAPH).min(whole) }
    }

    /// Whether its texts are paragraphs in this width \[pt\].
    fn breaks(&self, room: f64) -> bool {
        room < self.cells - 1e-6
    }

    /// Lines of a cell of it in this width \[pt\].
    pub fn lines(&self, cell: &str, room: f64) -> usize {
        if self.breaks(room) { widths::lines(cell, room) } else { 1 }
    }

    /// Its letter in the head of a table, for this width in the usual size of type and the scale of the size that is used.
    pub fn spec(&self, room: f64, scale: f64) -> String {
        if !self.breaks(room) {
            return self.spec.clone();
        }
        format!(">{{\\raggedright\\arraybackslash}}p{{{:.0}pt}}", (room * scale).floor())
    }

    /// Lines of its heading within this width, and the heading \[pt\].
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

    /// A cell of it in this width \[pt\].
    pub fn cell(&self, cell: &str, room: f64) -> String {
        let cell = unsigned_zero(cell);
        if self.breaks(room) {
            let parts: Vec<String> = pieces(cell).map(escape).collect();
            // A line breaks at blanks and hyphens without a command
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
