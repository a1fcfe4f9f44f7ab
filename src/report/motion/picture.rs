//! A record of motion: a curve over time with its states, the release and the fitted vibration; the residuals of the vibration below.

use crate::motion::{EvaluatedCurve, Evaluation};
use crate::report::canvas::Mark;
use crate::report::canvas::{Area, GREY, PALETTE, RGB, WHITE, block, dashed, figure, line, mark, mm, page_width};
use crate::report::figure::{Figure, Sample, apart, legend};
use crate::report::numbers::capital;
use crate::report::plot::{Axis, Plot};

/// Colour of a state, pale enough for points on top.
const STATE: RGB = RGB(0xdd, 0xe8, 0xf0);
/// Colour of the window of the fitted vibration
const WINDOW: RGB = RGB(0xf6, 0xec, 0xe2);
const LEFT: f64 = 18.0;
const TOP: f64 = 4.0;
const TALL: f64 = 55.0;
const BETWEEN: f64 = 17.0;
const LOW: f64 = 30.0;
/// Number of points of the fitted vibration
const POINTS: usize = 600;
/// Half the size of a mark, and the distance below which only one of two marks is drawn \[units\]
const MARK: i32 = 14;
const APART: i32 = 10;

/// The curve that rings down, otherwise the one that moves most among curves of its kind; `None` without a curve.
fn shown(evaluation: &Evaluation) -> Option<usize> {
    let lengths = |c: &EvaluatedCurve| c.curve.name.ends_with("_m");
    let range = |k: &usize| evaluation.curves[*k].curve.range();
    let widest = (0..evaluation.curves.len())
        .filter(|k| lengths(&evaluation.curves[*k]))
        .max_by(|a, b| range(a).total_cmp(&range(b)));
    evaluation.ring_down.as_ref().map(|r| r.0).or(widest)
}

/// Draws a record under a file name; `None` without a curve.
pub fn draw(name: &str, evaluation: &Evaluation) -> Option<Figure> {
    let at = shown(evaluation)?;
    let own = &evaluation.curves[at];
    let curve = &own.curve;
    let (factor, unit) = if curve.name.ends_with("_m") { (1e3, "mm") } else { (1.0, "°") };
    let words = curve.name.trim_end_matches("_m").trim_end_matches("_deg").replace('_', " ");
    let rings = evaluation.ring_down.as_ref().map(|r| &r.1);
    let height = TOP + TALL + 14.0 + 4.2 * 6.0 + if rings.is_some() { BETWEEN + LOW } else { 0.0 };
    let value: Vec<f64> = curve.value.iter().map(|v| factor * v).collect();
    let svg = figure(page_width(), height, "", |area| {
        let wide = mm(page_width() - 4.0);
        let plot = Plot {
            area,
            frame: [mm(LEFT), mm(TOP), wide, mm(TOP + TALL)],
            x: times(&curve.time_s),
            y: Axis::linear(value.iter().copied(), &format!("{words} [{unit}]")),
        };
        windows(&plot, own);
        plot.grid();
        dots(&plot, &curve.time_s, &value);
        means(&plot, own, factor);
        if let Some(found) = &evaluation.release {
            let path = [plot.at(found.time_s, plot.y.lo), plot.at(found.time_s, plot.y.hi)];
            dashed(area, &path, PALETTE[1], 8, 30.0);
        }
        if let Some(r) = rings {
            let [from, to] = r.window_s;
            let t: Vec<f64> = (0..=POINTS).map(|k| from + (to - from) * k as f64 / POINTS as f64).collect();
            let fit: Vec<f64> = t.iter().map(|t| factor * r.at(*t)).collect();
            line(area, &plot.path(&t, &fit), PALETTE[1], 9);
            let cut = curve.window(r.window_s);
            let left: Vec<f64> = cut.time_s.iter().zip(&cut.value).map(|(t, v)| factor * (v - r.at(*t))).collect();
            let base = TOP + TALL + BETWEEN;
            let low = Plot {
                area,
                frame: [mm(LEFT), mm(base), wide, mm(base + LOW)],
                x: times(&curve.time_s),
                y: Axis::linear(left.iter().copied().chain([0.0]), &format!("residual [{unit}]")),
            };
            let [a, b] = [low.at(from, low.y.hi), low.at(to, low.y.lo)];
            block(area, a, b, WINDOW);
            low.grid();
            line(area, &[low.at(low.x.lo, 0.0), low.at(low.x.hi, 0.0)], GREY, 6);
            dots(&low, &cut.time_s, &left);
            low.axes(true);
        }
        plot.axes(true);
        names(area, evaluation, own, height);
    });
    let fit = if rings.is_some() {
        " Below, over the same times: measured minus fitted vibration in its window, which is shaded."
    } else {
        ""
    };
    let caption = format!(
        "{words} of {} over time, with the windows of the states, their means, the release and the fitted vibration where there are any.{fit} Of points that cover each other one is drawn.",
        evaluation.source,
        words = capital(&words)
    );
    Some(Figure { name: name.into(), svg, caption })
}

/// Draws the windows of the states, below the data.
fn windows(plot: &Plot, own: &EvaluatedCurve) {
    for plateau in [&own.held, &own.last].into_iter().flatten() {
        let [from, to] = plateau.window_s;
        block(plot.area, plot.at(from, plot.y.hi), plot.at(to, plot.y.lo), STATE);
    }
}

/// Draws the means of the states on top of their data, with a white edge.
fn means(plot: &Plot, own: &EvaluatedCurve, factor: f64) {
    for plateau in [&own.held, &own.last].into_iter().flatten() {
        let [from, to] = plateau.window_s;
        let level = factor * plateau.mean.value;
        let path = [plot.at(from, level), plot.at(to, level)];
        line(plot.area, &path, WHITE, 20);
        line(plot.area, &path, PALETTE[2], 10);
    }
}

fn names(area: &Area, evaluation: &Evaluation, own: &EvaluatedCurve, height: f64) {
    let mut entries = vec![(Sample::Mark(Mark::Circle, PALETTE[0]), "measured".to_string())];
    if own.held.is_some() || own.last.is_some() {
        entries.push((Sample::Block(STATE), "window of a state".into()));
        entries.push((Sample::Line(PALETTE[2]), "its mean".into()));
    }
    if evaluation.release.is_some() {
        entries.push((Sample::Dashed(PALETTE[1]), "release".into()));
    }
    if let Some((_, r)) = &evaluation.ring_down {
        entries.push((Sample::Line(PALETTE[1]), format!("fitted vibration, {}", r.frequency_hz.words("Hz"))));
        entries.push((Sample::Nothing, format!("with the decay {}", r.decay_per_s.words("1/s"))));
    }
    legend(area, (mm(LEFT), mm(height - 4.2 * entries.len() as f64)), &entries);
}

/// The time axis, from the first row to the last.
fn times(t: &[f64]) -> Axis {
    match t {
        [first, .., last] => Axis::exact(*first, *last, "time [s]"),
        _ => Axis::linear(t.iter().copied(), "time [s]"),
    }
}

fn dots(plot: &Plot, x: &[f64], y: &[f64]) {
    apart(plot.path(x, y), APART).into_iter().for_each(|p| mark(plot.area, Mark::Circle, p, MARK, PALETTE[0]));
}
