//! Report of a cost study.

use crate::report::figure::drawn;
use crate::report::names::title;
use crate::report::numbers::{digits, percent, percent_cell, seconds, significant, times};
use crate::report::table::{Table, headings};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::figures::time;
use crate::study::kinds::cost::figures::growth;
use crate::study::kinds::cost::figures::work;
use crate::study::kinds::cost::findings::{CostFindings, CostOfAccuracy, Grows, Measure};
use crate::study::kinds::cost::line::How;
use crate::study::store::record::CaseRecord;
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map, Value, json};

pub fn content(store: &Results, a: &Analysis<CostFindings>) -> Content {
    let variants = || store.study.variants.iter();
    let precision = |v: &String| drawn("precision", || work::precision(store, a, v));
    let amounts = |v: &String| drawn("amounts", || work::amounts(store, a, v));
    let times = |v: &String| time::of_variant(store, v, &format!("time-{v}"));
    let mut figures: Vec<_> = variants().filter_map(precision).chain(variants().filter_map(amounts)).collect();
    figures.extend(variants().filter_map(|v| drawn("growth", || growth::draw(store, a, v))));
    figures.extend(variants().flat_map(times));
    let supported = a.quantities.iter().any(|q| q.answers.iter().any(|x| x.cheapest.is_some()));
    Content {
        facts: a.quantities.iter().filter_map(|q| fact(q, a.tolerance)).collect(),
        sentences: a.quantities.iter().map(|q| q.sentence.clone()).collect(),
        analysis: analysis(a),
        tables: vec![costs(a), laws(a), settings(a)],
        folded: vec![
            ("Time by phase", phases(store)),
            ("Every case", tables::cases(store)),
            ("Time per effect", tables::effects(store)),
        ],
        figures,
        claims: a.quantities.iter().flat_map(claims).collect(),
        decisions: a.quantities.iter().map(|q| decision(q, a.tolerance)).collect(),
        ..Content::new(a, supported, ("The cheapest setting for an error", cheapest(a)))
    }
}

/// Decides whether some setting meets the tolerance; which one is cheapest depends on measured times.
fn decision(q: &ByQuantity<CostOfAccuracy>, tolerance: f64) -> (String, String) {
    let met = q.answer(Measure::Peak, tolerance).is_some_and(|a| a.cheapest.is_some());
    let what = format!("{}, {} is within the tolerance in some setting", q.quantity.name, q.variant);
    (what, if met { "yes" } else { "no" }.into())
}

/// The peak of a quantity in every setting, with its error bar.
fn claims(q: &ByQuantity<CostOfAccuracy>) -> impl Iterator<Item = Claim> + '_ {
    q.settings.iter().enumerate().filter_map(|(k, s)| {
        let half = q.bar(k, Measure::Peak) * q.reference.as_ref()?.scale;
        Claim::of_case(&s.case, &q.quantity.name, s.value, half, &q.quantity.unit)
    })
}

/// The cost of the peak at the tolerance.
fn fact(q: &ByQuantity<CostOfAccuracy>, tolerance: f64) -> Option<(String, String)> {
    let s = &q.settings[q.answer(Measure::Peak, tolerance)?.cheapest?];
    Some((seconds(s.cost_s), format!("{} within {} ({})", q.peak_title(), percent(tolerance), s.label)))
}

fn analysis(a: &Analysis<CostFindings>) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("levels".into(), json!(a.levels));
    out.insert("incomplete".into(), json!(a.incomplete));
    out.insert("growth".into(), json!(a.growth));
    out.extend(ByQuantity::as_json(&a.quantities));
    out
}

fn hundredths(share: f64) -> String {
    percent_cell(share)
}

fn cost(s: f64) -> String {
    format!("{s:.*}", digits(s))
}

fn cheapest(a: &CostFindings) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for x in &q.answers {
            let mut row = vec![q.quantity.label.clone(), q.variant.clone(), x.measure.words().into(), percent(x.level)];
            let bar = |k: usize| hundredths(q.bar(k, x.measure));
            row.extend(match x.cheapest {
                Some(k) => [q.settings[k].label.clone(), bar(k), cost(q.settings[k].cost_s)],
                None => ["none".into(), "–".into(), "–".into()],
            });
            row.extend(match x.next {
                Some(k) => [q.settings[k].label.clone(), bar(k), cost(q.settings[k].cost_s)],
                None => ["–".into(), "–".into(), "–".into()],
            });
            rows.push(row);
        }
    }
    Table {
        name: "cheapest",
        caption: "The cheapest setting whose error bar (error with the uncertainty of the reference) is within a level, and the next more expensive one \
                  with a smaller error. CPU time.".into(),
        columns: headings(&[
            ("Quantity", "", false), ("Variant", "", false), ("Of the", "", false), ("Within", "", true), ("Setting", "", false),
            ("Error bar", "%", true), ("Cost", "s", true), ("Next better", "", false), ("Its error bar", "%", true), ("Its cost", "s", true),
        ]),
        rows,
        pick: None,
    }
}

