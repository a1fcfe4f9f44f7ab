//! Savings by the choice of element: error of one line per formulation, over the number of cells (top) and over CPU seconds (bottom).

use crate::report::canvas::{INK, Mark, Point, columns, figure, hollow, line, mark, mm, page_width};
use crate::report::figure::{Figure, Sample, legend_below, legend_lines};
use crate::report::numbers::capital;
use crate::report::panels::{letter, row_height};
use crate::report::plot::{Axis, BELOW, Plot};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::figures::first_of;
use crate::study::figures::work_precision::{level_entries, levels};
use crate::study::kinds::convergence::figures::errors::{ERROR, against_refused, uncertainty};
use crate::study::kinds::convergence::figures::look::{self, look};
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use crate::study::store::record::Role;
use crate::study::store::results::Results;

/// Largest number of quantities that are drawn.
const MOST: usize = 2;
const LEFT: f64 = 14.0;
const GAP: f64 = 16.0;
const TOP: f64 = 6.0;
/// Height of a panel, usually and with many on a page \[mm\]
const TALL: f64 = 50.0;
/// Smallest width of a panel \[mm\]
const LEAST: f64 = 60.0;
/// Distance from a frame to the one below it, for numbers, label and title \[mm\].
const BETWEEN: f64 = 18.0;

/// One mesh of one family.
struct CurvePoint {
    cells: f64,
    seconds: f64,
    /// Error of the peak \[%\]
    error: f64,
    flagged: bool,
}

/// The cases of one family in the order of their cells.
struct FormulationCurve {
    family: usize,
    dots: Vec<CurvePoint>,
}

fn lines(store: &Results, q: &ByQuantity<MeshErrors>) -> Vec<FormulationCurve> {
    let families = store.study.families.iter().enumerate();
    let lines = families.filter(|(_, f)| matches!(f.role, Role::Sizes | Role::Element)).map(|(family, f)| {
        let dot = |id: &String| {
            let error = 100.0 * q.errors.iter().find(|e| e.id == *id)?.error;
            let r = &store.cases.iter().find(|c| c.record.id == *id)?.record;
            let flagged = r.locking.is_some_and(|l| l.alarm);
            Some(CurvePoint { cells: r.mesh.cells as f64, seconds: r.cpu_s, error, flagged })
        };
        let mut dots: Vec<CurvePoint> =
            f.cases.iter().filter_map(dot).filter(|d| d.error.is_finite() && d.seconds > 0.0).collect();
        dots.sort_by(|a, b| a.cells.total_cmp(&b.cells));
        FormulationCurve { family, dots }
    });
    lines.filter(|l| l.dots.len() > 1).collect()
}

