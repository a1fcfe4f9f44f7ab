//! Figures of a reduction study: error over cost, errors with their estimates, decay of the singular values.

pub mod meshes;
pub mod search;

use crate::report::canvas::{Area, INK, Mark as Shape, PALETTE, dashed, figure, line, mark, mm};
use crate::report::figure::{Figure, Sample, legend_below, legend_lines};
use crate::report::numbers::capital;
use crate::report::panels::{Panels, letter};
use crate::report::plot::{Axis, Plot};
use crate::report::unit::labelled;
use crate::study::kinds::reduction::analysis::{ReductionFindings, relative};
use crate::study::kinds::reduction::record::QuantityRecord;

const LEFT: f64 = 17.0;
const RIGHT: f64 = 4.0;
const GAP: f64 = 19.0;
const TOP: f64 = 6.0;
const TALL: f64 = 48.0;
/// Height from one row of panels to the next \[mm\]
const ROW: f64 = TALL + 20.0;
/// Smallest and largest width of a panel \[mm\]
const WIDTHS: (f64, f64) = (60.0, 90.0);
pub const SHAPES: [Shape; 3] = [Shape::Circle, Shape::Square, Shape::Triangle];

/// Draws `count` panels with the legend below.
pub fn sheet(count: usize, entries: Vec<(Sample, String)>, paint: impl Fn(usize, &Area, [i32; 4])) -> String {
    let panels = Panels::new(count, (LEFT, GAP, RIGHT), WIDTHS);
    let below = TOP + panels.rows() * ROW - 6.0;
    let wide = panels.width() - LEFT - RIGHT;
    let height = below + 5.0 * legend_lines(&entries, wide).max(1.0);
    figure(panels.width(), height, "", |area| {
        for k in 0..count {
            paint(k, area, panels.frame(k, (TOP, ROW), TALL).map(mm));
        }
        if !entries.is_empty() {
            legend_below(area, (LEFT, below), wide, entries);
        }
    })
}

/// Returns the factor from seconds, and the unit, in which times up to the largest one are short numbers.
pub fn time_unit(largest_s: f64) -> (f64, &'static str) {
    match largest_s {
        t if t < 1e-3 => (1e6, "µs"),
        t if t < 1.0 => (1e3, "ms"),
        _ => (1.0, "s"),
    }
}

/// Draws the largest error of every quantity over the time of a step, with the full model as the most expensive line.
pub fn precision(a: &ReductionFindings) -> Option<Figure> {
    let derived = a.derived.as_ref()?;
    let errors = || a.models().iter().flat_map(|m| m.quantities.iter().map(relative)).filter(|e| *e > 0.0);
    errors().next()?;
    let (factor, unit) = time_unit(derived.full_step_s);
    let times = || a.models().iter().map(|m| m.leap_s[0]).chain([derived.full_step_s]).map(|t| factor * t);
    let mut entries: Vec<(Sample, String)> = a
        .quantities
        .iter()
        .enumerate()
        .map(|(k, q)| (Sample::Mark(SHAPES[k % 3], PALETTE[k % PALETTE.len()]), q.label.clone()))
        .collect();
    entries.push((Sample::Dashed(INK), format!("a step of {}", derived.full())));
    let svg = sheet(1, entries, |_, area, frame| {
        let x = Axis::log(times(), &format!("CPU time of a step from state to state [{unit}]"));
        let y = Axis::log(errors(), "largest error / largest change");
        let (low, high) = (y.lo, y.hi);
        let plot = Plot { area, frame, x, y };
        plot.grid();
        for k in 0..a.quantities.len() {
            let color = PALETTE[k % PALETTE.len()];
            let points: Vec<_> = a
                .models()
                .iter()
                .filter(|m| relative(&m.quantities[k]) > 0.0)
                .map(|m| plot.at(factor * m.leap_s[0], relative(&m.quantities[k])))
                .collect();
            line(area, &points, color, 4);
            points.iter().for_each(|at| mark(area, SHAPES[k % 3], *at, 16, color));
        }
        let full = factor * derived.full_step_s;
        dashed(area, &[plot.at(full, low), plot.at(full, high)], INK, 4, 22.0);
        plot.axes(true);
    });
    let caption = format!(
        "Largest error at the states that were held back over the median CPU time of a step from one of them to the next, for models of more and more modes. The dashed \
         line is the CPU time of a step of {}, from which errors are counted.",
        derived.full()
    );
    Some(Figure { name: "work-precision".into(), svg, caption })
}

