//! How a table fits into the width of the text: the size of its type, broken headings and texts, what is the same in every row, and parts.

use super::column::Column;
use crate::report::table::Table;
use std::collections::HashSet;

/// Width of the text of an article in one column, less what widths are estimated too small by \[pt\].
const LINE: f64 = 345.0 - 4.0;

/// Characters of a cell that may move into the caption.
const LONGEST_IN_CAPTION: usize = 40;

/// A size of type.
#[derive(Clone, Copy)]
pub struct Size {
    pub command: &'static str,
    /// Width of a text as a share of that in the usual size
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
/// Size of type of a table in parts, which need not be the smallest one.
const OF_PARTS: Size = SIZES[2];

/// Columns next to each other, by their numbers, with their widths in the usual size of type \[pt\].
pub type ColumnGroup = Vec<(usize, f64)>;

/// How a table is set.
pub struct Layout {
    pub size: Size,
    /// Parts below each other, each of which begins with the columns that tell its rows apart
    pub parts: Vec<ColumnGroup>,
    /// Headings with units and cells of the columns that are the same in every row and are named in the caption
    pub same: Vec<(String, String)>,
}

impl Layout {
    /// The layout with the largest type in which nothing is broken, moved or divided that fits as a whole.
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

    /// Texts in paragraphs take the width that is left in their part.
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
    /// Width of a column in this size with the space around it, by its width in the usual size \[pt\].
    fn room(self, width: f64) -> f64 {
        self.scale * width + 2.0 * self.gap
    }
}

/// As many of the columns in each part as fit next to the leading ones that tell its rows apart; next to the first one where these leave no room.
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

/// The least number of leading columns that are not alike in any two rows; none where only all columns are, or rows are the same.
fn leading(t: &Table, shown: &[usize]) -> Option<usize> {
    (1..shown.len()).find(|n| {
        let mut seen = HashSet::new();
        t.rows.iter().all(|row| seen.insert(shown[..*n].iter().map(|k| &row[*k]).collect::<Vec<_>>()))
    })
}
