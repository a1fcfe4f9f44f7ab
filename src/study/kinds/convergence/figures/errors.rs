//! Error against h with the fitted orders, and error against seconds with the Pareto front.

use crate::report::canvas::{Area, At, GREY, INK, SMALL, italic, line, mark, text};
use crate::report::figure::{Figure, Sample};
use crate::report::measure::width;
use crate::report::numbers::capital;
use crate::report::panels::Letter;
use crate::report::plot::{Axis, BELOW, Plot, without_panel};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::estimate::family::Estimate;
use crate::study::figures::sheet::Sheet;
use crate::study::figures::work_precision::{self, CostPoint, level_entries, levels};
use crate::study::figures::{PANELS, first_of};
use crate::study::kinds::convergence::figures::look::{self, Look, look};
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use crate::study::store::record::{CaseRecord, Role};
use crate::study::store::results::Results;
use crate::wording::all;

const SHEET: Sheet = Sheet { left: 14.0, gap: 16.0, least: 42.0, tall: 46.0, legend: 13.5, foot: 12.5 };

/// Label of the axis of errors
pub(super) const ERROR: &str = "error [%]";

/// One case in one panel.
struct ErrorDot<'a> {
    record: &'a CaseRecord,
    family: usize,
    error: f64,
    bar: f64,
    cost: f64,
}

/// A quantity with the dots of its cases.
type Dotted<'a> = (&'a ByQuantity<MeshErrors>, Vec<ErrorDot<'a>>);

fn dots<'a>(store: &'a Results, q: &ByQuantity<MeshErrors>) -> Vec<ErrorDot<'a>> {
    (q.errors.iter())
        .filter_map(|e| {
            let case = store.cases.iter().find(|c| c.record.id == e.id)?;
            let (of, record) = (store.study.family_of(case, Some(&q.variant))?, &case.record);
            let family = store.study.families.iter().position(|f| f.name == of.name)?;
            Some(ErrorDot { record, family, error: 100.0 * e.error, bar: 100.0 * e.bar, cost: record.cpu_s })
        })
        .collect()
}

/// The common layout: one panel per deciding quantity with a reference, the legend below, and the part of the caption about quantities without a
/// panel.
fn sheet(
    store: &Results,
    analysis: &Analysis<ConvergenceFindings>,
    extra: Vec<(Sample, String)>,
    panel: impl Fn(&Area, [i32; 4], Option<Letter>, &ByQuantity<MeshErrors>, &[ErrorDot]),
) -> Option<(String, String)> {
    let below = |dots: &[ErrorDot]| Axis::below(dots.iter().map(|d| d.error), 100.0 * analysis.tolerance);
    let deciding = analysis.quantities.iter().filter(|q| q.deciding).map(|q| (q, dots(store, q)));
    let (small, mut shown): (Vec<Dotted>, Vec<Dotted>) =
        deciding.filter(|(_, dots)| !dots.is_empty()).partition(|(_, dots)| below(dots).is_some());
    let more = first_of(shown.len(), PANELS, "quantities");
    shown.truncate(PANELS);
    if shown.is_empty() {
        return None;
    }
    let small: Vec<(String, f64)> = small.iter().filter_map(|(q, dots)| Some((q.title(), below(dots)?))).collect();
    let used = shown.iter().flat_map(|(_, dots)| dots.iter().map(|d| d.family));
    let mut entries = look::entries(&store.study.families, used);
    entries.extend(extra);
    let svg = SHEET.draw(&shown, entries, |(q, dots), area, frame, letter| panel(area, frame, letter, q, dots));
    Some((svg, more + &without_panel(&small) + &against_refused(shown.iter().map(|(q, _)| *q))))
}

/// The end of a caption if errors of these quantities are drawn against a refused family, because all families are refused.
pub(super) fn against_refused<'a>(drawn: impl Iterator<Item = &'a ByQuantity<MeshErrors>>) -> String {
    let titles: Vec<String> =
        drawn.filter(|q| q.has_refused_reference()).map(|q| format!("the {}", q.title())).collect();
    if titles.is_empty() {
        return String::new();
    }
    format!(
        " No family can be a reference of {}: these errors are distances from the limit of one that is refused, and no claim.",
        all(&titles)
    )
}

/// Returns U(f*) \[%\]; `None` without a reference.
pub(super) fn uncertainty(q: &ByQuantity<MeshErrors>) -> Option<f64> {
    q.reference.as_ref().map(|r| 100.0 * r.uncertainty / r.scale)
}

