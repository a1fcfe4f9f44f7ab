//! A sweep: peaks or final values against each swept key, the map over two of them, and the curves over time.

use crate::report::axis::ROUNDING;
use crate::report::canvas::{
    Area, At, INK, Mark, RGB, SMALL, block, figure, hollow, italic, line, mark, mm, page_width, text,
};
use crate::report::color_bar::ROOM;
use crate::report::figure::{Figure, LINE, Sample, legend, legend_below, legend_lines, legend_width, stroke, style};
use crate::report::measure::{shortened, width};
use crate::report::numbers::capital;
use crate::report::panels::{Letter, Panels, headed, letter};
use crate::report::plot::{Axis, Plot};
use crate::report::surface::viridis;
use crate::scene::ExtremeKind;
use crate::study::analysis::ByQuantity;
use crate::study::axis::AxisRecord;
use crate::study::curve::Curve;
use crate::study::figures::grid::{MapNumbers, raised, sides};
use crate::study::figures::{PANELS, axis_label, first_of};
use crate::study::kinds::sweep::analysis::{Dependence, Judged, SweepFindings, SweepPoint};
use crate::study::store::results::Results;
use crate::wording;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

const LEFT: f64 = 16.5;
const GAP: f64 = 18.0;
const TOP: f64 = 6.0;
const TALL: f64 = 46.0;
/// Width of a legend to the right of a panel \[mm\]
const LEGEND: f64 = 32.0;
/// Smallest and usual width of a panel \[mm\]
const LEAST: f64 = 40.0;
const EACH: f64 = 52.0;
/// Distance between two rows of panels \[mm\]
const BETWEEN: f64 = 17.0;
/// Largest number of values of an axis in a legend
const ENTRIES: usize = 10;

/// The position of value `k` on an axis; words are numbered from 1.
fn place(axis: &AxisRecord, k: usize) -> f64 {
    axis.numbers.get(k).copied().unwrap_or(k as f64 + 1.0)
}

/// The axis title `Young's modulus E [kPa]`, with `with` before the unit; `formulation` for an axis of words.
fn name(axis: &AxisRecord, with: &str) -> String {
    if axis.numbers.is_empty() {
        return axis.label.clone();
    }
    let unit = if axis.unit.is_empty() { String::new() } else { format!(" [{}]", raised(&axis.unit)) };
    format!("{} {}{with}{unit}", axis.label, italic(&axis.symbol))
}

/// The scale of an axis: logarithmic if the values span a factor of eight and are spaced more evenly in their logarithms.
fn scale(axis: &AxisRecord, with: &str) -> Axis {
    if axis.numbers.is_empty() {
        return Axis { label: name(axis, with), ..Axis::exact(0.5, axis.values.len() as f64 + 0.5, "") };
    }
    let values = || (0..axis.values.len()).map(|k| place(axis, k));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > 0.0 && high >= 8.0 * low && unevenness(&axis.numbers, f64::ln) < unevenness(&axis.numbers, |x| x) {
        Axis::log(values(), &name(axis, with))
    } else {
        Axis::linear(values(), &name(axis, with))
    }
}

/// Ratio of the largest to the smallest distance between neighbours on a scale.
fn unevenness(numbers: &[f64], scale: impl Fn(f64) -> f64) -> f64 {
    let mut places: Vec<f64> = numbers.iter().map(|n| scale(*n)).collect();
    places.sort_by(f64::total_cmp);
    let gaps = || places.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 0.0);
    gaps().fold(0.0, f64::max) / gaps().fold(f64::INFINITY, f64::min)
}

/// A legend entry `ν = 0.45`, with the symbol in italics.
fn entry(axis: &AxisRecord, value: &str) -> String {
    format!("{} = {}", italic(&axis.symbol), raised(value))
}

/// Whether the points are a list along its first axis, whose numbers rise or fall.
fn goes_along(a: &SweepFindings) -> bool {
    a.list && a.axes[0].is_ordered()
}

/// The other keys that a list changes together with its first one.
fn other_keys(a: &SweepFindings) -> impl Iterator<Item = &AxisRecord> {
    let changes = |axis: &&AxisRecord| axis.values.iter().any(|value| *value != axis.values[0]);
    a.axes.iter().skip(1).filter(|_| a.list).filter(changes)
}

