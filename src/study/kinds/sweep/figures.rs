//! A sweep: peaks or final values against each swept key, the map over two of them, and the curves over time.

use crate::report::canvas::{
    Area, At, INK, LABEL, MARKS, PALETTE, RGB, SMALL, block, figure, italic, line, mark, mm, text,
};
use crate::report::figure::{Figure, LINE, Sample, legend, legend_below, legend_lines};
use crate::report::numbers::{capital, digits};
use crate::report::panels::{Panels, heading, letter};
use crate::report::plot::{Axis, Plot};
use crate::report::surface::viridis;
use crate::report::unit;
use crate::study::analysis::ByQuantity;
use crate::study::axis::AxisRecord;
use crate::study::curve::Curve;
use crate::study::figures::{PANELS, axis_label, first_of};
use crate::study::kinds::sweep::analysis::{Dependence, SweepFindings, SweepPoint};
use crate::study::store::results::Results;

const LEFT: f64 = 16.5;
const GAP: f64 = 18.0;
const TOP: f64 = 6.0;
const TALL: f64 = 46.0;
/// Room of a legend at the right of a panel \[mm\]
const LEGEND: f64 = 32.0;
/// Least and usual width of a panel \[mm\]
const LEAST: f64 = 40.0;
const EACH: f64 = 52.0;
/// From a row of panels to the next one \[mm\]
const ROW: f64 = TALL + 17.0;

/// The place of value `k` on an axis; words are counted from 1.
fn place(axis: &AxisRecord, k: usize) -> f64 {
    axis.numbers.get(k).copied().unwrap_or(k as f64 + 1.0)
}

/// `Young's modulus E [kPa]`; words are counted: `formulation (1 displacement, 2 mixed)`
fn words(axis: &AxisRecord) -> String {
    if axis.numbers.is_empty() {
        let named: Vec<String> = (1..).zip(&axis.values).map(|(k, v)| format!("{k} {v}")).collect();
        return format!("{} ({})", axis.label, named.join(", "));
    }
    let unit = if axis.unit.is_empty() { String::new() } else { format!(" [{}]", raised(&axis.unit)) };
    format!("{} {}{unit}", axis.label, italic(&axis.symbol))
}

/// `g/cm^3` → `g/cm³`, `40 um` → `40 µm`, `-20 deg` → `−20°`
fn raised(value: &str) -> String {
    let sign = |text: &str| text.strip_prefix('-').map_or_else(|| text.into(), |size| format!("−{size}"));
    if let Some(number) = value.strip_suffix(" deg") {
        return format!("{}°", sign(number));
    }
    let micro = value.strip_suffix("um").map(|number| format!("{number}µm"));
    sign(micro.as_deref().unwrap_or(value)).replace("^2", "²").replace("^3", "³")
}

/// Logarithmic where the values span a factor of eight and their logarithms are spaced more evenly than they.
fn scale(axis: &AxisRecord) -> Axis {
    let values = || (0..axis.values.len()).map(|k| place(axis, k));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > 0.0
        && high >= 8.0 * low
        && !axis.numbers.is_empty()
        && unevenness(&axis.numbers, f64::ln) < unevenness(&axis.numbers, |x| x)
    {
        Axis::log(values(), &words(axis))
    } else {
        Axis::linear(values(), &words(axis))
    }
}

/// Largest over smallest distance of neighbours on a scale.
fn unevenness(numbers: &[f64], scale: impl Fn(f64) -> f64) -> f64 {
    let mut places: Vec<f64> = numbers.iter().map(|n| scale(*n)).collect();
    places.sort_by(f64::total_cmp);
    let gaps = || places.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 0.0);
    gaps().fold(0.0, f64::max) / gaps().fold(f64::INFINITY, f64::min)
}

/// Peak of a quantity against every axis, one panel each, one curve for each value of the next axis; the rest of the axes
/// are kept at their middle value. `None` without two points on a line.
pub fn against(a: &SweepFindings, q: &ByQuantity<Dependence>) -> Option<Figure> {
    if q.along.is_empty() {
        return None;
    }
    let count = if a.list { 1 } else { a.axes.len().min(2) };
    // Lines of a single axis have no legend
    let side = if count > 1 { LEGEND } else { 5.0 };
    let panels = Panels::new(count, (LEFT, side + GAP, side), (LEAST, EACH));
    let svg = figure(panels.width(), TOP + ROW * panels.rows() - 6.0, "", |area| {
        for k in 0..count {
            panel(
                area,
                a,
                q,
                (k, letter(k, count)),
                [panels.x(k), TOP + ROW * panels.row(k), panels.x(k) + panels.each],
            );
        }
    });
    let held = if a.axes.len() > 2 && !a.list { " Further axes are kept at their middle value." } else { "" };
    let caption = format!(
        "{} against {}.{held}",
        capital(&q.peak_title()),
        if a.list { "the points of the list" } else { "the swept keys" }
    );
    Some(Figure { name: format!("against-{}-{}", q.quantity.name, q.variant), svg, caption })
}