/// The parts of |y(x)| above the lower edge of a logarithmic axis. Each part ends at the edge if the curve continues below it; y may change its sign.
fn parts_above(curve: &[(f64, f64)], edge: f64) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = vec![];
    for pair in curve.windows(2) {
        for sign in [1.0, -1.0] {
            let [(xa, ya), (xb, yb)] = [pair[0], pair[1]].map(|(x, y)| (x, sign * y));
            if ya < edge && yb < edge {
                continue;
            }
            let at_edge = (xa + (xb - xa) * (edge - ya) / (yb - ya), edge);
            let from = if ya < edge { at_edge } else { (xa, ya) };
            let to = if yb < edge { at_edge } else { (xb, yb) };
            match parts.last_mut() {
                Some(part) if part.last() == Some(&from) => part.push(to),
                _ => parts.push(vec![from, to]),
            }
        }
    }
    parts
}

/// The index of a family in the study.
fn number(store: &Results, family: &str) -> usize {
    store.study.families.iter().position(|f| f.name == family).unwrap_or(0)
}

/// The orders used for the limits of the families, in lines at the head of a panel.
struct Orders {
    /// Text of each entry with the mark of its family
    words: Vec<(Look, String)>,
    /// Width of an entry \[units\]
    each: i32,
    columns: usize,
}

impl Orders {
    /// Offset of the first mark from the edge of a panel, and of the text from its mark \[units\]
    const EDGE: i32 = 60;
    const WORDS: i32 = 45;
    /// Offset of the first line from the top of a panel, and of each further line \[units\]
    const FIRST: i32 = 60;
    const NEXT: i32 = 85;

    fn new(store: &Results, q: &ByQuantity<MeshErrors>, wide: i32) -> Self {
        let order = |e: &Estimate| {
            let p = e.order_of_limit()?;
            Some((look(number(store, &e.family)), format!("{} = {p:.2}", italic("p"))))
        };
        let words: Vec<(Look, String)> = q.estimates.iter().filter_map(order).collect();
        let longest = words.iter().map(|(_, words)| width(words, SMALL)).max().unwrap_or(0);
        let each = Self::WORDS + longest + Self::EDGE;
        Self { words, each, columns: ((wide - Self::EDGE) / each).max(1) as usize }
    }

    /// The fraction of a panel of height `tall` that the lines take.
    fn head(&self, tall: i32) -> f64 {
        match self.words.len().div_ceil(self.columns) {
            0 => 0.0,
            lines => f64::from(Self::FIRST + Self::NEXT * lines as i32) / f64::from(tall),
        }
    }

    fn draw(&self, area: &Area, [left, top, ..]: [i32; 4]) {
        for (k, ((shape, color), words)) in self.words.iter().enumerate() {
            let (line, column) = ((k / self.columns) as i32, (k % self.columns) as i32);
            let (x, y) = (left + Self::EDGE + self.each * column, top + Self::FIRST + Self::NEXT * line);
            mark(area, *shape, (x, y), 24, *color);
            text(area, words, (x + Self::WORDS, y), At::Left, SMALL, INK);
        }
    }
}

/// Draws the power laws of the families where they are above the lower edge.
fn power_laws(plot: &Plot, store: &Results, q: &ByQuantity<MeshErrors>) {
    let Some((reference, scale)) = q.reference.as_ref().map(|r| (r.value, r.scale)) else { return };
    for e in &q.estimates {
        let (a, b) = (e.h_m[0], e.h_m[e.h_m.len() - 1]);
        let hs = (0..=60).map(|k| a * (b / a).powf(f64::from(k) / 60.0));
        let curve: Vec<_> = hs
            .filter_map(|h| Some((1e3 * h, 100.0 * (e.power_law(h)? - reference) / scale)))
            .filter(|(_, y)| y.abs() <= plot.y.hi)
            .collect();
        for part in parts_above(&curve, plot.y.lo) {
            let path: Vec<_> = part.into_iter().map(|(h, y)| plot.at(h, y)).collect();
            line(plot.area, &path, look(number(store, &e.family)).1, 7);
        }
    }
}

/// Draws the scatter of the seeds about their mean, as it shifts the error.
fn scatter(plot: &Plot, store: &Results, q: &ByQuantity<MeshErrors>) {
    for (n, r) in q.noise.iter().filter_map(|n| Some((n, q.reference.as_ref()?))) {
        let color = look(number(store, &n.family)).1;
        let off = (n.mean - r.value).abs();
        let end = |sign: f64| (100.0 * (off + sign * 0.5 * n.scatter) / r.scale).clamp(plot.y.lo, plot.y.hi);
        let (a, b) = (plot.at(1e3 * n.h_m, end(-1.0)), plot.at(1e3 * n.h_m, end(1.0)));
        line(plot.area, &[a, b], color, 8);
        for p in [a, b] {
            line(plot.area, &[(p.0 - 30, p.1), (p.0 + 30, p.1)], color, 8);
        }
    }
}

