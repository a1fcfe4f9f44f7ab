//! The members under one protocol: every quantity over time, with its difference from the reference below it, and loops against the quantity that
//! drives them.

use crate::report::canvas::{Area, At, INK, SMALL, columns, figure, italic, mm, page_width, text};
use crate::report::figure::{Figure, LINE, Sample, legend, legend_width, stroke};
use crate::report::numbers::capital;
use crate::report::panels::{Letter, Panels, letter, row_height};
use crate::report::plot::{Axis, Plot};
use crate::study::analysis::ByQuantity;
use crate::study::curve::Curve;
use crate::study::figures::{axis_label, first_of};
use crate::study::kinds::comparison::analysis::amount;
use crate::study::kinds::comparison::findings::{ComparedMember, ComparisonFindings, MemberDifferences};
use crate::study::kinds::comparison::finer;
use crate::study::store::record::{StoredCase, StudyRecord};
use crate::study::store::results::Results;
use crate::wording::{all, few};

const LEFT: f64 = 15.0;
const GAP: f64 = 18.0;
const LEGEND: f64 = 38.0;
const TOP: f64 = 6.0;
/// Page width from which panels are placed side by side with the legend on their right \[mm\].
const WIDE: f64 = 180.0;
/// Largest number of quantities drawn over time, and of quantities with a loop.
const MOST: usize = 3;
const MOST_LOOPS: usize = 2;
/// Largest difference that the lower panels show \[of the peak\].
const FAR: f64 = 0.5;

/// Relative difference of two runs below which it is attributed to rounding and the solver tolerance.
const RESOLVED: f64 = 1e-9;

/// A member with the number of its line style.
struct Look<'a> {
    member: &'a str,
    number: usize,
}

impl Look<'_> {
    fn draw(&self, area: &Area, points: &[(i32, i32)]) {
        stroke(area, points, self.number, 9);
    }
}

/// The line style of every member, the same in all figures.
fn looks(a: &ComparisonFindings) -> Vec<Look<'_>> {
    let members = a.costs.iter().map(|p| p.member.as_str()).enumerate();
    members.map(|(number, member)| Look { member, number }).collect()
}

/// The entries of the legend.
fn entries(store: &Results, looks: &[Look], a: &ComparisonFindings) -> Vec<(Sample, String)> {
    let entry = |l: &Look| {
        let star = if l.member == a.reference { " (reference)" } else { "" };
        (Sample::Stroke(l.number), format!("{}{star}", store.study.member(l.member)))
    };
    looks.iter().map(entry).collect()
}

/// Width of a legend to the right of the panels \[mm\].
fn room(entries: &[(Sample, String)]) -> f64 {
    // The panels keep part of the page width; longer names are shortened
    LEGEND.max(4.0 + legend_width(entries)).min(0.4 * page_width())
}

/// The curve of a member in a quantity.
fn curve<'a>(
    store: &'a Results,
    q: &ByQuantity<MemberDifferences>,
    member: &str,
    column: &str,
) -> Option<(&'a StoredCase, Curve)> {
    let case = &q.members.iter().find(|c| c.member == member)?.case;
    let stored = store.cases.iter().find(|c| c.record.id == *case)?;
    Curve::of(&stored.series, column).map(|c| (stored, c))
}