fn panel(
    area: &Area,
    a: &SweepFindings,
    q: &ByQuantity<Dependence>,
    (k, letter): (usize, Option<char>),
    [left, top, right]: [f64; 3],
) {
    let axis = &a.axes[k];
    let other = (!a.list && a.axes.len() > 1).then(|| (k + 1) % a.axes.len());
    let middle =
        |p: &SweepPoint| (0..p.at.len()).all(|i| i == k || Some(i) == other || p.at[i] == a.axes[i].values.len() / 2);
    let lines: Vec<Vec<&SweepPoint>> = (q.lines(k, a.list).into_iter()).filter(|l| a.list || middle(l[0])).collect();
    let label = axis_label(&q.quantity, q.peak_prefix());
    let y = Axis::linear(lines.iter().flatten().map(|p| p.value), &label);
    let frame = [mm(left), mm(top), mm(right), mm(top + TALL)];
    let plot = Plot { area, frame, x: scale(axis), y };
    plot.grid();
    let mut entries = vec![];
    for (n, points) in lines.iter().enumerate() {
        let (color, shape) = (PALETTE[n % PALETTE.len()], MARKS[n % MARKS.len()]);
        let x: Vec<f64> = points.iter().map(|p| place(axis, p.at[k])).collect();
        let y: Vec<f64> = points.iter().map(|p| p.value).collect();
        line(area, &plot.path(&x, &y), color, 8);
        plot.path(&x, &y).into_iter().for_each(|at| mark(area, shape, at, 22, color));
        if let Some(other) = other {
            let value = &a.axes[other].values[points[0].at[other]];
            entries
                .push((Sample::Mark(shape, color), format!("{} = {}", italic(&a.axes[other].symbol), raised(value))));
        }
    }
    plot.axes(true);
    plot.title(letter, &peak_name(q));
    legend(area, (mm(right + 2.5), mm(top + 2.0)), &entries);
}

/// The quantities of a variant that have a panel, and the end of the caption.
fn shown<'a>(a: &'a SweepFindings, variant: &str) -> (Vec<&'a ByQuantity<Dependence>>, String) {
    let mut all: Vec<_> = a.quantities.iter().filter(|q| q.variant == variant && !q.points.is_empty()).collect();
    let more = first_of(all.len());
    all.truncate(PANELS);
    (all, more)
}

/// `Change of cavity volume`, over a panel of peaks.
fn peak_name(q: &ByQuantity<Dependence>) -> String {
    capital(&format!("{}{}", q.peak_prefix(), q.quantity.label))
}

/// Judged values over the two axes of a grid, one map per quantity; `None` for anything but two axes.
pub fn map(store: &Results, a: &SweepFindings, variant: &str) -> Option<Figure> {
    let (maps, more) = shown(a, variant);
    let [first, second] = &a.axes[..] else { return None };
    if a.list || maps.is_empty() {
        return None;
    }
    let panels = Panels::new(maps.len(), (LEFT + 8.0, GAP + 8.0, 3.0), (56.0, 76.0));
    let row = ROW + 2.0;
    let svg = figure(panels.width(), TOP + row * panels.rows() - 6.0, "", |area| {
        for (k, q) in maps.iter().enumerate() {
            let (x, top) = (panels.x(k), TOP + row * panels.row(k));
            let [low, high] = q.range();
            let (power, unit) = unit::shown(&q.quantity.unit, low.abs().max(high.abs()));
            squares(area, q, power, (first, second), [x, top, x + panels.each, top + TALL]);
            let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
            let title = heading(letter(k, maps.len()), &format!("{}{unit}", peak_name(q)));
            text(area, &title, (mm(x), mm(top - 2.4)), At::Left, LABEL, INK);
        }
    });
    let caption = format!(
        "{} over the grid, {}. An empty square has no converged case.{more}",
        a.judged.heading(),
        store.study.label(variant)
    );
    Some(Figure { name: format!("map-{variant}"), svg, caption })
}

/// Squares of a map with their numbers times a power of ten.
fn squares(
    area: &Area,
    q: &ByQuantity<Dependence>,
    power: i32,
    (first, second): (&AxisRecord, &AxisRecord),
    frame: [f64; 4],
) {
    let [left, top, right, bottom] = frame;
    let (columns, rows) = (first.values.len() as f64, second.values.len() as f64);
    let (w, h) = ((right - left) / columns, (bottom - top) / rows);
    let [low, high] = q.range();
    for p in &q.points {
        let (x, y) = (left + w * p.at[0] as f64, bottom - h * (p.at[1] + 1) as f64);
        let share = if high > low { (p.value - low) / (high - low) } else { 0.5 };
        block(area, (mm(x), mm(y)), (mm(x + w), mm(y + h)), viridis(share));
        let ink = if share > 0.6 { INK } else { RGB(0xff, 0xff, 0xff) };
        let value = p.value * 10f64.powi(power);
        let number = format!("{:.*}", digits(1e-1 * value), value).replace('-', "−");
        text(area, &number, (mm(x + 0.5 * w), mm(y + 0.5 * h)), At::Middle, SMALL, ink);
    }
    for (k, value) in first.values.iter().enumerate() {
        text(area, &raised(value), (mm(left + w * (k as f64 + 0.5)), mm(bottom + 1.5)), At::Below, SMALL, INK);
    }
    for (k, value) in second.values.iter().enumerate() {
        text(area, &raised(value), (mm(left - 1.5), mm(bottom - h * (k as f64 + 0.5))), At::Right, SMALL, INK);
    }
    let name = |axis: &AxisRecord| format!("{} {}", axis.label, italic(&axis.symbol));
    text(area, &name(first), (mm(0.5 * (left + right)), mm(bottom + 6.0)), At::Below, LABEL, INK);
    text(area, &name(second), (mm(left - 17.0), mm(0.5 * (top + bottom))), At::Turned, LABEL, INK);
}

