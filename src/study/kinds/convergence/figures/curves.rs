//! The deciding quantities of a variant against time for the sizes, with the Richardson curve and its GCI band; below each, the difference from the
//! Richardson curve, where the meshes become distinguishable.

use crate::report::canvas::{INK, PALETTE, RGB, columns, dashed, figure, fill, italic, mm, page_width};
use crate::report::figure::{Figure, Sample, legend, legend_below, legend_lines, legend_width, stroke};
use crate::report::names::title;
use crate::report::numbers::{capital, thousands};
use crate::report::panels::{Letter, letter, row_height};
use crate::report::plot::{Axis, Plot};
use crate::report::unit::labelled;
use crate::study::curve::Curve;
use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::richardson::CAUTIOUS_FACTOR;
use crate::study::figures::{PANELS, axis_label, first_of};
use crate::study::kinds::convergence::findings::ConvergenceFindings;
use crate::study::store::record::{Role, StoredCase, StudyQuantity};
use crate::study::store::results::Results;
use plotters::style::Color;

/// Colour of the GCI band, pale enough for lines on top.
const BAND: RGB = RGB(0xd8, 0xd8, 0xd8);

/// Page width below which there is no room for a legend on the right, and smallest width of a panel \[mm\].
const NARROW: f64 = 130.0;
const LEAST: f64 = 50.0;

/// Draws the curves of a variant; `None` if no case of the sizes has a series in it.
pub fn draw(store: &Results, analysis: &ConvergenceFindings, variant: &str) -> Option<Figure> {
    let family = store.study.families.iter().find(|f| f.role == Role::Sizes)?;
    let mut cases: Vec<&StoredCase> =
        (store.cases.iter()).filter(|c| c.is_in(&family.name, variant) && c.record.converged()).collect();
    cases.sort_by(|a, b| a.record.mesh.h_m.total_cmp(&b.record.mesh.h_m));
    let all = cases.len();
    cases.truncate(PALETTE.len() - 1);
    // The recommended case comes last if it is not one of the sizes
    let sizes = cases.len();
    if let Some(r) = &analysis.recommended {
        let here = |c: &&StoredCase| c.is_of(variant) && r.cases.contains(&c.record.id);
        cases.extend(store.cases.iter().find(here).filter(|c| !c.is_in(&family.name, variant)));
    }
    let shown = shown(analysis, variant, &cases);
    let more = first_of(shown.len(), PANELS, "quantities");
    let panels: Vec<(StudyQuantity, Option<&CurveStudy>)> = (shown.into_iter())
        .take(PANELS)
        .map(|q| {
            let study = analysis.find(variant, &q.name);
            let curves = study.and_then(|q| q.curves.iter().find(|(f, _)| *f == family.name)).map(|(_, c)| c);
            (q.clone(), curves)
        })
        .collect();
    if panels.is_empty() {
        return None;
    }
    let (left, gap) = (14.0, 17.0);
    // The legend is on the right if there is room for it
    let is_narrow = page_width() < NARROW;
    let has_limit = panels.iter().any(|(_, s)| s.is_some_and(|s| !s.star.is_empty()));
    let entries = entries(&cases, sizes, has_limit);
    let legend_width = if is_narrow { 4.0 } else { 4.0 + legend_width(&entries).clamp(30.0, 60.0) };
    let columns = columns(panels.len(), (left + legend_width, gap, LEAST));
    let each = (page_width() - left - legend_width - gap * (columns as f64 - 1.0)) / columns as f64;
    let (first, low, between) = (6.0, 24.0, 5.0);
    let lines = if is_narrow { 4.2 * legend_lines(&entries, page_width() - left) + 3.0 } else { 0.0 };
    let rows = panels.len().div_ceil(columns) as f64;
    let others = first + if has_limit { between + low } else { 0.0 } + 11.0;
    let tall = row_height(42.0, rows, (others, others + lines));
    let row = tall + others;
    let bottom = row * rows;
    let svg = figure(page_width(), bottom - 1.0 + lines, "", |area| {
        for (k, (quantity, study)) in panels.iter().enumerate() {
            let (x, top) = (left + (k % columns) as f64 * (each + gap), first + row * (k / columns) as f64);
            let upper = [mm(x), mm(top), mm(x + each), mm(top + tall)];
            let lower = [mm(x), mm(top + tall + between), mm(x + each), mm(top + tall + between + low)];
            panel(area, &cases, quantity, *study, (upper, lower), letter(k, panels.len()));
        }
        if is_narrow {
            legend_below(area, (left, bottom + 1.5), page_width() - left, entries);
        } else {
            legend(area, (mm(page_width() - legend_width + 4.0), mm(first + 2.0)), &entries);
        }
    });
    let orders = orders(&panels);
    let star = if sizes < cases.len() { " The curve with a star is the advised setting." } else { "" };
    let below =
        if has_limit { " (top) and their difference to the Richardson curve of the family (bottom)" } else { "" };
    let meshes = if sizes < all { format!("the finest {sizes} of {all} meshes") } else { "the meshes".into() };
    let caption = format!(
        "{}, family {}: {meshes} (element and cells) over time{below}.{star}{orders}{more}",
        capital(&store.study.label(variant)),
        family.name
    );
    Some(Figure { name: format!("curves-{variant}"), svg, caption })
}

