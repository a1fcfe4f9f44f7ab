//! Measured and fitted values of a fit, residuals below.

use crate::calibrate::{CurveSet, MeasuredCurves, stress_unit};
use crate::report::canvas::{Area, GREY, Point, figure, line, mark, mm, page_width};
use crate::report::figure::{Figure, Sample, apart, legend, style};
use crate::report::plot::{Axis, Plot};
use crate::report::unit::labelled;

const LEFT: f64 = 18.0;
/// Width of the panels if the page has room for them \[mm\]
const WIDEST: f64 = 110.0;
const TOP: f64 = 4.0;
const TALL: f64 = 55.0;
const BETWEEN: f64 = 4.0;
const LOW: f64 = 24.0;
/// Half the size of a mark, and the distance below which only one of two marks is drawn \[units\]
const MARK: i32 = 18;
const APART: i32 = 22;

/// Draws the fit; `None` without a point.
pub fn draw(curves: &MeasuredCurves) -> Option<Figure> {
    let points = || curves.sets.iter().flat_map(|s| &s.measured);
    let largest = points().map(|p| p[1].abs()).fold(0.0, f64::max);
    points().next()?;
    let (factor, unit) = match curves.y_unit.as_str() {
        "Pa" => stress_unit(largest),
        "1" => (1.0, "–"),
        own => (1.0, own),
    };
    let x_axis = |label: &str| {
        let values = points().map(|p| p[0]);
        if curves.log_x { Axis::log(values, label) } else { Axis::linear(values, label) }
    };
    let x = x_axis(&curves.x_label);
    let shown = |p: &&[f64; 2]| !curves.log_x || p[0] > 0.0;
    let all = || {
        curves
            .sets
            .iter()
            .flat_map(|s| s.measured.iter().chain(lines(s).iter().flatten()))
            .filter(shown)
            .map(|p| factor * p[1])
    };
    let label = labelled(&curves.y_label, unit);
    let y = if curves.log_y { Axis::log(all(), &label) } else { Axis::linear(all(), &label) };
    let left = curves.sets.iter().flat_map(|s| &s.residuals).filter(shown).map(|p| factor * p[1]);
    let low = Axis::linear(left.chain([0.0]), &labelled("residual", unit));
    // Three intervals are enough for a low panel
    let low = Axis { step: if (low.hi - low.lo) / low.step > 4.5 { 2.0 * low.step } else { low.step }, ..low };
    let height = TOP + TALL + BETWEEN + LOW + 13.0 + 4.2 * (1 + curves.sets.len()) as f64;
    let wide = WIDEST.min(page_width() - LEFT - 5.0);
    let svg = figure(LEFT + wide + 5.0, height, "", |area| {
        let base = TOP + TALL + BETWEEN;
        let upper = Plot { area, frame: [mm(LEFT), mm(TOP), mm(LEFT + wide), mm(TOP + TALL)], x: x.clone(), y };
        upper.grid();
        for (k, set) in curves.sets.iter().enumerate() {
            dots(&upper, k, set.measured.iter().filter(shown), factor);
        }
        for points in curves.sets.iter().flat_map(lines) {
            let path: Vec<Point> = points.iter().filter(shown).map(|p| upper.at(p[0], factor * p[1])).collect();
            line(area, &path, GREY, 10);
        }
        upper.axes(false);
        let lower = Plot { area, frame: [mm(LEFT), mm(base), mm(LEFT + wide), mm(base + LOW)], x, y: low };
        lower.grid();
        line(area, &[lower.at(lower.x.lo, 0.0), lower.at(lower.x.hi, 0.0)], GREY, 6);
        for (k, set) in curves.sets.iter().enumerate() {
            dots(&lower, k, set.residuals.iter().filter(shown), factor);
        }
        lower.axes(true);
        names(area, &curves.sets, base + LOW + 13.5);
    });
    let caption = format!(
        "Measured and fitted {} (top), measured minus fitted (bottom). Of points that cover each other one is shown.",
        curves.y_label
    );
    Some(Figure { name: "fit".into(), svg, caption })
}

/// The lines of the fit of a set.
fn lines(set: &CurveSet) -> &[Vec<[f64; 2]>] {
    if set.lines.is_empty() { std::slice::from_ref(&set.fitted) } else { &set.lines }
}

fn names(area: &Area, sets: &[CurveSet], top: f64) {
    let measured = sets.iter().enumerate().map(|(k, s)| {
        let (shape, colour) = style(k);
        (Sample::Mark(shape, colour), s.label.clone())
    });
    let entries: Vec<(Sample, String)> = measured.chain([(Sample::Line(GREY), "fitted".into())]).collect();
    legend(area, (mm(LEFT), mm(top)), &entries);
}

fn dots<'a>(plot: &Plot, k: usize, points: impl Iterator<Item = &'a [f64; 2]>, factor: f64) {
    let (shape, colour) = style(k);
    let places = points.map(|p| plot.at(p[0], factor * p[1]));
    apart(places, APART).into_iter().for_each(|p| mark(plot.area, shape, p, MARK, colour));
}
