//! A law with the data it was fitted to: stress against stretch, residuals below; the fitted range on the left, all data on the right.

use crate::calibrate::{Mode, ModeCurves};
use crate::calibrate::{Printed, stress_unit};
use crate::report::canvas::{
    Area, At, GREY, INK, LABEL, Mark, PALETTE, RGB, dashed, figure, fill, hollow, italic, line, mark, mm, text,
};
use crate::report::figure::{Figure, LINE, Sample, apart, legend_below, legend_lines};
use crate::report::fit::stored::{StoredConstant, StoredFit};
use crate::report::panels::{Letter, Panels, letter};
use crate::report::plot::{Axis, Plot};
use plotters::style::Color;
use std::collections::HashSet;

/// Colour of the fitted range, pale enough for points on top.
const RANGE: RGB = RGB(0xee, 0xee, 0xee);
const LEFT: f64 = 15.0;
const GAP: f64 = 18.0;
const RIGHT: f64 = 3.0;
/// Smallest and largest width of a column \[mm\]
const WIDTHS: (f64, f64) = (60.0, 110.0);
const TOP: f64 = 6.0;
const TALL: f64 = 50.0;
const BETWEEN: f64 = 4.0;
const LOW: f64 = 22.0;
/// Height from a column to the one below it \[mm\]
const STEP: f64 = TALL + BETWEEN + LOW + 19.0;
/// A law is drawn up to this multiple of the largest stress of the data
const ROOM: f64 = 1.5;

/// Largest number of constants that are written into the figure
const SHOWN: usize = 3;

/// The part of the stretches shown by one column.
struct Window {
    title: &'static str,
    /// Smallest and largest λ
    span: [f64; 2],
}

/// Draws the fit; `None` without a sample.
pub fn draw(fit: &StoredFit) -> Option<Figure> {
    let modes: Vec<&ModeCurves> =
        fit.curves.modes.iter().filter(|m| !m.fitted.is_empty() || !m.held_out.is_empty()).collect();
    let all = || modes.iter().flat_map(|m| m.fitted.iter().chain(&m.held_out)).map(|p| p[0]);
    let [low, high] = [all().fold(1.0, f64::min), all().fold(1.0, f64::max)];
    if modes.is_empty() || low == high {
        return None;
    }
    let [from, to] = fit.stretch;
    let beyond = 0.15 * (to.max(1.0) - from.min(1.0)).max(1e-3);
    let near = [(from.min(1.0) - beyond).max(low), (to.max(1.0) + beyond).min(high)];
    // A second column if the data extend far beyond the fitted range
    let windows = if high - low > 1.6 * (near[1] - near[0]) {
        vec![Window { title: "Fitted range", span: near }, Window { title: "All data", span: [low, high] }]
    } else {
        vec![Window { title: "", span: [low, high] }]
    };
    let panels = Panels::new(windows.len(), (LEFT, GAP, RIGHT), WIDTHS);
    let entries = entries(&modes, fit.stretch);
    let across = panels.width() - LEFT;
    let bottom = TOP + STEP * panels.rows() - 6.0;
    let svg = figure(panels.width(), bottom + LINE * legend_lines(&entries, across), "", |area| {
        for (k, w) in windows.iter().enumerate() {
            let upper = panels.frame(k, (TOP, STEP), TALL);
            let [left, _, right, bottom] = upper;
            let base = bottom + BETWEEN;
            let lower = [left, base, right, base + LOW];
            column(area, fit, &modes, w, (upper.map(mm), lower.map(mm)), letter(k, windows.len()));
        }
        // More than three constants would cover the curves; they are listed in the table
        let shown = if fit.parameters.len() > SHOWN { &[] } else { &fit.parameters[..] };
        let printed = fit.printed();
        let words = shown.iter().zip(&printed).map(label);
        for (k, words) in words.enumerate() {
            text(area, &words, (mm(LEFT + 3.0), mm(TOP + 4.0 + 4.5 * k as f64)), At::Left, LABEL, INK);
        }
        legend_below(area, (LEFT, bottom + 0.5), across, entries);
    });
    let caption = caption(fit, &modes);
    Some(Figure { name: "fit".into(), svg, caption })
}