/// Draws the quantities of a variant over time; `None` if it has no quantity to compare.
pub fn over_time(store: &Results, a: &ComparisonFindings, variant: &str) -> Option<Figure> {
    let mut panels: Vec<&ByQuantity<MemberDifferences>> =
        a.quantities.iter().filter(|q| q.variant == variant).collect();
    if panels.is_empty() {
        return None;
    }
    let more = first_of(panels.len(), MOST, "quantities");
    panels.truncate(MOST);
    let is_drawn = |l: &Look| panels.iter().any(|q| curve(store, q, l.member, &q.quantity.name).is_some());
    let (looks, missing): (Vec<Look>, Vec<Look>) = looks(a).into_iter().partition(is_drawn);
    let entries = entries(store, &looks, a);
    // On a narrow page, panels are stacked with the legend below them; the type size is never reduced
    let is_narrow = page_width() < WIDE;
    let side = if is_narrow { 5.0 } else { room(&entries) };
    let across = if is_narrow { columns(panels.len(), (LEFT, GAP, 60.0)) } else { panels.len() };
    let n = across as f64;
    let each = ((page_width() - LEFT - side - GAP * (n - 1.0)) / n).min(84.0);
    let width = LEFT + n * each + (n - 1.0) * GAP + side;
    let (low, between) = (26.0, 5.0);
    let others = TOP + between + low + 10.0;
    let rows = panels.len().div_ceil(across) as f64;
    let legend_below = if is_narrow { LINE * entries.len() as f64 + 1.0 } else { 0.0 };
    let tall = row_height(42.0, rows, (others, others + legend_below));
    let row = tall + others;
    let below = row * rows;
    let height = match is_narrow {
        true => below + legend_below,
        false => row.max(TOP + 4.2 * looks.len() as f64 + 4.0),
    };
    let svg = figure(width, height, "", |area| {
        for (k, q) in panels.iter().enumerate() {
            let (x, top) = (LEFT + (k % across) as f64 * (each + GAP), TOP + row * (k / across) as f64);
            let upper = [mm(x), mm(top), mm(x + each), mm(top + tall)];
            let lower = [mm(x), mm(top + tall + between), mm(x + each), mm(top + tall + between + low)];
            panel(area, store, a, q, &looks, (upper, lower), letter(k, panels.len()));
        }
        let at = if is_narrow { (LEFT, below + 2.0) } else { (width - side + 4.0, TOP + 2.0) };
        legend(area, (mm(at.0), mm(at.1)), &entries);
    });
    let is_judged = panels.iter().any(|q| finer::is_judged(q, &a.reference));
    let finer = if is_judged { " What a finer mesh changes is in the table." } else { "" };
    let missing: Vec<String> = missing.iter().map(|l| store.study.member(l.member)).collect();
    let without =
        if missing.is_empty() { String::new() } else { format!(" Without a curve to compare: {}.", few(&missing)) };
    let caption = format!(
        "The members under the same protocol, {}: each quantity over time (top) and its difference to {} (bottom).{more}{}{without}{finer}",
        store.study.label(variant),
        store.study.member(&a.reference),
        too_far(&store.study, &panels)
    );
    Some(Figure { name: format!("comparison-{variant}"), svg, caption })
}

/// The members that the lower panels leave out, panel by panel.
fn too_far(study: &StudyRecord, panels: &[&ByQuantity<MemberDifferences>]) -> String {
    let one = |(k, q): (usize, &&ByQuantity<MemberDifferences>)| {
        let far = q.members.iter().filter(|c| c.largest > FAR).map(|c| study.member(&c.member));
        let far: Vec<String> = far.collect();
        let place = letter(k, panels.len()).map_or(String::new(), |letter| format!("in ({letter}) "));
        let limit = match q.quantity.tolerance(study.tolerance).is_absolute(q.peak) {
            true => amount(q, FAR, study.tolerance),
            false => format!("half of its {}", q.peak_is.trim_end_matches(" of")),
        };
        (!far.is_empty()).then(|| format!("{place}{}, by more than {limit}", all(&far)))
    };
    let found: Vec<String> = panels.iter().enumerate().filter_map(one).collect();
    match found.is_empty() {
        true => String::new(),
        false => format!(" Too far from the reference to be drawn there: {}.", found.join("; ")),
    }
}