/// Costs of one error, family by family, over that of the cheapest.
fn costs(a: &CostFindings) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for (k, level) in a.levels.iter().enumerate() {
            let of = |l: &crate::study::kinds::cost::line::Line| l.costs[k].map(|p| p.seconds);
            let least = q.lines.iter().filter_map(of).fold(f64::INFINITY, f64::min);
            for l in &q.lines {
                let mut row = vec![q.quantity.label.clone(), q.variant.clone(), percent(*level), l.label.clone()];
                row.extend(match l.costs[k] {
                    None => ["–".to_string(), "–".into(), "–".into(), "its most expensive case is above it".into()],
                    Some(p) => [
                        p.words(),
                        p.interval.map_or("–".into(), |[low, high]| format!("{} to {}", seconds(low), seconds(high))),
                        times(p.seconds / least),
                        match p.how {
                            How::AtMost => "its coarsest case".into(),
                            How::Between => "between its cases".into(),
                            How::Extrapolated => "extrapolated".into(),
                        },
                    ],
                });
                rows.push(row);
            }
        }
    }
    Table {
        name: "iso-error",
        caption: "What one error of the peak costs in every family: read off between its cases, or from a power law through all of them (with \
                  its 95 % interval), and over the cheapest family.".into(),
        columns: headings(&[
            ("Quantity", "", false), ("Variant", "", false), ("Error", "", true), ("Family", "", false), ("CPU time", "", true),
            ("Interval", "", true), ("Over the cheapest", "", true), ("From", "", false),
        ]),
        rows,
        pick: None,
    }
}

fn laws(a: &CostFindings) -> Table {
    let rows = (a.growth.iter())
        .map(|l| {
            let shown =
                |v: f64| if l.of == Grows::Time { seconds(v) } else { format!("{} MB", significant(1e-6 * v, 2)) };
            let between = |[low, high]: [f64; 2]| format!("{} to {}", shown(low), shown(high));
            vec![
                l.variant.clone(),
                title(&l.formulation),
                if l.of == Grows::Time { "CPU time" } else { "memory" }.into(),
                format!("{:.*}", l.law.half.map_or(2, digits), l.law.q),
                l.law.half.map_or("–".into(), |h| format!("{h:.*}", digits(h))),
                l.law.points.to_string(),
                format!("{:.0}", l.next_cells),
                shown(l.next.value),
                l.next.interval.map_or("–".into(), between),
                l.check.map_or("–".into(), hundredths),
            ]
        })
        .collect();
    Table {
        name: "growth",
        caption: "Power laws over the cells: exponent with the half width of its 95 % interval, what twice the most cells would take, and as a \
                  check the largest mesh as predicted from the others over what was measured.".into(),
        columns: headings(&[
            ("Variant", "", false), ("Element", "", false), ("Of", "", false), ("Exponent", "", true), ("±", "", true), ("Meshes", "", true),
            ("Next size", "cells", true), ("Would take", "", true), ("95 % interval", "", true), ("Check", "%", true),
        ]),
        rows,
        pick: None,
    }
}

fn settings(a: &CostFindings) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for s in &q.settings {
            let front = match s.front {
                [true, true] => "peak, curve",
                [true, false] => "peak",
                [false, true] => "curve",
                _ => "–",
            };
            rows.push(vec![
                s.label.clone(),
                q.quantity.label.clone(),
                q.variant.clone(),
                cost(s.cost_s),
                s.spread.map_or("–".into(), |v| format!("{:.0}", 100.0 * v)),
                hundredths(s.errors[0]),
                hundredths(s.errors[1]),
                front.into(),
                s.dofs.to_string(),
                s.factor_nnz.to_string(),
                format!("{:.2e}", s.flops),
                s.memory_bytes.map_or("–".into(), |b| format!("{:.0}", 1e-6 * b as f64)),
            ]);
        }
    }
    Table {
        name: "settings",
        caption: "Every setting, cheapest first: median CPU time with the spread of the repeats, errors against the reference, and what it consists of.".into(),
        columns: headings(&[
            ("Setting", "", false), ("Quantity", "", false), ("Variant", "", false), ("Cost", "s", true), ("Spread", "%", true),
            ("Error of the peak", "%", true), ("Of the curve", "%", true), ("Front", "", false), ("DOFs", "", true), ("nnz(L)", "", true),
            ("Operations", "", true), ("Memory", "MB", true),
        ]),
        rows,
        pick: None,
    }
}

/// Time in contact and its friction \[s\].
fn contact(r: &CaseRecord) -> f64 {
    r.effects
        .iter()
        .filter(|e| matches!(e.role.as_deref(), Some("contact" | "friction")))
        .fold(0.0, |s, e| s + e.wall_s)
}

fn phases(store: &Results) -> Table {
    let rows = (store.cases.iter().map(|c| &c.record))
        .map(|r| {
            let p = &r.phases;
            let known = p.assembly_s + p.factorisation_s + p.solve_s + p.contact_forces_s;
            let mut row = vec![r.id.clone()];
            row.extend(
                [
                    p.build_s,
                    p.assembly_s - contact(r),
                    contact(r) + p.contact_forces_s,
                    p.factorisation_s,
                    p.solve_s,
                    (r.wall_s - known).max(0.0),
                    p.output_s,
                ]
                .map(cost),
            );
            row.extend([cost(r.wall_s), cost(r.cpu_s), r.work.factorisations.to_string(), r.work.solves.to_string()]);
            row
        })
        .collect();
    Table {
        name: "phases",
        caption: "Wall time of every case by phase. Building (blocks, ordering, pattern) and output are not part of the run; assembly is that \
                  of all but contact.".into(),
        columns: headings(&[
            ("Case", "", false), ("Building", "s", true), ("Assembly", "s", true), ("Contact", "s", true), ("Factorisation", "s", true),
            ("Solve", "s", true), ("Rest", "s", true), ("Output", "s", true), ("Run, wall", "s", true), ("Run, CPU", "s", true),
            ("Factorisations", "", true), ("Solves", "", true),
        ]),
        rows,
        pick: None,
    }
}