/// The caption describes only what is drawn: open marks and dashes if there are any, intervals if constants have them.
fn caption(fit: &StoredFit, modes: &[&ModeCurves]) -> String {
    let held = modes.iter().any(|m| !m.held_out.is_empty());
    let open = if held { " Filled marks were fitted, open ones were not." } else { "" };
    let is_dashed = is_drawn(modes, fit.stretch, false);
    let dashes = if is_dashed { " The line is dashed where the law predicts." } else { "" };
    let shown = fit.parameters.len() <= SHOWN && fit.parameters.iter().any(|p| p.ends().is_some());
    let intervals = if shown { " Behind a constant is its 95 % interval in brackets." } else { "" };
    format!(
        "{} against the data of {}: nominal stress over stretch (top), measured minus law (bottom).{open}{dashes} The grey range is the fitted one.{intervals} Of points that cover each other one is shown; what leaves 1.5 times the largest stress is not.",
        fit.label, fit.data
    )
}

/// Whether part of the line shows a law where it was fitted, or where it was not.
fn is_drawn(modes: &[&ModeCurves], stretch: [f64; 2], fitted: bool) -> bool {
    let is_it = |m: &ModeCurves, w: &[[f64; 2]]| is_fitted(m, stretch, 0.5 * (w[0][0] + w[1][0])) == fitted;
    modes.iter().any(|m| m.curve.windows(2).any(|w| is_it(m, w)))
}

/// Labels a constant with its interval: `μ = 357 kPa [334, 380]`.
fn label((p, printed): (&StoredConstant, &Printed)) -> String {
    let number = |v: f64| printed.end(v);
    let interval = p.ends().map_or(String::new(), |[a, b]| format!("  [{}, {}]", number(a), number(b)));
    format!("{} = {}{interval}", italic(&p.symbol), printed.text(p.value)).replace('-', "−")
}

fn style(mode: Mode) -> (Mark, RGB) {
    match mode {
        Mode::Uniaxial => (Mark::Circle, PALETTE[0]),
        Mode::Equibiaxial => (Mark::Square, PALETTE[1]),
        Mode::Planar => (Mark::Triangle, PALETTE[2]),
        Mode::SimpleShear => (Mark::Diamond, PALETTE[3]),
        Mode::Biaxial => (Mark::Square, PALETTE[4]),
    }
}

fn entries(modes: &[&ModeCurves], stretch: [f64; 2]) -> Vec<(Sample, String)> {
    let mut out = vec![];
    for m in modes {
        let (shape, color) = style(m.mode);
        if !m.fitted.is_empty() {
            out.push((Sample::Mark(shape, color), format!("{}, fitted", m.label)));
        }
        if !m.held_out.is_empty() {
            out.push((Sample::Hollow(shape, color), format!("{}, not fitted", m.label)));
        }
    }
    // With several modes, the law has the colour of each
    let color = if let [one] = modes { darker(style(one.mode).1) } else { GREY };
    if is_drawn(modes, stretch, true) {
        out.push((Sample::Line(color), "law, fitted".into()));
    }
    if is_drawn(modes, stretch, false) {
        out.push((Sample::Dashed(color), "law, predicted".into()));
    }
    out.push((Sample::Block(RANGE), "fitted range".into()));
    out
}

fn column(
    area: &Area,
    fit: &StoredFit,
    modes: &[&ModeCurves],
    w: &Window,
    (upper, lower): ([i32; 4], [i32; 4]),
    letter: Option<Letter>,
) {
    let [a, b] = w.span;
    let inside = |p: &&[f64; 2]| p[0] >= a - 1e-9 && p[0] <= b + 1e-9;
    let points = || modes.iter().flat_map(|m| m.fitted.iter().chain(&m.held_out)).filter(inside);
    let size = points().map(|p| p[1].abs()).fold(0.0, f64::max);
    // A law that diverges beyond its range would leave no room for the data
    let near = |p: &&[f64; 2]| p[1].abs() <= ROOM * size;
    let curves = || modes.iter().flat_map(|m| &m.curve).filter(inside).filter(near);
    let (factor, unit) = stress_unit(size);
    // Margins keep marks away from the frame
    let margin = 0.03 * (b - a);
    let x = Axis::exact(a - margin, b + margin, &format!("stretch {} [–]", italic("λ")));
    let values = points().chain(curves()).map(|p| factor * p[1]);
    let y = Axis::linear(values.chain([0.0]), &format!("nominal stress {} [{unit}]", italic("P")));
    let plot = Plot { area, frame: upper, x: x.clone(), y };
    shade(&plot, fit.stretch);
    plot.grid();
    let r = if points().count() > 25 { 18 } else { 24 };
    // The law is a thin dark line over the data, which it does not hide; dense data would hide it
    for m in modes {
        dots(&plot, m, &m.held_out, &m.fitted, (factor, r), &w.span);
    }
    for m in modes {
        law(&plot, m, fit, factor);
    }
    plot.axes(false);
    if !w.title.is_empty() {
        plot.title(letter, w.title);
    }

    let shown = |m: &ModeCurves| m.residuals.iter().filter(inside).filter(near).copied().collect::<Vec<[f64; 2]>>();
    let values = modes.iter().flat_map(|m| shown(m)).map(|p| factor * p[1]).chain([0.0]);
    let y = Axis::linear(values, &format!("{} − law [{unit}]", italic("P")));
    // Three intervals are enough for a low panel
    let y = Axis { step: if (y.hi - y.lo) / y.step > 4.5 { 2.0 * y.step } else { y.step }, ..y };
    let plot = Plot { area, frame: lower, x, y };
    shade(&plot, fit.stretch);
    plot.grid();
    line(area, &[plot.at(plot.x.lo, 0.0), plot.at(plot.x.hi, 0.0)], GREY, 6);
    for m in modes {
        // A residual belongs to a fitted sample if their stretches are the same
        let stretches: HashSet<u64> = m.fitted.iter().map(|p| p[0].to_bits()).collect();
        let (fitted, held): (Vec<[f64; 2]>, Vec<[f64; 2]>) =
            shown(m).into_iter().partition(|r| stretches.contains(&r[0].to_bits()));
        dots(&plot, m, &held, &fitted, (factor, r - 4), &w.span);
    }
    plot.axes(true);
}

