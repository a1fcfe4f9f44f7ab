//! Common parts of figures: the figure itself, its legend, marks and colours by number.

use crate::report::canvas::{
    Area, At, INK, MARKS, Mark, PALETTE, Point, RGB, SMALL, dashed, line, mark, mm, page_width, text, width_mm,
};
use crate::report::error::ReportError;
use crate::report::measure::{shortened, width_in_mm};
use crate::report::names;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A drawn figure: file name, SVG, and what it shows.
pub struct Figure {
    pub name: String,
    pub svg: String,
    pub caption: String,
}

impl Figure {
    /// Returns the width that it was drawn for \[mm\].
    pub fn width_mm(&self) -> f64 {
        width_mm(&self.svg)
    }
}

/// A figure, or the reason why it could not be drawn.
pub type Drawn = Result<Figure, ReportError>;

/// Draws a figure. A panic while drawing does not abort the report.
pub fn drawn<F: Into<Option<Figure>>>(name: &str, draw: impl FnOnce() -> F) -> Option<Drawn> {
    let outcome = catch_unwind(AssertUnwindSafe(|| draw().into()));
    outcome.map_or_else(|_| Some(Err(ReportError::drawing(name))), |figure| figure.map(Ok))
}

/// Returns the name of one sheet of a figure, and the part number for its caption, which is empty for a single sheet.
pub fn numbered(name: &str, sheet: usize, of: usize) -> (String, String) {
    match of {
        1 => (name.into(), String::new()),
        _ => (format!("{name}-{}", sheet + 1), format!(" (part {} of {of})", sheet + 1)),
    }
}

/// Appearance of the sample of a legend entry.
pub enum Sample {
    Line(RGB),
    Dashed(RGB),
    /// A line with the colour and the dashes of this number
    Stroke(usize),
    Mark(Mark, RGB),
    Hollow(Mark, RGB),
    Block(RGB),
    /// No sample: the text continues that of the entry above
    Nothing,
}

/// Draws a legend downwards from a point outside the data.
pub fn legend(area: &Area, (x, mut y): Point, entries: &[(Sample, String)]) {
    for (sample, words) in entries {
        let (a, b) = ((x, y), (x + mm(5.0), y));
        match sample {
            Sample::Line(c) => line(area, &[a, b], *c, 12),
            Sample::Dashed(c) => dashed(area, &[a, b], *c, 12, 28.0),
            Sample::Stroke(k) => stroke(area, &[a, b], *k, 12),
            Sample::Mark(m, c) => mark(area, *m, (x + mm(2.5), y), 26, *c),
            Sample::Hollow(m, c) => crate::report::canvas::hollow(area, *m, (x + mm(2.5), y), 24, *c),
            Sample::Nothing => {}
            Sample::Block(c) => crate::report::canvas::block(area, (x, y - mm(1.1)), (x + mm(5.0), y + mm(1.1)), *c),
        }
        // A long name ends at the edge of the sheet
        let room = area.dim_in_pixel().0 as i32 - x - mm(6.5) - 6;
        text(area, &shortened(words, SMALL, room), (x + mm(6.5), y), At::Left, SMALL, INK);
        y += mm(4.2);
    }
}

/// Draws a legend in the corner of a frame that contains the fewest lines and marks.
pub fn legend_inside(area: &Area, frame: [i32; 4], drawn: &[Vec<Point>], entries: &[(Sample, String)]) {
    let size = (mm(legend_width(entries)), mm(LINE * (entries.len() as f64 - 1.0)));
    legend(area, emptiest(frame, size, drawn), entries);
}

/// Distance of a legend inside a frame from its sides \[mm\].
const INSIDE: f64 = 3.0;

/// The start of a legend of this size, from its first to its last line, in the corner of a frame with the fewest points of the lines.
fn emptiest([left, top, right, bottom]: [i32; 4], (wide, tall): (i32, i32), drawn: &[Vec<Point>]) -> Point {
    let inside = mm(INSIDE);
    let [x, y] = [[left + inside, right - wide - inside], [top + inside, bottom - tall - inside]];
    let corners = [(x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1])];
    let places: Vec<Point> = drawn.iter().flat_map(|line| along(line)).collect();
    let is_at = |(a, b): Point, p: &Point| {
        (a - inside..=a + wide + inside).contains(&p.0) && (b - inside..=b + tall + inside).contains(&p.1)
    };
    let taken = |corner: &Point| places.iter().filter(|p| is_at(*corner, p)).count();
    corners.into_iter().min_by_key(taken).expect("four corners")
}