/// The keys that vary with the first one of a list along its axis: ` (with ρ)`.
fn with(a: &SweepFindings) -> String {
    let symbols: Vec<String> = other_keys(a).filter(|_| goes_along(a)).map(|axis| italic(&axis.symbol)).collect();
    if symbols.is_empty() { String::new() } else { format!(" (with {})", wording::few(&symbols)) }
}

/// How a list changes the other keys, for a caption that has named its first one: `, along which density ρ goes from 1 g/cm³ to 9 g/cm³ too`.
fn along_which(a: &SweepFindings) -> String {
    let one = |axis: &AxisRecord| {
        let [first, .., last] = &axis.values[..] else { return String::new() };
        let name = format!("{} {}", axis.label, axis.symbol);
        match axis.is_ordered() && goes_along(a) {
            true => format!("{name} goes from {} to {}", raised(first), raised(last)),
            false => format!("{name} changes"),
        }
    };
    let all: Vec<String> = other_keys(a).map(one).collect();
    let link = if goes_along(a) { "along which" } else { "while" };
    if all.is_empty() { String::new() } else { format!(", {link} {} too", wording::all(&all)) }
}

/// A panel against one axis.
struct Against {
    /// The axis along which it is drawn
    along: usize,
    /// The axis that has a curve for each value
    other: Option<usize>,
    /// The remaining axes, each kept at one value
    kept: Kept,
}

impl Against {
    /// Returns a panel for each axis along which the quantity is judged. An ordered list has one panel, with its points on one line; scattered points
    /// are drawn against each axis.
    fn all(a: &SweepFindings, q: &ByQuantity<Dependence>) -> Vec<Self> {
        let is_judged = |k: &usize| q.along.iter().any(|x| x.axis == a.axes[*k].name);
        let axes: Vec<usize> = match a.list {
            true if goes_along(a) => vec![0],
            true => (0..a.axes.len()).collect(),
            false => (0..a.axes.len()).filter(is_judged).collect(),
        };
        let one = |(n, &along): (usize, &usize)| {
            let other = (!a.list && axes.len() > 1).then(|| axes[(n + 1) % axes.len()]);
            let is_kept = |k: &usize| !a.list && *k != along && Some(*k) != other;
            let rest: Vec<usize> = (0..a.axes.len()).filter(is_kept).collect();
            Self { along, other, kept: Kept::of(q.points.iter(), &a.axes, &rest) }
        };
        axes.iter().enumerate().map(one).collect()
    }

    /// Returns the lines along the axis, each at one value of the other axis.
    fn lines<'a>(&self, a: &SweepFindings, q: &'a Dependence) -> Vec<Vec<&'a SweepPoint>> {
        q.lines(self.along, a.list).into_iter().filter(|line| self.kept.has(line[0])).collect()
    }
}

/// The lines out of `lines`, in order, that get an entry in a legend with room for `most`: the first, the last, and some in between.
fn picked(lines: usize, most: usize) -> Vec<usize> {
    let count = lines.min(most);
    (0..count).map(|k| k * (lines - 1) / (count - 1).max(1)).collect()
}

/// The end of a caption if the legend names only a part of the values.
fn named(axis: &AxisRecord, lines: usize, most: usize) -> Option<String> {
    (lines > most).then(|| format!(" Of {lines} values of {} {} the legend names {most}.", axis.label, axis.symbol))
}

/// The colour of line `k` of `lines`, by their order.
fn ordered_color(k: usize, lines: usize) -> RGB {
    viridis(0.9 * k as f64 / (lines - 1).max(1) as f64)
}

/// The cases whose peak is a minimum, if other cases have maxima; empty if all peaks are of one kind.
fn minima<'a>(store: &Results, a: &SweepFindings, q: &'a ByQuantity<Dependence>) -> BTreeSet<&'a str> {
    let of = |kind: ExtremeKind| -> BTreeSet<&'a str> {
        let is_one = |p: &&SweepPoint| {
            let case = store.cases.iter().find(|c| c.record.id == p.case);
            case.and_then(|c| c.record.probes.get(&q.quantity.name)).is_some_and(|probe| probe.peak_is == kind)
        };
        q.points.iter().filter(is_one).map(|p| p.case.as_str()).collect()
    };
    let is_mixed = a.judged == Judged::Peak && !of(ExtremeKind::Maximum).is_empty();
    if is_mixed { of(ExtremeKind::Minimum) } else { BTreeSet::new() }
}

