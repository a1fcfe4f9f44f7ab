//! How a table fits into the text width: type size, broken headings and texts, columns that are equal in every row, and parts.

use super::column::Column;
use crate::report::table::Table;
use std::collections::HashSet;

/// Text width of an article in one column, minus a margin for underestimated widths \[pt\].
const LINE: f64 = 345.0 - 4.0;

/// Largest number of characters of a cell that may move into the caption.
const LONGEST_IN_CAPTION: usize = 40;

/// A type size.
#[derive(Clone, Copy)]
pub struct Size {
    pub command: &'static str,
    /// Width of a text relative to the usual size
    pub scale: f64,
    /// Space on each side of a column \[pt\]
    pub gap: f64,
}

const SIZES: [Size; 4] = [
    Size { command: "\\normalsize", scale: 1.0, gap: 6.0 },
    Size { command: "\\small", scale: 0.94, gap: 4.0 },
    Size { command: "\\footnotesize", scale: 0.87, gap: 3.0 },
    Size { command: "\\scriptsize", scale: 0.82, gap: 3.0 },
];
/// Type size of a table in parts, which need not be the smallest.
const OF_PARTS: Size = SIZES[2];

/// Adjacent columns by index, with their widths in the usual type size \[pt\].
pub type ColumnGroup = Vec<(usize, f64)>;

/// How a table is set.
pub struct Layout {
    pub size: Size,
    /// Parts below each other, each beginning with the columns that identify its rows
    pub parts: Vec<ColumnGroup>,
    /// Headings with units, and cells, of the columns that are equal in every row and are named in the caption
    pub same: Vec<(String, String)>,
}

impl Layout {
    /// Chooses the first of these that fits: the table as it is, with broken headings, with equal columns moved into the caption, with texts set as
    /// paragraphs, or divided into parts; each in the largest type that fits.
    pub fn of(t: &Table, columns: &[Column]) -> Self {
        let fits = |shown: &[usize], wide: fn(&Column) -> f64, sizes: &[Size]| {
            let part: ColumnGroup = shown.iter().map(|k| (*k, wide(&columns[*k]))).collect();
            let size = sizes.iter().copied().find(|size| part.iter().map(|(_, w)| size.room(*w)).sum::<f64>() <= LINE);
            size.map(|size| Self { size, parts: vec![part], same: vec![] })
        };
        let all: Vec<usize> = (0..columns.len()).collect();
        let plain = fits(&all, Column::width, &SIZES[..2]);
        if let Some(layout) = plain.or_else(|| fits(&all, Column::with_broken_heading, &SIZES)) {
            return layout;
        }
        let is_same = |k: usize| {
            let is_short = |cell: &str| cell.chars().count() <= LONGEST_IN_CAPTION;
            let own = k > 0 && !columns[k].follows && t.rows.len() > 1 && is_short(&t.rows[0][k]);
            own && t.rows.iter().all(|row| row[k] == t.rows[0][k])
        };
        let (same, differ): (Vec<usize>, Vec<usize>) = all.iter().partition(|k| is_same(**k));
        let same = same.into_iter().map(|k| (t.heading(k), t.rows[0][k].clone())).collect();
        let layout = fits(&differ, Column::with_broken_heading, &SIZES)
            .or_else(|| fits(&differ, Column::least, &SIZES))
            .unwrap_or_else(|| Self { size: OF_PARTS, parts: divided(t, columns, &differ), same: vec![] });
        Self { same, ..layout }.with_paragraphs_widened(columns)
    }

    /// Widens paragraphs to the width that is left in their part.
    fn with_paragraphs_widened(mut self, columns: &[Column]) -> Self {
        for part in &mut self.parts {
            let left = (LINE - part.iter().map(|(_, w)| self.size.room(*w)).sum::<f64>()) / self.size.scale;
            let wish: Vec<f64> = part.iter().map(|(k, w)| (columns[*k].with_broken_heading() - w).max(0.0)).collect();
            let sum = wish.iter().sum::<f64>();
            let share = if sum > 0.0 { (left / sum).clamp(0.0, 1.0) } else { 0.0 };
            part.iter_mut().zip(wish).for_each(|((_, w), wish)| *w += share * wish);
        }
        self
    }
}

impl Size {
    /// The width of a column in this size including the space around it, from its width in the usual size \[pt\].
    fn room(self, width: f64) -> f64 {
        self.scale * width + 2.0 * self.gap
    }
}

/// Divides the columns into parts. Each part repeats the leading columns that identify its rows, or only the first one where there is no room for
/// all, and takes as many further columns as fit.
fn divided(t: &Table, columns: &[Column], shown: &[usize]) -> Vec<ColumnGroup> {
    let of = |k: &usize| (*k, columns[*k].least());
    let room = |group: &[usize]| group.iter().map(|k| OF_PARTS.room(of(k).1)).sum::<f64>();
    // A column and the one that belongs to it stay together
    let together = |_: &usize, next: &usize| columns[*next].follows;
    let leave_room = |n: &usize| shown[*n..].chunk_by(together).all(|group| room(&shown[..*n]) + room(group) <= LINE);
    let repeated = leading(t, shown).filter(leave_room).unwrap_or(1);
    let Some((keys, others)) = shown.split_at_checked(repeated) else { return vec![] };
    let begun = || keys.iter().map(of).collect::<ColumnGroup>();
    let mut parts = vec![begun()];
    let mut long = room(keys);
    for group in others.chunk_by(together) {
        let wide = room(group);
        if long + wide > LINE && long > room(keys) {
            parts.push(begun());
            long = room(keys);
        }
        long += wide;
        parts.last_mut().expect("a part").extend(group.iter().map(of));
    }
    parts
}

/// The smallest number of leading columns that differ between any two rows; `None` if it takes all columns, or if rows are equal.
fn leading(t: &Table, shown: &[usize]) -> Option<usize> {
    (1..shown.len()).find(|n| {
        let mut seen = HashSet::new();
        t.rows.iter().all(|row| seen.insert(shown[..*n].iter().map(|k| &row[*k]).collect::<Vec<_>>()))
    })
}