/// Points along a line, a few units apart.
fn along(line: &[Point]) -> impl Iterator<Item = Point> {
    let between = |w: &[Point]| {
        let [(a, b), (c, d)] = [w[0], w[1]];
        let n = ((c - a).abs().max((d - b).abs()) / mm(1.0)).clamp(1, 1000);
        (0..n).map(move |k| (a + (c - a) * k / n, b + (d - b) * k / n))
    };
    line.windows(2).flat_map(between).chain(line.last().copied())
}

/// Smallest distance between columns of a legend below the panels \[mm\].
const ENTRY: f64 = 40.5;
/// Distance between lines of a legend \[mm\].
pub const LINE: f64 = 4.2;

/// Returns the number of lines of a legend below panels with this width \[mm\].
pub fn legend_lines(entries: &[(Sample, String)], width: f64) -> f64 {
    entries.len().div_ceil(columns(entries, width).0) as f64
}

/// Returns the width that a legend needs \[mm\]: sample, longest name and a margin.
pub fn legend_width(entries: &[(Sample, String)]) -> f64 {
    6.5 + entries.iter().map(|(_, words)| width_in_mm(words, SMALL)).fold(0.0, f64::max) + 1.5
}

/// Number of columns of a legend and their distance, such that the longest name fits.
fn columns(entries: &[(Sample, String)], width: f64) -> (usize, f64) {
    let each = legend_width(entries).max(ENTRY).min(width);
    (((width / each + 1e-9).floor() as usize).max(1), each)
}

/// Draws a legend below panels, starting at a point \[mm\], in as many columns as fit into `width`.
pub fn legend_below(area: &Area, (left, top): (f64, f64), width: f64, entries: Vec<(Sample, String)>) {
    let (columns, each) = columns(&entries, width);
    for (k, entry) in entries.into_iter().enumerate() {
        let at = (left + each * (k % columns) as f64, top + LINE * (k / columns) as f64);
        legend(area, (mm(at.0), mm(at.1)), &[entry]);
    }
}

/// Dash lengths of lines by number, the first being solid \[units\]; neighbours differ even without colour.
const DASHES: [f64; 4] = [0.0, 18.0, 8.0, 60.0];

/// Draws a line in the colour and with the dashes of a number; there are 28 different lines.
pub fn stroke(area: &Area, points: &[Point], number: usize, width: u32) {
    let color = PALETTE[number % PALETTE.len()];
    match DASHES[number % DASHES.len()] {
        0.0 => line(area, points, color, width),
        dash => dashed(area, points, color, width, dash),
    }
}

/// Keeps, in order, every point that is at least `apart` \[units\] from all points kept before, so that marks do not overlap.
pub fn apart(points: impl IntoIterator<Item = Point>, apart: i32) -> Vec<Point> {
    let cell = |p: Point| (p.0.div_euclid(apart.max(1)), p.1.div_euclid(apart.max(1)));
    let mut kept: HashMap<Point, Vec<Point>> = HashMap::new();
    let mut out = vec![];
    for p in points {
        let (i, j) = cell(p);
        let is_near = |q: &Point| (p.0 - q.0).pow(2) + (p.1 - q.1).pow(2) < apart * apart;
        let around = (-1..=1).flat_map(|a| (-1..=1).map(move |b| (i + a, j + b)));
        if !around.filter_map(|c| kept.get(&c)).flatten().any(is_near) {
            kept.entry((i, j)).or_default().push(p);
            out.push(p);
        }
    }
    out
}

/// Layout of a column of panels and its legend \[mm\]: side by side, or stacked on a narrow page, so that the type size is never reduced.
pub struct WithLegend {
    /// Width of the panels
    pub wide: f64,
    /// Position of the first line of the legend
    pub legend: (f64, f64),
    /// Width and height of the figure
    pub size: (f64, f64),
}