/// Axes that a panel keeps at one value each: the axis, and the index of its value.
struct Kept(Vec<(usize, usize)>);

impl Kept {
    /// Keeps these axes at the values that most points have; of several such combinations, the one nearest to the middle.
    fn of<'a>(points: impl Iterator<Item = &'a SweepPoint>, axes: &[AxisRecord], rest: &[usize]) -> Self {
        let mut counts: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        for p in points {
            *counts.entry(rest.iter().map(|k| p.at[*k]).collect()).or_default() += 1;
        }
        let middle = |k: &usize| axes[*k].values.len() / 2;
        let off = |at: &[usize]| rest.iter().zip(at).map(|(k, at)| at.abs_diff(middle(k))).sum::<usize>();
        let most = counts.into_iter().max_by_key(|(at, count)| (*count, Reverse(off(at))));
        Self(most.map_or(vec![], |(at, _)| rest.iter().copied().zip(at).collect()))
    }

    /// Whether a point has these values.
    fn has(&self, p: &SweepPoint) -> bool {
        self.0.iter().all(|(k, at)| p.at[*k] == *at)
    }

    /// The kept values in words, `ρ = 1.07 g/cm³ and E = 250 kPa`; `None` without an axis.
    fn words(&self, axes: &[AxisRecord]) -> Option<String> {
        let values = self.0.iter().map(|(k, at)| format!("{} = {}", axes[*k].symbol, raised(&axes[*k].values[*at])));
        (!self.0.is_empty()).then(|| wording::all(&values.collect::<Vec<_>>()))
    }
}

/// Draws the peak of a quantity against every axis, one panel each, with one curve for each value of the next axis; the remaining axes are kept at
/// one value. Scattered points of a list are marks without a line, and no line joins a minimum to a maximum. `None` if no line has two points.
pub fn against(store: &Results, a: &SweepFindings, q: &ByQuantity<Dependence>) -> Option<Figure> {
    if q.along.is_empty() {
        return None;
    }
    let mut shown = Against::all(a, q);
    let more = first_of(shown.len(), PANELS, "axes");
    shown.truncate(PANELS);
    let others = shown.iter().filter_map(|panel| panel.other).map(|k| &a.axes[k]);
    let names: Vec<_> = others.flat_map(|x| x.values.iter().map(|v| (Sample::Nothing, entry(x, v)))).collect();
    let longest = (legend_width(&names) + 2.5).clamp(LEGEND - 10.0, 0.3 * page_width());
    // The lines of a single axis have no legend
    let side = if names.is_empty() { 5.0 } else { longest };
    let panels = Panels::new(shown.len(), (LEFT, side + GAP, side), (LEAST, EACH));
    let tall = panels.tall(TALL, (BETWEEN, TOP + 11.0));
    let row = tall + BETWEEN;
    let most = (((tall - 2.0) / LINE) as usize + 1).min(ENTRIES);
    let minima = minima(store, a, q);
    let svg = figure(panels.width(), TOP + row * panels.rows() - 6.0, "", |area| {
        for (k, of) in shown.iter().enumerate() {
            panel(area, a, q, (of, letter(k, shown.len()), most, &minima), panels.frame(k, (TOP, row), tall));
        }
    });
    let unnamed = shown.iter().filter_map(|of| named(&a.axes[of.other?], of.lines(a, q).len(), most));
    let unnamed: String = wording::distinct(unnamed).concat();
    let mixed =
        if minima.is_empty() { "" } else { " Hollow marks are minima and full ones maxima; no line joins the two." };
    let places = shown.iter().enumerate().filter_map(|(k, of)| {
        let place = letter(k, shown.len()).map_or(String::new(), |letter| format!("in ({letter}) "));
        Some(format!("{place}at {}", of.kept.words(&a.axes)?))
    });
    let places: Vec<String> = places.collect();
    let held = if places.is_empty() { String::new() } else { format!(" Further axes are kept {}.", places.join(", ")) };
    let of = match a.list {
        true if goes_along(a) => format!("{} {}{}", a.axes[0].label, a.axes[0].symbol, along_which(a)),
        true => "each key of the list, whose other keys change from point to point too".into(),
        false => "the swept keys".into(),
    };
    let caption = format!("{} against {of}.{mixed}{held}{unnamed}{more}", capital(&q.peak_title()));
    Some(Figure { name: format!("against-{}-{}", q.quantity.name, q.variant), svg, caption })
}

