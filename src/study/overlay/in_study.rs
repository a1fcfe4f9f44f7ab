//! Measured curves laid over the recorded ones of the cases of a study: one figure per measured curve and variant, and the distances of all cases.

use crate::report::canvas::{INK, MARKS, PALETTE, figure, hollow, italic, line, mm, unmarked};
use crate::report::figure::{Drawn, Figure, Sample, WithLegend, drawn, legend};
use crate::report::numbers::percent_cell;
use crate::report::plot::{Axis, Plot};
use crate::report::table::{Table, headings};
use crate::scene::Measured;
use crate::scene::column::label;
use crate::study::figures::axis_label;
use crate::study::overlay::distance::{Distance, origin};
use crate::study::overlay::figure::{BARS, bars, reach};
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::study::store::results::Results;

/// Largest number of cases in one figure: as many as there are colours besides that of the measured curve.
pub(super) const SHOWN: usize = PALETTE.len() - 1;

/// The figures of all measured curves.
pub fn figures(store: &Results) -> Vec<Drawn> {
    let mut out = vec![];
    for variant in &store.study.variants {
        let cases: Vec<&StoredCase> = store.cases.iter().filter(|c| c.is_of(variant)).collect();
        let mut curves: Vec<&Measured> = vec![];
        for m in cases.iter().flat_map(|c| &c.record.measured) {
            if !curves.contains(&m) {
                curves.push(m);
            }
        }
        for (k, measured) in curves.into_iter().enumerate() {
            let name = format!("compare-{variant}-{}", k + 1);
            let of = || cases.iter().copied().filter(|c| c.record.measured.contains(measured)).collect::<Vec<_>>();
            out.extend(drawn(&name, || draw(store, (&name, variant), measured, &shown(&of()), of().len())));
        }
    }
    out
}

/// The cases to show: all of them, or the one with most cells of each family if there are too many.
pub(super) fn shown<'a>(cases: &[&'a StoredCase]) -> Vec<&'a StoredCase> {
    if cases.len() <= SHOWN {
        return cases.to_vec();
    }
    let mut finest: Vec<&StoredCase> = vec![];
    for case in cases {
        match finest.iter_mut().find(|known| known.record.family == case.record.family) {
            Some(known) if known.record.mesh.cells < case.record.mesh.cells => *known = case,
            Some(_) => {}
            None => finest.push(case),
        }
    }
    finest.truncate(SHOWN);
    finest
}

fn draw(
    store: &Results,
    (name, variant): (&str, &str),
    measured: &Measured,
    cases: &[&StoredCase],
    all: usize,
) -> Figure {
    let (left, top, tall) = (18.0, 4.0, 60.0);
    let WithLegend { wide, legend: key, size } =
        WithLegend::new((left, top, top + tall + 12.0), 1.0 + cases.len() as f64);
    let column = |c: &StoredCase, name: &str| match name {
        "t_s" => c.series.t_s.clone(),
        name => c.series.columns.get(name).cloned().unwrap_or_default(),
    };
    let curves: Vec<[Vec<f64>; 2]> =
        cases.iter().map(|c| [column(c, &measured.over), column(c, &measured.column)]).collect();
    let values = |k: usize, own: &[f64]| {
        curves.iter().flat_map(|c| c[k].iter().copied()).chain(own.iter().copied()).collect::<Vec<_>>().into_iter()
    };
    let [over, own] = [&measured.over, &measured.column].map(|name| named(store, variant, name));
    let svg = figure(size.0, size.1, "", |area| {
        let plot = Plot {
            area,
            frame: [mm(left), mm(top), mm(left + wide), mm(top + tall)],
            x: Axis::linear(values(0, &measured.x), &over),
            y: Axis::linear(values(1, &reach(measured).collect::<Vec<_>>()), &own),
        };
        plot.grid();
        for (k, [x, y]) in curves.iter().enumerate() {
            line(area, &plot.path(x, y), PALETTE[k % SHOWN], 10);
        }
        bars(&plot, measured, INK);
        for at in plot.path(&measured.x, &measured.y) {
            hollow(area, MARKS[0], at, 22, INK);
        }
        plot.axes(true);
        let ids = cases.iter().enumerate().map(|(k, c)| (Sample::Line(PALETTE[k % SHOWN]), c.record.id.clone()));
        let entries: Vec<(Sample, String)> =
            std::iter::once((Sample::Hollow(MARKS[0], INK), "measured".to_string())).chain(ids).collect();
        legend(area, (mm(key.0), mm(key.1)), &entries);
    });
    let of = |c: &&StoredCase| {
        let d = distance(&c.record, measured)?;
        let inside = d.inside_words().map_or(String::new(), |words| format!(", {words}"));
        Some(format!("{}: {:.2} % (L2), {:.2} % (largest){inside}", c.record.id, 100.0 * d.l2, 100.0 * d.largest))
    };
    let far: Vec<String> = cases.iter().filter_map(of).collect();
    let far = if far.is_empty() { "no range in common".into() } else { far.join("; ") };
    let rest = if cases.len() < all { " Of each family the finest mesh is shown." } else { "" };
    let bars = if measured.half_widths.is_empty() { "" } else { BARS };
    let caption = format!(
        "Measured {} ({}) and that of the simulation, {}. Distances from the measured curve: {far}.{bars}{rest}",
        unmarked(&own).split(" [").next().unwrap_or_default(),
        origin(&measured.source, &measured.columns),
        store.study.label(variant)
    );
    Figure { name: name.into(), svg, caption }
}

/// The label of a column in the study, or one made from its own name.
fn named(store: &Results, variant: &str, column: &str) -> String {
    let judged = store.study.quantities.get(variant).into_iter().flatten().find(|q| q.name == column);
    match judged {
        Some(q) => axis_label(q, ""),
        None if column == "t_s" => format!("time {} [s]", italic("t")),
        None => label(column),
    }
}

fn distance<'a>(r: &'a CaseRecord, m: &Measured) -> Option<&'a Distance> {
    r.distances.iter().find(|d| d.is_from(m))
}

/// Table of the distances of all cases from measured curves; `None` if nothing was measured.
pub fn table(store: &Results) -> Option<Table> {
    let curves = |r: &CaseRecord| -> Vec<Vec<String>> {
        let row = |d: &Distance| {
            let [l2, largest] = [d.l2, d.largest].map(percent_cell);
            let inside = d.inside.map_or("–".into(), |n| n.to_string());
            let names = [&r.id, &d.column, &d.over, &d.file, &d.columns].map(String::clone);
            names.into_iter().chain([d.share_words(), d.range_words(), l2, largest, inside]).collect()
        };
        r.distances.iter().map(row).collect()
    };
    let rows: Vec<Vec<String>> = store.cases.iter().flat_map(|c| curves(&c.record)).collect();
    (!rows.is_empty()).then(|| Table {
        name: "compare",
        caption: "Distances of recorded curves from measured ones in their common range, as shares of the measured curve: root mean square and largest; and the points at which the recorded curve is within the uncertainty of the measured one, where that was given.".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Column", "", false),
            ("Over", "", false),
            ("File", "", false),
            ("Columns of the file", "", false),
            ("Points", "", true),
            ("Range", "", true),
            ("L2", "%", true),
            ("Largest", "%", true),
            ("Within uncertainty", "", true),
        ]),
        rows,
        pick: None,
    })
}
