//! The measured curves together with the scenes that reproduce them, the residuals below, and the constants case by case.

use crate::calibrate::inverse::FittedCurve;
use crate::report::canvas::{
    Area, At, GREY, INK, LABEL, Mark, PALETTE, dashed, figure, hollow, italic, line, mark, mm, page_width, text,
};
use crate::report::figure::{Figure, Sample, apart, legend_inside, numbered};
use crate::report::numbers::capital;
use crate::report::panels::{Letter, letter};
use crate::report::plot::{Axis, Plot};
use crate::report::unit::labelled;
use crate::scene::column::{label, words};
use crate::study::figures::axis_label;
use crate::study::kinds::calibration::findings::{CalibratedConstant, CalibratedVariant};
use crate::study::kinds::calibration::words::scaled;
use crate::study::store::record::Role;
use crate::study::store::results::Results;

const LEFT: f64 = 15.0;
const GAP: f64 = 34.0;
const TOP: f64 = 6.0;
const TALL: f64 = 46.0;
const BETWEEN: f64 = 5.0;
const LOW: f64 = 22.0;
/// Page width below which the windows are stacked \[mm\]
const NARROW: f64 = 160.0;
/// Size of the marks of measured points \[units\]
const POINT: i32 = 11;

/// Layout of the sheet \[mm\].
struct Windows {
    /// Width of the figure and of each window
    width: f64,
    each: f64,
    /// Left, top, right and bottom of the window of the constants
    constants: [f64; 4],
    height: f64,
}

/// The windows of a sheet with a curve, a constant, or both. On a narrow page they are stacked, so that the type size is never reduced.
fn windows(curve: bool, constant: bool) -> Windows {
    let (width, first) = (page_width(), TOP + TALL + BETWEEN + LOW + 10.0);
    if width < NARROW {
        let each = width - LEFT - 4.0;
        let top = if curve { first + TOP } else { TOP };
        let height = if constant { top + TALL + 10.0 } else { first };
        return Windows { width, each, constants: [GAP, top, LEFT + each, top + TALL], height };
    }
    let (each, side) = ((width - LEFT - GAP - 3.0) / 2.0, (width + LEFT + GAP - 3.0) / 2.0);
    let (width, side) = match (curve, constant) {
        (true, true) => (width, side),
        (true, false) => (LEFT + each + 3.0, side),
        (false, _) => (GAP + each + 3.0, GAP),
    };
    Windows { width, each, constants: [side, TOP, side + each, TOP + TALL + BETWEEN + LOW], height: first }
}

/// Returns the number of sheets; each shows one curve and one constant, as long as there are any left.
pub fn sheets(store: &Results, v: &CalibratedVariant) -> usize {
    curves(store, v).len().max(v.constants.len())
}

fn curves<'a>(store: &'a Results, v: &CalibratedVariant) -> &'a [FittedCurve] {
    store.found.get(&v.case).map_or(&[], |found| &found.curves)
}

/// Draws the sheet of curve and constant `k`; `None` if there is neither.
pub fn draw(store: &Results, v: &CalibratedVariant, k: usize) -> Option<Figure> {
    let all = curves(store, v);
    let (curve, constant) = (all.get(k), v.constants.get(k));
    let count = usize::from(curve.is_some()) + usize::from(constant.is_some());
    if count == 0 {
        return None;
    }
    let w = windows(curve.is_some(), constant.is_some());
    let svg = figure(w.width, w.height, "", |area| {
        if let Some(found) = curve {
            draw_curve(area, w.each, &names(store, v, found), (letter(0, count), found));
        }
        if let Some(c) = constant {
            draw_constant(area, w.constants, store, (letter(count - 1, count), c));
        }
    });
    let (name, part) = numbered(&format!("calibration-{}", v.variant), k, sheets(store, v));
    let from = curve.map(|found| match all.len() {
        1 => format!("The scene at the constants found from {}{part}", found.measured.file),
        _ => format!("The scene of curve {} ({}) at the constants found{part}", found.name, found.measured.file),
    });
    let cases = constant.map(|c| {
        let gauge = if c.gauge.is_some() { " Dashed: what the gauge length alone would have given." } else { "" };
        format!(
            "{} case by case with the interval from the data, sizes of the mesh and dimensions over their range, and the result with its whole interval.{gauge}",
            c.key
        )
    });
    let caption = match (from, cases) {
        (Some(from), Some(cases)) => format!("{from}: (a) measured and simulated, residuals below; (b) {cases}"),
        (Some(from), None) => format!("{from}: measured and simulated, residuals below."),
        (None, cases) => format!("Constants{part}: {}", cases.unwrap_or_default()),
    };
    Some(Figure { name, svg, caption })
}