fn shade(plot: &Plot, [from, to]: [f64; 2]) {
    let clamp = |v: f64| v.clamp(plot.x.lo, plot.x.hi);
    let (a, b) = (plot.at(clamp(from), plot.y.lo), plot.at(clamp(to), plot.y.hi));
    fill(plot.area, &[a, (b.0, a.1), b, (a.0, b.1)], RANGE.to_rgba());
}

/// Whether the law was fitted to data of this mode at a stretch within the fitted range.
fn is_fitted(m: &ModeCurves, [from, to]: [f64; 2], stretch: f64) -> bool {
    !m.fitted.is_empty() && stretch >= from.min(1.0) - 1e-9 && stretch <= to + 1e-9
}

/// Draws a law, solid over the fitted range of a fitted mode, dashed elsewhere.
fn law(plot: &Plot, m: &ModeCurves, fit: &StoredFit, factor: f64) {
    let color = darker(style(m.mode).1);
    let fitted = |l: f64| is_fitted(m, fit.stretch, l);
    let inside = |v: f64, axis: &Axis| axis.lo <= v && v <= axis.hi;
    let mut points: Vec<[f64; 2]> =
        m.curve.iter().copied().filter(|p| inside(p[0], &plot.x) && inside(factor * p[1], &plot.y)).collect();
    // The end of the fitted range is a point of its own, on the chord
    for edge in fit.stretch {
        if let Some(k) = points.windows(2).position(|w| w[0][0] < edge && edge < w[1][0]) {
            let (a, b) = (points[k], points[k + 1]);
            let t = (edge - a[0]) / (b[0] - a[0]);
            points.insert(k + 1, [edge, a[1] + t * (b[1] - a[1])]);
        }
    }
    let mut start = 0;
    while start + 1 < points.len() {
        let solid = |k: usize| fitted(0.5 * (points[k][0] + points[k + 1][0]));
        let end = (start..points.len() - 1).find(|k| solid(*k) != solid(start)).unwrap_or(points.len() - 1);
        let path: Vec<_> = points[start..=end].iter().map(|p| plot.at(p[0], factor * p[1])).collect();
        if solid(start) {
            line(plot.area, &path, color, 10);
        } else {
            dashed(plot.area, &path, color, 8, 24.0);
        }
        start = end;
    }
}

/// A darker version of a colour, for a line over marks of that colour.
fn darker(RGB(r, g, b): RGB) -> RGB {
    let dark = |v: u8| (0.55 * f64::from(v)) as u8;
    RGB(dark(r), dark(g), dark(b))
}

fn dots(plot: &Plot, m: &ModeCurves, held: &[[f64; 2]], fitted: &[[f64; 2]], (factor, r): (f64, i32), span: &[f64; 2]) {
    let (shape, color) = style(m.mode);
    let shown = |p: &&[f64; 2]| p[0] >= span[0] - 1e-9 && p[0] <= span[1] + 1e-9;
    let seen = |points: &[[f64; 2]]| apart(points.iter().filter(shown).map(|p| plot.at(p[0], factor * p[1])), r);
    seen(held).into_iter().for_each(|p| hollow(plot.area, shape, p, r, color));
    seen(fitted).into_iter().for_each(|p| mark(plot.area, shape, p, r, color));
}