impl WithLegend {
    /// Places a legend of `lines` lines for panels from `left` and `top` down to `bottom`, where their last axis ends.
    pub fn new((left, top, bottom): (f64, f64, f64), lines: f64) -> Self {
        let page = page_width();
        if page < 180.0 {
            let size = (page, bottom + 3.0 + LINE * lines);
            return Self { wide: page - left - 4.0, legend: (left, bottom + 3.0), size };
        }
        let wide = 100.0_f64.min(page - 62.0);
        Self { wide, legend: (left + wide + 6.0, top + 3.0), size: (page, bottom) }
    }
}

/// Labels a family as `sizes (tet4)`, or just `tet10 mixed` if it is named after its element.
pub fn family_label(family: &str, formulation: &str) -> String {
    let element = names::title(formulation);
    let name = names::family(family);
    if name == element { element } else { format!("{name} ({element})") }
}

/// Colour of a region below the resolution of a reference.
pub const UNRESOLVED: RGB = RGB(0xee, 0xee, 0xee);

/// Returns the mark and colour of the `family`-th family. Each round of the colours starts with another mark, so that no pair repeats before all of
/// them have been used.
pub fn style(family: usize) -> (Mark, RGB) {
    let (marks, colours) = (MARKS.len(), PALETTE.len());
    (MARKS[(family + family / colours) % marks], PALETTE[family % colours])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_that_is_named_after_its_element_is_named_once() {
        let labels = [
            ("tet4_up", "tet4_up"),
            ("tet4 mixed", "tet4_up"),
            ("sizes", "tet4"),
            ("tet10", "tet10_up"),
            ("linear", "tet4"),
        ];
        let shown = ["tet4 mixed", "tet4 mixed", "sizes (tet4)", "tet10 (tet10 mixed)", "linear (tet4)"];
        assert_eq!(labels.map(|(family, element)| family_label(family, element)), shown);
    }

    #[test]
    fn a_legend_is_in_the_corner_without_lines() {
        let (frame, size) = ([0, 0, 2000, 1000], (600, 100));
        let falling = vec![vec![(0, 0), (2000, 1000)]];
        let rising = vec![vec![(0, 1000), (2000, 0)]];
        let start = mm(INSIDE);
        assert_eq!(emptiest(frame, size, &rising), (start, start));
        assert_eq!(emptiest(frame, size, &falling), (2000 - 600 - start, start));
        assert_eq!(
            emptiest(frame, size, &[falling, rising, vec![vec![(0, 0), (2000, 0)]]].concat()).1,
            1000 - 100 - start
        );
    }

    #[test]
    fn forty_nine_families_look_different() {
        let looks: Vec<String> =
            (0..MARKS.len() * PALETTE.len()).map(|k| format!("{:?}", style(k).1) + &place(k)).collect();
        let mut different = looks.clone();
        different.sort();
        different.dedup();
        assert_eq!(different.len(), looks.len());
    }

    #[test]
    fn marks_of_a_curve_are_apart_and_leave_no_gap() {
        let forth: Vec<Point> = (0..500).map(|k| (k, 0)).collect();
        let back: Vec<Point> = (0..500).rev().map(|k| (k, 30)).collect();
        let kept = apart(forth.into_iter().chain(back), 20);
        assert_eq!(kept.len(), 50);
        assert!(kept.windows(2).all(|w| (w[0].0 - w[1].0).abs() <= 20));
        assert_eq!(apart([(0, 0), (100, 0), (1, 0)], 20), [(0, 0), (100, 0)]);
        let peak = (0..1000).map(|k| if k == 501 { (k, -300) } else { (k, 0) });
        assert!(apart(peak, 20).contains(&(501, -300)), "a peak of a single point is shown");
    }

    #[test]
    fn a_legend_has_as_many_columns_as_its_longest_name_allows() {
        let of = |name: &str| vec![(Sample::Nothing, name.to_string()), (Sample::Nothing, "b".into())];
        assert_eq!(legend_lines(&of("a"), 100.0), 1.0);
        assert_eq!(legend_lines(&of(&"a long name ".repeat(4)), 100.0), 2.0);
    }

    fn place(family: usize) -> String {
        let own = std::mem::discriminant(&style(family).0);
        MARKS.iter().position(|m| std::mem::discriminant(m) == own).expect("one of them").to_string()
    }
}