/// Measured points and the simulated curve, with the residuals below.
fn draw_curve(area: &Area, each: f64, names: &Names, (letter, found): (Option<Letter>, &FittedCurve)) {
    let m = &found.measured;
    let upper = [mm(LEFT), mm(TOP), mm(LEFT + each), mm(TOP + TALL)];
    let base = TOP + TALL + BETWEEN;
    let lower = [mm(LEFT), mm(base), mm(LEFT + each), mm(base + LOW)];
    let xs = found.curve.iter().map(|p| p[0]);
    let x = Axis::linear(xs, &names.x);
    let values = found.curve.iter().map(|p| p[1]).chain(m.y.iter().copied());
    let plot = Plot { area, frame: upper, x: x.clone(), y: Axis::linear(values, &names.y) };
    plot.grid();
    // If there are many points, only those that do not overlap
    let points = apart(plot.path(&m.x, &m.y), 2 * POINT);
    points.iter().for_each(|at| mark(area, Mark::Circle, *at, POINT, PALETTE[0]));
    let (cx, cy): (Vec<f64>, Vec<f64>) = found.curve.iter().map(|p| (p[0], p[1])).unzip();
    let curve = plot.path(&cx, &cy);
    line(area, &curve, INK, 9);
    plot.axes(false);
    plot.title(letter, &names.title);
    let residual: Vec<f64> = m.y.iter().zip(&found.predicted).map(|(y, f)| y - f).collect();
    let plot = Plot { area, frame: lower, x, y: Axis::linear(residual.iter().copied().chain([0.0]), &names.residual) };
    plot.grid();
    line(area, &[(plot.frame[0], plot.at(cx[0], 0.0).1), (plot.frame[2], plot.at(cx[0], 0.0).1)], GREY, 6);
    for at in apart(plot.path(&m.x, &residual), 2 * POINT) {
        mark(area, Mark::Circle, at, POINT, PALETTE[0]);
    }
    plot.axes(true);
    let entries =
        [(Sample::Mark(Mark::Circle, PALETTE[0]), "measured".into()), (Sample::Line(INK), "simulated".into())];
    legend_inside(area, upper, &[curve, points], &entries);
}

/// Draws a constant case by case, and the result.
fn draw_constant(area: &Area, window: [f64; 4], store: &Results, (letter, c): (Option<Letter>, &CalibratedConstant)) {
    let side = window[0];
    let frame = window.map(mm);
    let (factor, unit, _) = scaled(c);
    let own = c.cases.iter().flat_map(|o| o.interval.unwrap_or([o.value; 2]));
    let values = own.chain(c.interval.into_iter().flatten()).chain(c.gauge).map(|v| factor * v);
    let n = c.cases.len();
    let unit = if unit.is_empty() { "–" } else { unit };
    let x = Axis::linear(values, &labelled(&italic(&c.symbol), unit));
    let plot = Plot { area, frame, x, y: Axis::exact(-0.7, n as f64 + 0.7, "") };
    plot.grid_x();
    let words = |row: f64, s: &str| text(area, s, (mm(side - 2.0), plot.at(0.0, row).1), At::Right, LABEL, INK);
    for (k, o) in c.cases.iter().enumerate() {
        let row = (n - k) as f64;
        let color = if o.role == Role::Sizes { PALETTE[0] } else { PALETTE[1] };
        let [a, b] = o.interval.unwrap_or([o.value; 2]);
        line(area, &[plot.at(factor * a, row), plot.at(factor * b, row)], color, 9);
        mark(area, Mark::Square, plot.at(factor * o.value, row), 20, color);
        let name = if o.role == Role::Sizes { format!("{} cells", o.cells) } else { store.study.member(&o.member) };
        words(row, &name);
    }
    if let Some([a, b]) = c.interval {
        line(area, &[plot.at(factor * a, 0.0), plot.at(factor * b, 0.0)], INK, 16);
    }
    mark(area, Mark::Circle, plot.at(factor * c.value, 0.0), 26, INK);
    words(0.0, "result");
    if let Some(gauge) = c.gauge {
        let x = plot.at(factor * gauge, 0.0).0;
        dashed(area, &[(x, plot.frame[1]), (x, plot.frame[3])], GREY, 9, 30.0);
        hollow(area, Mark::Circle, (x, plot.at(0.0, 0.0).1), 22, GREY);
    }
    plot.axis_x();
    plot.title(letter, &constant_title(c));
}

/// Formats `laws.silicone.E` as `E of silicone`.
fn constant_title(c: &CalibratedConstant) -> String {
    match c.key.split('.').collect::<Vec<_>>()[..] {
        ["laws", law, _] => format!("{} of {}", italic(&c.symbol), law.replace('_', " ")),
        _ => c.key.clone(),
    }
}

/// The names that a curve has in its figure.
struct Names {
    title: String,
    x: String,
    y: String,
    residual: String,
}

/// The names of a curve, taken from the quantity of the variant; a signal, or a column that is not a quantity, keeps its recorded name:
/// `grip_x_displacement_m`.
fn names(store: &Results, v: &CalibratedVariant, found: &FittedCurve) -> Names {
    let own = store.study.quantities.get(&v.variant).into_iter().flatten().find(|q| q.name == found.y);
    let (spoken, unit) = words(&found.y);
    let title = capital(own.map_or(&spoken, |q| &q.label));
    let x = match own.and_then(|q| q.against.as_deref()) {
        Some(x) if x.name == found.x => axis_label(x, ""),
        _ if found.x == "t_s" => format!("time {} [s]", italic("t")),
        _ => label(&found.x),
    };
    Names {
        title: if curves(store, v).len() == 1 { title } else { format!("{title}, {}", found.name) },
        x,
        y: own.map_or_else(|| label(&found.y), |q| axis_label(q, "")),
        residual: labelled("residual", own.map_or(unit, |q| &q.unit)),
    }
}