/// Draws the comparison; `None` unless two formulations were run on two meshes each.
pub fn draw(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Option<Figure> {
    let tolerance = 100.0 * analysis.tolerance;
    let has_errors = |(_, lines): &(_, Vec<FormulationCurve>)| {
        Axis::below(lines.iter().flat_map(|l| &l.dots).map(|d| d.error), tolerance).is_none()
    };
    let deciding = analysis.quantities.iter().filter(|q| q.deciding).map(|q| (q, lines(store, q)));
    let mut shown: Vec<(&ByQuantity<MeshErrors>, Vec<FormulationCurve>)> = deciding.filter(has_errors).collect();
    let more = first_of(shown.len(), MOST, "quantities");
    shown.truncate(MOST);
    let formulation = |l: &FormulationCurve| &store.study.families[l.family].formulation;
    let several = |lines: &[FormulationCurve]| lines.iter().any(|l| formulation(l) != formulation(&lines[0]));
    if !shown.iter().any(|(_, lines)| several(lines)) {
        return None;
    }
    let dots = || shown.iter().flat_map(|(_, lines)| lines.iter().flat_map(|l| &l.dots));
    let used = shown.iter().flat_map(|(_, lines)| lines.iter().map(|l| l.family));
    let mut entries = look::entries(&store.study.families, used);
    if dots().any(|d| d.flagged) {
        entries.push((Sample::Hollow(Mark::Circle, INK), "open: locking alarm".into()));
    }
    entries.extend(level_entries());
    let y = Axis::of_errors(dots().map(|d| d.error), tolerance, 0.0, ERROR);
    type Abscissa = fn(&CurvePoint) -> f64;
    let sizes: [(Abscissa, &str); 2] = [(|d| d.cells, "cells"), (|d| d.seconds, "CPU time of the case [s]")];
    let columns = columns(2, (LEFT + 5.0, GAP, LEAST));
    let each = (page_width() - LEFT - 5.0 - GAP * (columns - 1) as f64) / columns as f64;
    let rows = sizes.len() * shown.len().div_ceil(columns);
    let across = page_width() - LEFT;
    let foot = 12.5 + 4.2 * legend_lines(&entries, across);
    let tall = row_height(TALL, rows as f64, (BETWEEN, TOP + foot));
    let below = TOP + rows as f64 * (tall + BETWEEN) - BETWEEN;
    let height = below + foot;
    let svg = figure(page_width(), height, "", |area| {
        for (column, (q, lines)) in shown.iter().enumerate() {
            for (row, (x, name)) in sizes.iter().enumerate() {
                let (i, j) = if columns == 1 { (0, sizes.len() * column + row) } else { (column, row) };
                let (left, top) = (LEFT + i as f64 * (each + GAP), TOP + j as f64 * (tall + BETWEEN));
                let frame = [mm(left), mm(top), mm(left + each), mm(top + tall)];
                let plot = Plot { area, frame, x: Axis::log(dots().map(x), name), y: y.clone() };
                levels(&plot, uncertainty(q), tolerance);
                lines.iter().for_each(|l| curve(&plot, l, x));
                plot.axes(true);
                let k = if columns == 1 { j } else { shown.len() * row + column };
                plot.title(letter(k, sizes.len() * shown.len()), &capital(&q.title()));
            }
        }
        legend_below(area, (LEFT, below + 13.5), across, entries);
    });
    let below = if columns == 1 { "below each" } else { "bottom" };
    let caption = format!(
        "Error of the peak against the reference value, one line a formulation: over the number of cells (top) \
         and over the CPU seconds of the case ({below}). Open marks raise the locking alarm. Errors in the grey \
         zone are smaller than the uncertainty of the reference; {BELOW}.{more}{}",
        against_refused(shown.iter().map(|(q, _)| *q))
    );
    Some(Figure { name: "formulations".into(), svg, caption })
}

/// Draws marks, with a line through those that are not pinned to the axis because their error is below it.
fn curve(plot: &Plot, l: &FormulationCurve, x: &fn(&CurvePoint) -> f64) {
    let (shape, color) = look(l.family);
    let place = |d: &CurvePoint| plot.floored(x(d), d.error);
    for part in l.dots.split(|d| d.error < plot.y.lo) {
        line(plot.area, &part.iter().map(place).collect::<Vec<Point>>(), color, 8);
    }
    for d in &l.dots {
        if d.flagged {
            hollow(plot.area, shape, place(d), 28, color);
        } else {
            mark(plot.area, shape, place(d), 28, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors far below the uncertainty of the reference are drawn at their heights. The mesh of the reference has no error: its mark is on the axis,
    /// below all others, and the line ends before it.
    #[test]
    fn marks_are_at_the_heights_of_their_errors() {
        let errors = [20.0, 0.116, 0.19, 0.0];
        let dot =
            |(k, error): (usize, f64)| CurvePoint { cells: 10.0 * (k + 1) as f64, seconds: 1.0, error, flagged: false };
        let series = FormulationCurve { family: 0, dots: errors.into_iter().enumerate().map(dot).collect() };
        let y = Axis::of_errors(errors.into_iter(), 3.0, 0.0, ERROR);
        let frame = [mm(10.0), mm(5.0), mm(50.0), mm(40.0)];
        let mut wanted = vec![];
        let svg = figure(60.0, 50.0, "", |area| {
            let x = Axis::log(series.dots.iter().map(|d| d.cells), "cells");
            let plot = Plot { area, frame, x, y: y.clone() };
            let cells: fn(&CurvePoint) -> f64 = |d| d.cells;
            curve(&plot, &series, &cells);
            let of = |d: &CurvePoint| plot.at(d.cells, if d.error == 0.0 { y.lo } else { d.error });
            wanted = series.dots.iter().map(of).map(|(x, y)| format!("{x},{y}")).collect();
        });
        let marks: Vec<String> = (svg.split("<circle cx=\"").skip(1))
            .filter_map(|rest| {
                rest.split_once("\" cy=\"").and_then(|(x, rest)| Some(format!("{x},{}", rest.split('"').next()?)))
            })
            .collect();
        assert_eq!(marks, wanted, "{svg}");
        assert!(marks[3].ends_with(&format!(",{}", frame[3])), "{marks:?}");
        let lines: Vec<Vec<&str>> = svg
            .split("points=\"")
            .skip(1)
            .filter_map(|rest| Some(rest.split('"').next()?.split_whitespace().collect()))
            .collect();
        assert_eq!(lines, [marks[..3].iter().map(String::as_str).collect::<Vec<_>>()], "{svg}");
    }
}
