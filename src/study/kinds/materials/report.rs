//! Report of a comparison of laws.

use crate::report::table::Table;
use crate::report::words::{digits, percent, space};
use crate::study::content::Content;
use crate::study::kinds::materials::figures;
use crate::study::kinds::materials::{Analysis, analyse, signed};
use crate::study::results::Results;
use crate::study::tables;
use serde_json::{Map, Value, json};

pub fn content(store: &Results) -> Content {
    let a = analyse(&store.study, &store.cases);
    let variants = store.study.variants.iter();
    Content {
        verdict: a.verdict.clone(),
        supported: a.quantities.iter().any(|q| q.laws.len() > 1),
        facts: facts(&a),
        sentences: a.quantities.iter().map(|q| q.sentence.clone()).collect(),
        warnings: a.warnings.clone(),
        analysis: analysis(&a),
        answer: ("Which law, at what price", prices(&a)),
        tables: vec![comparison(&a)],
        folded: vec![("Every case", tables::cases(store)), ("Time per effect", tables::effects(store))],
        figures: variants
            .flat_map(|v| [figures::over_time(store, &a, v), figures::loops(store, &a, v)])
            .flatten()
            .collect(),
        files: vec![],
        outcomes: Default::default(),
    }
}

/// The widest spread of a peak.
fn facts(a: &Analysis) -> Vec<(String, String)> {
    let fact = |q: &crate::study::kinds::materials::QuantityAnalysis| {
        let d = || q.laws.iter().map(|c| c.peak_difference);
        let (lo, hi) = (d().fold(f64::INFINITY, f64::min), d().fold(f64::NEG_INFINITY, f64::max));
        (format!("{} to {}", signed(lo), signed(hi)), format!("{}, against {}", q.title(), a.reference))
    };
    a.quantities.iter().map(fact).collect()
}

/// The quantities of every variant under their names, as in the other kinds of study.
fn analysis(a: &Analysis) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("reference".into(), json!(a.reference));
    out.insert("prices".into(), json!(a.prices));
    out.insert("incomplete".into(), json!(a.incomplete));
    for q in &a.quantities {
        let entry = out.entry(q.quantity.name.clone()).or_insert_with(|| json!({}));
        entry[&q.variant] = json!(q);
    }
    out
}

fn prices(a: &Analysis) -> Table {
    let rows = (a.prices.iter())
        .map(|p| {
            vec![
                p.member.clone(),
                p.formulation.clone(),
                p.cells.to_string(),
                p.dofs.to_string(),
                format!("{:.*}", digits(p.cpu_s), p.cpu_s),
                format!("{:.2}", p.ratio),
                format!("{:.2}", p.newton_iterations as f64 / p.steps.max(1) as f64),
                format!("{:.1}", 1e3 * p.cpu_s / p.newton_iterations.max(1) as f64),
            ]
        })
        .collect();
    Table {
        name: "prices",
        caption: "Cost of every law under the same protocol, mean over the variants; in bold the reference.".into(),
        columns: vec![
            ("Law", "", false),
            ("Element", "", false),
            ("Cells", "", true),
            ("DOFs", "", true),
            ("CPU", "s", true),
            ("Relative", "", true),
            ("Iterations per step", "", true),
            ("CPU per iteration", "ms", true),
        ],
        rows,
        pick: Some(a.reference.clone()),
    }
}

fn comparison(a: &Analysis) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for c in &q.laws {
            let optional = |v: Option<f64>| v.map_or("–".into(), |v| format!("{:.2}", 100.0 * v));
            rows.push(vec![
                format!("{}, {}", q.quantity.label, q.variant),
                c.member.clone(),
                format!("{:.*}{}", digits(1e-2 * q.peak), c.peak, space(&q.quantity.unit)),
                format!("{:.2}", 100.0 * c.peak_difference),
                optional(c.mesh_drift),
                format!("{:.2}", 100.0 * c.distance),
                format!("{:.2}", 100.0 * c.largest),
                format!("{:.1}", 1e3 * c.lag_s),
                optional(c.loop_share),
            ]);
        }
    }
    Table {
        name: "comparison",
        caption: format!(
            "Every law against {}: peak and its difference, what a finer mesh changes in the difference, distance of the curves (‖f − g‖₂/‖g‖₂ and ‖f − g‖∞ over the peak), lag, hysteresis as the share of the box around a cycle. Tolerance {}.",
            a.reference,
            percent(a.tolerance)
        ),
        columns: vec![
            ("Quantity, control", "", false),
            ("Law", "", false),
            ("Peak", "", true),
            ("Difference", "%", true),
            ("Mesh", "%", true),
            ("L2", "%", true),
            ("L∞", "%", true),
            ("Lag", "ms", true),
            ("Loop", "%", true),
        ],
        rows,
        pick: None,
    }
}
