//! A sheet of equal panels in rows, with one legend for all of them below.

use crate::report::canvas::{Area, figure, mm};
use crate::report::figure::{LINE, Sample, legend_below, legend_lines};
use crate::report::panels::{Letter, Panels, letter};

/// Margin at the right of a row and above the first one \[mm\]
const RIGHT: f64 = 5.0;
const TOP: f64 = 6.0;
/// Distance between two rows of panels \[mm\]
const BETWEEN: f64 = 19.0;
/// Largest width of a panel \[mm\]
const EACH: f64 = 70.0;

/// Dimensions of the sheet \[mm\].
pub struct Sheet {
    /// Margin at the left of a row
    pub left: f64,
    /// Distance between two panels of a row
    pub gap: f64,
    /// Smallest width of a panel
    pub least: f64,
    /// Height of a panel, which is reduced if a page has no room for all rows
    pub tall: f64,
    /// Distance from the last row to the first line of the legend
    pub legend: f64,
    /// Distance from the last row to the lower edge, without the lines of the legend
    pub foot: f64,
}

impl Sheet {
    /// Draws a panel for each of `shown`; `paint` draws into its frame, with its letter.
    pub fn draw<T>(
        &self,
        shown: &[T],
        entries: Vec<(Sample, String)>,
        paint: impl Fn(&T, &Area, [i32; 4], Option<Letter>),
    ) -> String {
        let panels = Panels::new(shown.len(), (self.left, self.gap, RIGHT), (self.least, EACH));
        let across = panels.width() - self.left;
        let foot = self.foot + LINE * legend_lines(&entries, across);
        let tall = panels.tall(self.tall, (BETWEEN, TOP + foot));
        let row = tall + BETWEEN;
        let bottom = TOP + row * panels.rows() - BETWEEN;
        figure(panels.width(), bottom + foot, "", |area| {
            for (k, of) in shown.iter().enumerate() {
                paint(of, area, panels.frame(k, (TOP, row), tall).map(mm), letter(k, shown.len()));
            }
            legend_below(area, (self.left, bottom + self.legend), across, entries);
        })
    }
}