fn panel(
    area: &Area,
    a: &SweepFindings,
    q: &ByQuantity<Dependence>,
    (of, letter, most, minima): (&Against, Option<Letter>, usize, &BTreeSet<&str>),
    frame: [f64; 4],
) {
    let axis = &a.axes[of.along];
    let lines = of.lines(a, q);
    let label = axis_label(&q.quantity, q.peak_prefix());
    let y = Axis::linear(lines.iter().flatten().map(|p| p.value), &label);
    let [_, top, right, _] = frame;
    let plot = Plot { area, frame: frame.map(mm), x: scale(axis, &with(a)), y };
    plot.grid();
    let mut entries = vec![];
    let named = picked(lines.len(), most);
    let is_minimum = |p: &SweepPoint| minima.contains(p.case.as_str());
    for (n, points) in lines.iter().enumerate() {
        // If the legend names only some of the lines, their colours follow their order
        let in_order = lines.len() > most;
        let (shape, color) = if in_order { (Mark::Circle, ordered_color(n, lines.len())) } else { style(n) };
        let at = |p: &SweepPoint| plot.at(place(axis, p.at[of.along]), p.value);
        // Words and scattered values have no order that a line could follow
        for part in points.chunk_by(|p, q| is_minimum(p) == is_minimum(q)).filter(|_| axis.is_ordered()) {
            let path: Vec<_> = part.iter().map(|p| at(p)).collect();
            if in_order { line(area, &path, color, 8) } else { stroke(area, &path, n, 8) }
        }
        for p in points {
            if is_minimum(p) { hollow(area, shape, at(p), 22, color) } else { mark(area, shape, at(p), 22, color) }
        }
        if let Some(other) = of.other.filter(|_| named.contains(&n)) {
            let value = &a.axes[other].values[points[0].at[other]];
            entries.push((Sample::Mark(shape, color), entry(&a.axes[other], value)));
        }
    }
    match axis.numbers.is_empty() {
        true => word_axis(&plot, axis),
        false => plot.axes(true),
    }
    plot.title(letter, &peak_name(q));
    legend(area, (mm(right + 2.5), mm(top + 2.0)), &entries);
}

/// Draws the axes of a panel over words, each written below its position.
fn word_axis(plot: &Plot, axis: &AxisRecord) {
    plot.axis_y();
    let [left, _, right, bottom] = plot.frame;
    let wide = (right - left) / axis.values.len().max(1) as i32;
    for (k, value) in axis.values.iter().enumerate() {
        let words = shortened(&raised(value), SMALL, wide - width(" ", SMALL));
        text(plot.area, &words, (plot.at(place(axis, k), plot.y.lo).0, bottom + 38), At::Below, SMALL, INK);
    }
    text(plot.area, &axis.label, ((left + right) / 2, bottom + 125), At::Below, SMALL, INK);
}

/// The quantities of a variant that have a panel, and the end of the caption.
fn shown<'a>(a: &'a SweepFindings, variant: &str) -> (Vec<&'a ByQuantity<Dependence>>, String) {
    let mut all: Vec<_> = a.quantities.iter().filter(|q| q.variant == variant && !q.points.is_empty()).collect();
    let more = first_of(all.len(), PANELS, "quantities");
    all.truncate(PANELS);
    (all, more)
}

/// The title of a panel of peaks: `Change of cavity volume`.
fn peak_name(q: &ByQuantity<Dependence>) -> String {
    capital(&q.peak_label())
}