/// Quantities over time, coloured by the first axis; the other axes of a grid are kept at their middle value.
pub fn over_time(store: &Results, a: &SweepFindings, variant: &str) -> Option<Figure> {
    let (panels, more) = shown(a, variant);
    let first = a.axes.first()?;
    if panels.is_empty() {
        return None;
    }
    let middle = |p: &&SweepPoint| a.list || (1..p.at.len()).all(|i| p.at[i] == a.axes[i].values.len() / 2);
    let color = |k: usize| viridis(0.9 * k as f64 / (first.values.len() - 1) as f64);
    let places = Panels::new(panels.len(), (LEFT, GAP, 4.0), (LEAST, 70.0));
    let (across, bottom) = (places.width() - LEFT, TOP + ROW * places.rows() - 6.0);
    let svg = figure(places.width(), bottom + LINE * legend_lines(first.values.len(), across), "", |area| {
        for (k, q) in panels.iter().enumerate() {
            let (x, top) = (places.x(k), TOP + ROW * places.row(k));
            let curves: Vec<(usize, Curve)> = (q.points.iter().filter(middle))
                .filter_map(|p| {
                    let stored = store.cases.iter().find(|c| c.record.id == p.case)?;
                    Some((p.at[0], Curve::of(&stored.series, &q.quantity.name)?))
                })
                .collect();
            let end = curves.iter().flat_map(|(_, c)| c.t.last().copied()).fold(0.0, f64::max);
            let y = Axis::linear(curves.iter().flat_map(|(_, c)| c.f.iter().copied()), &axis_label(&q.quantity, ""));
            let frame = [mm(x), mm(top), mm(x + places.each), mm(top + TALL)];
            let plot = Plot { area, frame, x: Axis::exact(0.0, end, &format!("time {} [s]", italic("t"))), y };
            plot.grid();
            curves.iter().for_each(|(k, c)| line(area, &plot.path(&c.t, &c.f), color(*k), 9));
            plot.axes(true);
            plot.title(letter(k, panels.len()), &capital(&q.quantity.label));
        }
        let entry =
            |(k, v): (usize, &String)| (Sample::Line(color(k)), format!("{} = {}", italic(&first.symbol), raised(v)));
        let entries: Vec<_> = first.values.iter().enumerate().map(entry).collect();
        legend_below(area, (LEFT, bottom + 0.5), across, entries);
    });
    let held: Vec<String> = (a.axes.iter().skip(1).filter(|_| !a.list))
        .map(|x| format!("{} = {}", x.symbol, x.values[x.values.len() / 2]))
        .collect();
    let held = if held.is_empty() { String::new() } else { format!(", with {}", held.join(", ")) };
    let caption =
        format!("The quantities over time, {}, coloured by {}{held}.{more}", store.study.label(variant), first.label);
    Some(Figure { name: format!("sweep-{variant}"), svg, caption })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_an_axis_as_a_paper_writes_them() {
        let written = ["-20 deg", "40 um", "1.1 g/cm^3", "0 deg", "-3 mm"].map(raised);
        assert_eq!(written, ["−20°", "40 µm", "1.1 g/cm³", "0°", "−3 mm"]);
    }

    fn length() -> AxisRecord {
        AxisRecord {
            name: "length".into(),
            keys: vec![],
            label: "length".into(),
            symbol: "d".into(),
            unit: "mm".into(),
            values: vec![],
            numbers: vec![],
        }
    }

    #[test]
    fn the_scale_is_the_more_even_one() {
        let is_log = |numbers: &[f64]| {
            let values = numbers.iter().map(|n| format!("{n}")).collect();
            scale(&AxisRecord { values, numbers: numbers.into(), ..length() }).log
        };
        assert!(is_log(&[5.0, 10.0, 20.0, 40.0]) && is_log(&[0.05, 0.1, 0.2, 0.3, 0.4, 0.6]));
        assert!(!is_log(&[1.0, 4.0, 8.0, 12.0]) && !is_log(&[1.0, 2.0, 3.0]));
    }
}