/// The entries of the legend: the meshes, with a star for the recommended one that is not among the sizes, and the limit if it is drawn.
fn entries(cases: &[&StoredCase], sizes: usize, has_limit: bool) -> Vec<(Sample, String)> {
    let name = |c: &&StoredCase| format!("{} {}", title(&c.record.formulation), thousands(c.record.mesh.cells));
    let mut entries: Vec<_> = cases.iter().enumerate().map(|(k, c)| (Sample::Stroke(k), name(c))).collect();
    if let Some(e) = entries.get_mut(sizes) {
        e.1 += " *";
    }
    if has_limit {
        entries.push((Sample::Dashed(INK), "Richardson".into()));
        entries.push((Sample::Block(BAND), "± GCI of the finest".into()));
    }
    entries
}

/// The quantities with a panel: those that decide in the variant.
fn shown<'a>(analysis: &'a ConvergenceFindings, variant: &str, cases: &[&StoredCase]) -> Vec<&'a StudyQuantity> {
    let deciding = analysis.quantities.iter().filter(|q| q.variant == variant && q.deciding).map(|q| &q.quantity);
    deciding.filter(|q| cases.iter().any(|c| Curve::of(&c.series, &q.name).is_some())).collect()
}

/// The orders of the curves of all quantities, in a sentence.
fn orders(panels: &[(StudyQuantity, Option<&CurveStudy>)]) -> String {
    let words: Vec<String> = panels
        .iter()
        .filter_map(|(q, s)| {
            let s = s.as_ref()?;
            let p = s.order_used?;
            Some(match s.observed_order {
                Some(_) if s.fs < CAUTIOUS_FACTOR => format!("{}: global order p = {p:.2}", q.label),
                Some(seen) => format!("{}: order {seen:.2} observed, p = {p:.2} used, Fs = 3", q.label),
                None => format!(
                    "{}: no order observed, p = {p:.0} assumed, GCI of first order with Fs = {:.0}",
                    q.label, s.fs
                ),
            })
        })
        .collect();
    if words.is_empty() { String::new() } else { format!(" {}.", capital(&words.join("; "))) }
}