pub fn against_h(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Option<Figure> {
    let tolerance = 100.0 * analysis.tolerance;
    let mut extra = Vec::from(level_entries());
    let fits = |q: &ByQuantity<MeshErrors>| q.estimates.iter().any(|e| e.order_of_limit().is_some());
    if analysis.quantities.iter().any(|q| q.deciding && q.reference.is_some() && fits(q)) {
        extra.insert(0, (Sample::Line(GREY), format!("fit of order {}", italic("p"))));
    }
    let (svg, more) = sheet(store, analysis, extra, |area, frame, letter, q, dots| {
        let h = |d: &ErrorDot| 1e3 * d.record.mesh.h_m;
        let x = Axis::log(dots.iter().map(h), &format!("{} [mm]", italic("h")));
        let [l, t, r, b] = frame;
        let orders = Orders::new(store, q, r - l);
        let y = Axis::of_errors(dots.iter().map(|d| d.error), tolerance, orders.head(b - t), ERROR);
        let plot = Plot { area, frame, x, y };
        levels(&plot, uncertainty(q), tolerance);
        power_laws(&plot, store, q);
        scatter(&plot, store, q);
        for d in dots {
            let (shape, color) = look(d.family);
            mark(area, shape, plot.floored(h(d), d.error), 26, color);
        }
        plot.axes(true);
        plot.title(letter, &capital(&q.title()));
        orders.draw(area, frame);
    })?;
    let drawn = || analysis.quantities.iter().filter(|q| q.deciding && q.reference.is_some()).take(PANELS);
    let orders = if drawn().any(fits) {
        ", with the order p that the limit f* of a family is found with, where there is one"
    } else {
        ""
    };
    let seeds = if drawn().any(|q| !q.noise.is_empty()) { "; the bar is the scatter of the seeds" } else { "" };
    let caption = format!(
        "Error of the peak against the reference value over the mean cell size h, the cube root of volume by cells{orders}{seeds}. Errors in the grey zone are smaller than the uncertainty of the reference; {BELOW}.{more}"
    );
    Some(Figure { name: "error-h".into(), svg, caption })
}

pub fn against_cost(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Option<Figure> {
    let tolerance = 100.0 * analysis.tolerance;
    // Seeds only show the scatter; a lucky one is not a setting to choose
    let is_seed = |d: &ErrorDot| store.study.families[d.family].role == Role::Seeds;
    let setting = |d: &ErrorDot| {
        let ErrorDot { cost, error, bar, .. } = *d;
        CostPoint { cost, error, bar, look: look(d.family), may_be_chosen: !is_seed(d) }
    };
    let extra = work_precision::entries().collect();
    let (svg, more) = sheet(store, analysis, extra, |area, frame, letter, q, dots| {
        let x = Axis::log(dots.iter().map(|d| d.cost), "CPU time [s]");
        let y = Axis::of_errors(dots.iter().flat_map(|d| [d.error, d.bar]), tolerance, 0.0, ERROR);
        let plot = Plot { area, frame, x, y };
        levels(&plot, uncertainty(q), tolerance);
        work_precision::draw(&plot, &dots.iter().map(setting).collect::<Vec<_>>());
        plot.axes(true);
        plot.title(letter, &capital(&q.title()));
    })?;
    let caption = format!(
        "Work and precision: error of the peak (mark) and its error bar with U(f*) (whisker) over the CPU time of the case; {BELOW}.{more}"
    );
    Some(Figure { name: "work-precision".into(), svg, caption })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_ends_at_the_lower_edge_on_both_sides_of_its_zero() {
        let parts = parts_above(&[(0.0, 4.0), (1.0, 2.0), (2.0, -2.0), (3.0, -0.5), (4.0, -0.25)], 1.0);
        let left = vec![(0.0, 4.0), (1.0, 2.0), (1.25, 1.0)];
        let right = vec![(1.75, 1.0), (2.0, 2.0), (2.0 + 1.0 / 1.5, 1.0)];
        assert_eq!(parts, [left, right]);
        assert!(parts_above(&[(0.0, 0.1), (1.0, 0.2)], 1.0).is_empty());
    }
}