fn panel(
    area: &Area,
    store: &Results,
    a: &ComparisonFindings,
    q: &ByQuantity<MemberDifferences>,
    looks: &[Look],
    (upper, lower): ([i32; 4], [i32; 4]),
    letter: Option<Letter>,
) {
    let of = |member: &str| curve(store, q, member, &q.quantity.name).map(|c| c.1);
    let curves: Vec<(&Look, Curve)> = looks.iter().filter_map(|l| Some((l, of(l.member)?))).collect();
    let times = || curves.iter().flat_map(|(_, c)| c.t.iter().copied());
    let time = Axis::exact(
        times().fold(f64::INFINITY, f64::min),
        times().fold(f64::NEG_INFINITY, f64::max),
        &format!("time {} [s]", italic("t")),
    );
    let near = |look: &Look| q.members.iter().any(|c| c.member == look.member && c.largest <= FAR);
    let difference = |g: &Curve, c: &Curve| {
        let t = c.common(g);
        let d = t.iter().map(|t| c.at(*t) - g.at(*t)).collect::<Vec<f64>>();
        (t, d)
    };
    let reference = of(&a.reference);
    let off: Vec<_> = (curves.iter().filter(|(look, _)| near(look)))
        .filter_map(|(look, c)| Some((*look, difference(reference.as_ref()?, c))))
        .collect();
    // With the reference alone there is no difference to draw
    let is_compared = off.iter().any(|(look, _)| look.member != a.reference);
    let values = curves.iter().flat_map(|(_, c)| c.f.iter().copied());
    let plot = Plot { area, frame: upper, x: time.clone(), y: Axis::linear(values, &axis_label(&q.quantity, "")) };
    plot.grid();
    for (look, c) in curves.iter().rev() {
        look.draw(area, &plot.path(&c.t, &c.f));
    }
    plot.axes(!is_compared);
    plot.title(letter, &capital(&q.quantity.label));
    if !is_compared {
        return;
    }
    let size = curves.iter().flat_map(|(_, c)| &c.f).fold(0.0, |m: f64, v| m.max(v.abs()));
    let is_rounding = off.iter().flat_map(|(_, (_, d))| d).all(|d| d.abs() <= RESOLVED * size);
    // Differences that are rounding are drawn as zero, on an axis scaled to what could be visible
    let least = if is_rounding { [-1e3 * RESOLVED * size, 1e3 * RESOLVED * size] } else { [0.0; 2] };
    let values = off.iter().flat_map(|(_, (_, d))| d.iter().copied()).chain(least);
    let symbol = &q.quantity.symbol;
    let label = format!("{0} − {0}(reference) [{1}]", italic(symbol), q.quantity.unit);
    let plot = Plot { area, frame: lower, x: time, y: Axis::linear(values, &label) };
    plot.grid();
    for (look, (t, d)) in off.iter().rev() {
        look.draw(area, &plot.path(t, d));
    }
    plot.axes(true);
    if is_rounding {
        let at = (lower[0] + mm(2.0), lower[1] + mm(2.5));
        text(area, "no difference beyond rounding", at, At::Left, SMALL, INK);
    }
}

/// Whether a member loses more than a hundredth of the box around the cycle.
fn is_open(c: &ComparedMember) -> bool {
    c.loop_share.is_some_and(|s| s > 0.01)
}

/// Draws quantities against the quantity that drives them if a member shows a loop; `None` if none does.
pub fn loops(store: &Results, a: &ComparisonFindings, variant: &str) -> Option<Figure> {
    let open = |q: &&ByQuantity<MemberDifferences>| q.members.iter().any(is_open);
    let mut panels: Vec<&ByQuantity<MemberDifferences>> =
        a.quantities.iter().filter(|q| q.variant == variant).filter(open).collect();
    if panels.is_empty() {
        return None;
    }
    let more = first_of(panels.len(), MOST_LOOPS, "quantities with a loop");
    panels.truncate(MOST_LOOPS);
    let shown = |l: &Look| {
        l.member == a.reference || panels.iter().any(|q| q.members.iter().any(|c| c.member == l.member && is_open(c)))
    };
    let looks: Vec<Look> = looks(a).into_iter().filter(shown).collect();
    let (tall, row) = (46.0, 63.0);
    let entries = entries(store, &looks, a);
    let places = Panels::new(panels.len(), (LEFT, GAP, 5.0), (50.0, 70.0));
    let bottom = TOP + row * places.rows() - 4.0;
    let svg = figure(places.width(), bottom + LINE * entries.len() as f64, "", |area| {
        for (k, q) in panels.iter().enumerate() {
            let Some(against) = &q.quantity.against else { continue };
            let frame = places.frame(k, (TOP, row), tall).map(mm);
            let pair = |l: &Look| {
                let (case, f) = curve(store, q, l.member, &q.quantity.name)?;
                Some((Curve::of(&case.series, &against.name)?, f))
            };
            let curves: Vec<_> = looks.iter().filter_map(|l| Some((l, pair(l)?))).collect();
            let xs = curves.iter().flat_map(|(_, (x, _))| x.f.iter().copied());
            let ys = curves.iter().flat_map(|(_, (_, f))| f.f.iter().copied());
            let x = Axis::linear(xs, &axis_label(against, ""));
            let plot = Plot { area, frame, x, y: Axis::linear(ys, &axis_label(&q.quantity, "")) };
            plot.grid();
            for (look, (x, f)) in curves.iter().rev() {
                look.draw(area, &plot.path(&x.f, &f.f));
            }
            plot.axes(true);
            plot.title(letter(k, panels.len()), &capital(&q.quantity.label));
        }
        legend(area, (mm(LEFT), mm(bottom)), &entries);
    });
    let caption = format!(
        "Loading and unloading, {}, of the members that show a loop, and of the reference: the area of a loop is lost in every cycle.{more}",
        store.study.label(variant)
    );
    Some(Figure { name: format!("loops-{variant}"), svg, caption })
}