fn panel(
    area: &crate::report::canvas::Area,
    cases: &[&StoredCase],
    q: &StudyQuantity,
    study: Option<&CurveStudy>,
    (upper, lower): ([i32; 4], [i32; 4]),
    letter: Option<Letter>,
) {
    let curves: Vec<Option<Curve>> = cases.iter().map(|c| Curve::of(&c.series, &q.name)).collect();
    let all = || curves.iter().flatten();
    let times = all().flat_map(|c| c.t.iter().copied());
    let (lo, hi) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    let time = Axis::exact(lo, hi, &format!("time {} [s]", italic("t")));
    let study = study.filter(|s| !s.star.is_empty());
    let band = |sign: f64| {
        study.iter().flat_map(|s| s.star.iter().zip(&s.gci).map(move |(f, g)| f + sign * g)).collect::<Vec<f64>>()
    };
    let values = all().flat_map(|c| c.f.iter().copied()).chain(band(1.0)).chain(band(-1.0));
    let plot = Plot { area, frame: upper, x: time.clone(), y: Axis::linear(values, &axis_label(q, "")) };
    plot.grid();
    if let Some(s) = study {
        // Band around f*, by the uncertainty of the finest mesh
        let mut ring = plot.path(&s.t, &band(1.0));
        ring.extend(plot.path(&s.t, &band(-1.0)).into_iter().rev());
        fill(area, &ring, BAND.to_rgba());
    }
    for (k, c) in curves.iter().enumerate().rev() {
        if let Some(c) = c {
            stroke(area, &plot.path(&c.t, &c.f), k, 9);
        }
    }
    if let Some(s) = study {
        dashed(area, &plot.path(&s.t, &s.star), INK, 8, 30.0);
    }
    let alike = if study.is_none() && same(&curves) { ", the same on all meshes" } else { "" };
    plot.axes(study.is_none());
    plot.title(letter, &format!("{}{alike}", capital(&q.label)));
    let Some(s) = study else { return };
    let star = Curve { t: s.t.clone(), f: s.star.clone() };
    let off: Vec<Option<Vec<f64>>> =
        (curves.iter()).map(|c| c.as_ref().map(|c| s.t.iter().map(|t| c.at(*t) - star.at(*t)).collect())).collect();
    let minus: Vec<f64> = s.gci.iter().map(|g| -g).collect();
    let values = off.iter().flatten().flatten().chain(&s.gci).chain(&minus).copied();
    let label = labelled(&format!("{} − {}", italic(&q.symbol), italic(&format!("{}*", q.symbol))), &q.unit);
    let plot = Plot { area, frame: lower, x: time, y: Axis::linear(values, &label) };
    plot.grid();
    let mut ring = plot.path(&s.t, &s.gci);
    ring.extend(plot.path(&s.t, &minus).into_iter().rev());
    fill(area, &ring, BAND.to_rgba());
    for (k, d) in off.iter().enumerate().rev() {
        if let Some(d) = d {
            stroke(area, &plot.path(&s.t, d), k, 9);
        }
    }
    dashed(area, &[plot.at(plot.x.lo, 0.0), plot.at(plot.x.hi, 0.0)], INK, 8, 30.0);
    plot.axes(true);
}

/// Relative difference of whole curves \[of their range\] below which they count as equal.
const ALIKE: f64 = 1e-6;

/// Whether all meshes have the same curve at all times, relative to its range.
fn same(curves: &[Option<Curve>]) -> bool {
    let all: Vec<&Curve> = curves.iter().flatten().collect();
    let [first, others @ ..] = &all[..] else { return false };
    let range = |c: &Curve| {
        c.f.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v)) - c.f.iter().fold(f64::INFINITY, |m, v| m.min(*v))
    };
    let near = |c: &&&Curve| c.common(first).iter().all(|t| (c.at(*t) - first.at(*t)).abs() <= ALIKE * range(first));
    !others.is_empty() && others.iter().all(|c| near(&c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_the_same_as_a_whole_and_relative_to_their_range() {
        let of = |f: [f64; 3]| Some(Curve { t: vec![0.0, 0.5, 1.0], f: f.into() });
        assert!(same(&[of([0.0, 1.0, 2.0]), of([0.0, 1.0 + 1e-9, 2.0])]));
        assert!(!same(&[of([0.0, 1.0, 2.0]), of([0.0, 1.2, 2.0])]), "the same peak only");
        assert!(!same(&[of([40.0, 40.0, 40.0 + 8e-8]), of([40.0, 40.0, 40.0 + 6e-8])]), "a small range");
        assert!(!same(&[of([0.0, 1.0, 2.0])]));
    }
}
