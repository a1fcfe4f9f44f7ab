//! A measured curve together with the scene that reproduces it, the residuals below, and the first constant case by case.

use crate::report::canvas::{
    At, GREY, INK, LABEL, Mark, PALETTE, dashed, figure, hollow, italic, line, mark, mm, page_width, text,
};
use crate::report::figure::{Figure, Sample, apart, legend_inside};
use crate::report::numbers::capital;
use crate::report::plot::{Axis, Plot};
use crate::report::unit::labelled;
use crate::scene::column::label;
use crate::study::figures::axis_label;
use crate::study::kinds::calibration::analysis::{CalibratedConstant, CalibratedVariant, scaled};
use crate::study::store::record::{Quantity, Role};
use crate::study::store::results::Results;

const LEFT: f64 = 15.0;
const GAP: f64 = 34.0;
const TOP: f64 = 6.0;
const TALL: f64 = 46.0;
const BETWEEN: f64 = 5.0;
const LOW: f64 = 22.0;
/// A page that is narrower has one window below the other \[mm\]
const NARROW: f64 = 160.0;
/// Size of the marks of measured points \[units\]
const POINT: i32 = 11;

/// Places on the page \[mm\].
struct Windows {
    /// Width of the window of the curve
    each: f64,
    /// Left, top, right and bottom of the window of the constants
    constants: [f64; 4],
    height: f64,
}

/// On a narrow page the windows are stacked, so that type is never shrunk.
fn windows() -> Windows {
    let (width, first) = (page_width(), TOP + TALL + BETWEEN + LOW + 10.0);
    if width < NARROW {
        let each = width - LEFT - 4.0;
        let top = first + TOP;
        return Windows { each, constants: [GAP, top, LEFT + each, top + TALL], height: top + TALL + 10.0 };
    }
    let (each, side) = ((width - LEFT - GAP - 3.0) / 2.0, (width + LEFT + GAP - 3.0) / 2.0);
    Windows { each, constants: [side, TOP, side + each, TOP + TALL + BETWEEN + LOW], height: first }
}

/// `None` where the case of the answer has no curve.
pub fn draw(store: &Results, v: &CalibratedVariant) -> Option<Figure> {
    let found = store.found.get(&v.case)?.curves.first()?;
    let quantity = store.study.quantities.get(&v.variant)?.iter().find(|q| q.name == found.y)?;
    let (c, m) = (v.constants.first()?, &found.measured);
    let Windows { each, constants, height } = windows();
    let svg = figure(page_width(), height, "", |area| {
        let upper = [mm(LEFT), mm(TOP), mm(LEFT + each), mm(TOP + TALL)];
        let base = TOP + TALL + BETWEEN;
        let lower = [mm(LEFT), mm(base), mm(LEFT + each), mm(base + LOW)];
        let xs = found.curve.iter().map(|p| p[0]);
        let x = Axis::linear(xs, &x_label(quantity, &found.x));
        let values = found.curve.iter().map(|p| p[1]).chain(m.y.iter().copied());
        let plot = Plot { area, frame: upper, x: x.clone(), y: Axis::linear(values, &axis_label(quantity, "")) };
        plot.grid();
        // Of many points those that do not cover each other
        let points = apart(plot.path(&m.x, &m.y), 2 * POINT);
        points.iter().for_each(|at| mark(area, Mark::Circle, *at, POINT, PALETTE[0]));
        let (cx, cy): (Vec<f64>, Vec<f64>) = found.curve.iter().map(|p| (p[0], p[1])).unzip();
        let curve = plot.path(&cx, &cy);
        line(area, &curve, INK, 9);
        plot.axes(false);
        plot.title(Some('a'), &capital(&quantity.label));
        let residual: Vec<f64> = m.y.iter().zip(&found.predicted).map(|(y, f)| y - f).collect();
        let label = labelled("residual", &quantity.unit);
        let plot = Plot { area, frame: lower, x, y: Axis::linear(residual.iter().copied().chain([0.0]), &label) };
        plot.grid();
        line(area, &[(plot.frame[0], plot.at(cx[0], 0.0).1), (plot.frame[2], plot.at(cx[0], 0.0).1)], GREY, 6);
        for at in apart(plot.path(&m.x, &residual), 2 * POINT) {
            mark(area, Mark::Circle, at, POINT, PALETTE[0]);
        }
        plot.axes(true);
        let entries =
            [(Sample::Mark(Mark::Circle, PALETTE[0]), "measured".into()), (Sample::Line(INK), "simulated".into())];
        legend_inside(area, upper, &[curve, points], &entries);
        let side = constants[0];
        let frame = constants.map(mm);
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
        plot.title(Some('b'), &constant_title(c));
    });
    let gauge = if c.gauge.is_some() { " Dashed: what the gauge length alone would have given." } else { "" };
    let caption = format!(
        "The scene at the constants found from {}: (a) measured and simulated, residuals below; (b) {} case by case with the interval from the data, sizes of the mesh and dimensions over their range, and the result with its whole interval.{gauge}",
        m.file, c.key
    );
    Some(Figure { name: format!("calibration-{}", v.variant), svg, caption })
}

/// `E of silicone` for `laws.silicone.E`.
fn constant_title(c: &CalibratedConstant) -> String {
    match c.key.split('.').collect::<Vec<_>>()[..] {
        ["laws", law, _] => format!("{} of {}", italic(&c.symbol), law.replace('_', " ")),
        _ => c.key.clone(),
    }
}

/// Signals are named as they are recorded: `grip_x_displacement_m`.
fn x_label(q: &Quantity, name: &str) -> String {
    match &q.against {
        Some(x) if x.name == name => axis_label(x, ""),
        _ if name == "t_s" => format!("time {} [s]", italic("t")),
        _ => label(name),
    }
}