/// Draws the judged values over the two axes of a grid, one map per quantity; `None` unless the sweep is a grid of two axes.
pub fn map(store: &Results, a: &SweepFindings, variant: &str) -> Option<Figure> {
    let (maps, more) = shown(a, variant);
    let [first, second] = &a.axes[..] else { return None };
    if a.list || maps.is_empty() {
        return None;
    }
    // With a width of `bar` for a colour bar to the right of each: the panels, their height, and the numbers of each
    let placed = |bar: f64| {
        let panels = Panels::new(maps.len(), (LEFT + 8.0, GAP + 8.0 + bar, 3.0 + bar), (56.0 - bar, 76.0));
        let tall = panels.tall(TALL, (BETWEEN + 2.0, TOP + 13.0));
        let square = (mm(panels.each / first.values.len() as f64), mm(tall / second.values.len() as f64));
        let of =
            |q: &&ByQuantity<Dependence>| MapNumbers::of(q.points.iter().map(|p| p.value), &q.quantity.unit, square);
        (panels, tall, maps.iter().map(of).collect::<Vec<MapNumbers>>())
    };
    let (mut panels, mut tall, mut numbers) = placed(0.0);
    if !numbers.iter().all(MapNumbers::have_room) {
        (panels, tall, numbers) = placed(BAR);
    }
    let row = tall + BETWEEN + 2.0;
    let svg = figure(panels.width(), TOP + row * panels.rows() - 6.0, "", |area| {
        for (k, (q, numbers)) in maps.iter().zip(&numbers).enumerate() {
            let frame = panels.frame(k, (TOP, row), tall);
            squares(area, q, numbers, (first, second), frame);
            if !numbers.have_room() {
                numbers.color_bar(area, frame[2] + 2.0, (frame[1], frame[3]), ends(q));
            }
            let title = format!("{}{}", peak_name(q), numbers.brackets());
            let [left, top, ..] = frame.map(mm);
            headed(area, (left, top), mm(panels.each), letter(k, maps.len()), &title);
        }
    });
    let caption = format!(
        "{} over the grid, {}. An empty square has no converged case.{more}",
        a.judged.heading(),
        store.study.label(variant)
    );
    Some(Figure { name: format!("map-{variant}"), svg, caption })
}

/// Width of a colour bar to the right of a map \[mm\].
const BAR: f64 = ROOM + 2.0;

/// Smallest and largest value of a map; equal if they differ only by rounding.
fn ends(q: &ByQuantity<Dependence>) -> [f64; 2] {
    let [low, high] = q.range();
    if high - low > ROUNDING * low.abs().max(high.abs()) { [low, high] } else { [low; 2] }
}

/// Draws the squares of a map, with their numbers if all of them have room.
fn squares(
    area: &Area,
    q: &ByQuantity<Dependence>,
    numbers: &MapNumbers,
    (first, second): (&AxisRecord, &AxisRecord),
    frame: [f64; 4],
) {
    let [left, top, right, bottom] = frame;
    let (columns, rows) = (first.values.len() as f64, second.values.len() as f64);
    let (w, h) = ((right - left) / columns, (bottom - top) / rows);
    let [low, high] = ends(q);
    for p in &q.points {
        let (x, y) = (left + w * p.at[0] as f64, bottom - h * (p.at[1] + 1) as f64);
        let share = if high > low { (p.value - low) / (high - low) } else { 0.5 };
        block(area, (mm(x), mm(y)), (mm(x + w), mm(y + h)), viridis(share));
        let ink = if share > 0.6 { INK } else { RGB(0xff, 0xff, 0xff) };
        if let Some(number) = numbers.written(p.value) {
            text(area, &number, (mm(x + 0.5 * w), mm(y + 0.5 * h)), At::Middle, SMALL, ink);
        }
    }
    sides(area, (first, second), frame.map(mm), (true, mm(LEFT + 8.0)));
}

/// The distinct values of an axis in order, each by the index of its first occurrence, and for each index the number of its distinct value.
fn distinct(axis: &AxisRecord) -> (Vec<usize>, Vec<usize>) {
    let is_same = |a: usize, b: usize| match axis.numbers.is_empty() {
        true => axis.values[a] == axis.values[b],
        false => axis.numbers[a] == axis.numbers[b],
    };
    let mut found: Vec<usize> = vec![];
    for k in 0..axis.values.len() {
        if !found.iter().any(|first| is_same(*first, k)) {
            found.push(k);
        }
    }
    if !axis.numbers.is_empty() && !axis.is_ordered() {
        found.sort_by(|a, b| axis.numbers[*a].total_cmp(&axis.numbers[*b]));
    }
    let number = |k: usize| found.iter().position(|first| is_same(*first, k)).expect("every value is one of them");
    let numbers = (0..axis.values.len()).map(number).collect();
    (found, numbers)
}