/// Draws estimated over true errors of the chosen model, or of the largest one.
pub fn bars(a: &ReductionFindings) -> Option<Figure> {
    let model = a.models().get(a.chosen.unwrap_or(a.models().len().checked_sub(1)?))?;
    let known = |q: &QuantityRecord| -> Vec<[f64; 2]> {
        let sizes = q.errors.iter().flatten().map(|e| e.map(f64::abs));
        sizes.filter(|e| e[0] > 0.0 && e[1] > 0.0).collect()
    };
    if model.quantities.iter().all(|q| known(q).is_empty()) {
        return None;
    }
    let entries = vec![
        (Sample::Mark(Shape::Circle, PALETTE[0]), "a state that was held back".into()),
        (Sample::Dashed(INK), "estimate = error".into()),
        (Sample::Line(PALETTE[1]), "end of the bar".into()),
    ];
    let svg = sheet(model.quantities.len(), entries, |k, area, frame| {
        let (q, asked) = (&model.quantities[k], &a.quantities[k]);
        let points = known(q);
        let unit = |of: &str| labelled(of, &asked.unit);
        let x = Axis::log(points.iter().map(|e| e[0]), &unit("error"));
        let y = Axis::log(points.iter().map(|e| e[1]), &unit("estimate"));
        let ends = [x.lo.max(y.lo), x.hi.min(y.hi)];
        let (low, high) = (x.lo, x.hi);
        let (bottom, top) = (y.lo, y.hi);
        let plot = Plot { area, frame, x, y };
        plot.grid();
        if ends[0] < ends[1] {
            dashed(area, &ends.map(|e| plot.at(e, e)), INK, 4, 22.0);
        }
        // To the right of this line the error is beyond the bar: error = factor (estimate + floor)
        let steps = (0..=60).map(|n| low * (high / low).powf(f64::from(n) / 60.0));
        let edge = steps.map(|error| (error, error / q.factor - q.floor)).filter(|(_, e)| *e >= bottom && *e <= top);
        line(area, &edge.map(|(error, estimate)| plot.at(error, estimate)).collect::<Vec<_>>(), PALETTE[1], 4);
        points.iter().for_each(|e| mark(area, Shape::Circle, plot.at(e[0], e[1]), 9, PALETTE[0]));
        plot.axes(true);
        plot.title(letter(k, model.quantities.len()), &capital(&asked.label));
    });
    let caption = format!(
        "Estimated error over the error from the full model, {} modes, at the states that were held back. Below the solid line an error is beyond its bar.",
        model.modes
    );
    Some(Figure { name: "bars".into(), svg, caption })
}

/// Draws the singular values of the training states.
pub fn decay(a: &ReductionFindings) -> Option<Figure> {
    let derived = a.derived.as_ref()?;
    let series: Vec<(&Vec<f64>, &str)> =
        [(&derived.singular_values, "displacement"), (&derived.pressure_values, "pressure")]
            .into_iter()
            .filter(|(values, _)| values.iter().filter(|v| **v > LEAST).count() > 1)
            .collect();
    if series.is_empty() {
        return None;
    }
    let sample = |k: usize| Sample::Mark(SHAPES[k % 3], PALETTE[k % PALETTE.len()]);
    let entries = series.iter().enumerate().map(|(k, (_, name))| (sample(k), name.to_string())).collect();
    let shown = |values: &[f64]| values.iter().copied().filter(|v| *v > LEAST).collect::<Vec<_>>();
    let svg = sheet(1, entries, |_, area, frame| {
        let count = series.iter().map(|(v, _)| shown(v).len()).max().unwrap_or(1);
        let x = Axis::linear([0.0, count as f64].into_iter(), "mode");
        let y = Axis::log(series.iter().flat_map(|(v, _)| shown(v)), "singular value / first");
        let plot = Plot { area, frame, x, y };
        plot.grid();
        for (k, (values, _)) in series.iter().enumerate() {
            for (mode, value) in shown(values).into_iter().enumerate() {
                mark(area, SHAPES[k % 3], plot.at((mode + 1) as f64, value), 11, PALETTE[k % PALETTE.len()]);
            }
        }
        plot.axes(true);
    });
    let caption = format!(
        "Singular values of the {} training states, as shares of the first. Where they fall fast, few modes represent the motion.",
        derived.training
    );
    Some(Figure { name: "singular-values".into(), svg, caption })
}

/// Smallest singular value that is drawn; smaller ones are rounding.
const LEAST: f64 = 1e-8;