/// Draws quantities over time, coloured by the first axis. The other axes of a grid are kept at one value; those that vary with it in a list are in
/// the legend.
pub fn over_time(store: &Results, a: &SweepFindings, variant: &str) -> Option<Figure> {
    let (panels, more) = shown(a, variant);
    let first = a.axes.first()?;
    if panels.is_empty() {
        return None;
    }
    let rest: Vec<usize> = (1..a.axes.len()).filter(|_| !a.list).collect();
    let kept = Kept::of(panels.iter().flat_map(|q| &q.points), &a.axes, &rest);
    let (values, numbers) = distinct(first);
    let color = |number: usize| ordered_color(number, values.len());
    let places = Panels::new(panels.len(), (LEFT, GAP, 4.0), (LEAST, 70.0));
    let across = places.width() - LEFT;
    let picked = picked(values.len(), ENTRIES).into_iter();
    let together = || std::iter::once(first).chain(other_keys(a).filter(|_| goes_along(a)));
    let words = |k: usize| together().map(|axis| entry(axis, &axis.values[k])).collect::<Vec<_>>().join(", ");
    let entries: Vec<_> = picked.map(|k| (Sample::Line(color(k)), words(values[k]))).collect();
    let legend = LINE * legend_lines(&entries, across);
    let tall = places.tall(TALL, (BETWEEN, TOP + 11.0 + legend));
    let row = tall + BETWEEN;
    let bottom = TOP + row * places.rows() - 6.0;
    let svg = figure(places.width(), bottom + legend, "", |area| {
        for (k, q) in panels.iter().enumerate() {
            let curves: Vec<(usize, Curve)> = (q.points.iter().filter(|p| kept.has(p)))
                .filter_map(|p| {
                    let stored = store.cases.iter().find(|c| c.record.id == p.case)?;
                    Some((p.at[0], Curve::of(&stored.series, &q.quantity.name)?))
                })
                .collect();
            let end = curves.iter().flat_map(|(_, c)| c.t.last().copied()).fold(0.0, f64::max);
            let y = Axis::linear(curves.iter().flat_map(|(_, c)| c.f.iter().copied()), &axis_label(&q.quantity, ""));
            let frame = places.frame(k, (TOP, row), tall).map(mm);
            let plot = Plot { area, frame, x: Axis::exact(0.0, end, &format!("time {} [s]", italic("t"))), y };
            plot.grid();
            curves.iter().for_each(|(k, c)| line(area, &plot.path(&c.t, &c.f), color(numbers[*k]), 9));
            plot.axes(true);
            plot.title(letter(k, panels.len()), &capital(&q.quantity.label));
        }
        legend_below(area, (LEFT, bottom + 0.5), across, entries);
    });
    let held = kept.words(&a.axes).map_or(String::new(), |words| format!(", with {words}"));
    let caption = format!(
        "The quantities over time, {}, coloured by {}{}{held}.{}{more}",
        store.study.label(variant),
        first.label,
        along_which(a),
        named(first, values.len(), ENTRIES).unwrap_or_default()
    );
    Some(Figure { name: format!("sweep-{variant}"), svg, caption })
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// One key is varied at a time: its value at rest has one entry, and numbers are sorted.
    #[test]
    fn equal_values_have_one_colour() {
        let numbers = [3.0, 1.0, 3.0, 2.0, 3.0];
        let values = numbers.iter().map(|n| format!("{n}")).collect();
        let axis = AxisRecord { values, numbers: numbers.into(), ..length() };
        assert_eq!(distinct(&axis), (vec![1, 3, 0], vec![2, 0, 2, 1, 2]));
        let words = ["b", "a", "b"].map(String::from).to_vec();
        assert_eq!(distinct(&AxisRecord { values: words, ..length() }), (vec![0, 1], vec![0, 1, 0]));
    }

    #[test]
    fn the_scale_is_the_more_even_one() {
        let is_log = |numbers: &[f64]| {
            let values = numbers.iter().map(|n| format!("{n}")).collect();
            scale(&AxisRecord { values, numbers: numbers.into(), ..length() }, "").log
        };
        assert!(is_log(&[5.0, 10.0, 20.0, 40.0]) && is_log(&[0.05, 0.1, 0.2, 0.3, 0.4, 0.6]));
        assert!(!is_log(&[1.0, 4.0, 8.0, 12.0]) && !is_log(&[1.0, 2.0, 3.0]));
    }
}
