//! Report of a sweep.

use crate::report::figure::drawn;
use crate::report::numbers::{digits, minus_signs, percent, percent_cell, readable, space, unsigned_zero};
use crate::report::table::{Table, headings};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::axis::AxisRecord;
use crate::study::content::Content;
use crate::study::figures::grid::raised;
use crate::study::kinds::sweep::analysis::{Along, Dependence, SweepFindings, Trend, axis_words, members};
use crate::study::kinds::sweep::figures;
use crate::study::store::record::CaseRecord;
use crate::study::store::results::Results;
use crate::study::tables;
use crate::wording;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

pub fn content(store: &Results, a: &Analysis<SweepFindings>) -> Content {
    let variants = || store.study.variants.iter();
    let against = a.quantities.iter().filter_map(|q| drawn("dependence", || figures::against(store, a, q)));
    let maps = variants().filter_map(|v| drawn("map", || figures::map(store, a, v)));
    let over_time = variants().filter_map(|v| drawn("curves", || figures::over_time(store, a, v)));
    let supported = a.quantities.iter().any(|q| !q.along.is_empty());
    Content {
        facts: a.quantities.iter().filter(|q| !q.points.is_empty()).map(fact).collect(),
        sentences: a.quantities.iter().map(|q| q.sentence.clone()).collect(),
        analysis: analysis(a),
        decisions: a.quantities.iter().flat_map(|q| decisions(q, a.tolerance)).collect(),
        tables: vec![points(store, a)],
        folded: vec![("Every case", tables::cases(store)), ("Time per effect", tables::effects(store))],
        figures: against.chain(maps).chain(over_time).collect(),
        ..Content::new(a, supported, ("What depends on what", dependence(a)))
    }
}

/// The range of the values of a quantity.
fn fact(q: &ByQuantity<Dependence>) -> (String, String) {
    let [low, high] = q.range();
    let n = digits(1e-1 * low.abs().max(high.abs()));
    let [low, high] = [low, high].map(|v| minus_signs(unsigned_zero(&readable(v, n))));
    (format!("{low} to {high}{}", space(&q.quantity.unit)), q.peak_title())
}

/// The trend of a quantity along each axis, if it exceeds the tolerance.
fn decisions(q: &ByQuantity<Dependence>, tolerance: f64) -> impl Iterator<Item = (String, String)> + '_ {
    let of = move |x: &Along| {
        let trend = if x.change > tolerance { x.trend.name() } else { "within the tolerance" };
        (format!("{}, {} along {}", q.quantity.name, q.variant, x.axis), trend.into())
    };
    q.along.iter().map(of)
}

/// The quantities of every variant under their names, as in the other kinds of study.
fn analysis(a: &Analysis<SweepFindings>) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("axes".into(), json!(a.axes));
    out.insert("incomplete".into(), json!(a.incomplete));
    out.extend(ByQuantity::as_json(&a.quantities));
    out
}

fn dependence(a: &Analysis<SweepFindings>) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for x in &q.along {
            let trend = match x.trend {
                Trend::Rising if q.is_negative() => "rises, magnitude falls",
                Trend::Falling if q.is_negative() => "falls, magnitude rises",
                Trend::Rising => "rises",
                Trend::Falling => "falls",
                Trend::Constant => "constant",
                Trend::Turning => "turns around",
                Trend::Mixed => "rises or falls",
                Trend::Unordered => "differs",
            };
            let e = |k: usize| x.elasticity.map_or("–".into(), |e| format!("{:.3}", e[k]));
            rows.push(vec![
                format!("{}, {}", q.peak_label(), q.variant),
                axis_words(&a.axes, &x.axis, a.list),
                trend.into(),
                percent_cell(x.change),
                e(2),
                e(0),
                e(1),
            ]);
        }
    }
    Table {
        name: "dependence",
        caption: format!(
            "{}{} along each axis, the others held: trend as its value rises, largest change over the largest value or the larger scale of an absolute tolerance, and elasticity d ln |y|/d ln p of the lines that are not constant, from end to end of the middle one and, over all, smallest and largest between neighbours. Changes within {} count as none.",
            a.judged.heading(),
            if a.quantities.iter().any(|q| q.has_origin()) {
                ", those that do not start at zero counted from the first ones,"
            } else {
                ""
            },
            percent(a.tolerance)
        ),
        columns: headings(&[
            ("Quantity, control", "", false),
            ("Along", "", false),
            ("Trend", "", false),
            ("Change", "%", true),
            ("Elasticity", "", true),
            ("Smallest", "", true),
            ("Largest", "", true),
        ]),
        rows,
        pick: None,
    }
}

/// Writes a value with four digits, whatever its size.
fn plain(value: f64) -> String {
    let small = value != 0.0 && value.abs() < 1e-3;
    if small { format!("{value:.3e}") } else { format!("{value:.*}", digits(1e-2 * value)) }
}

/// A value of an axis: a number without its unit, rounded to the digits that survive a conversion of units.
fn value_of(axis: &AxisRecord, k: usize) -> String {
    let number = axis.numbers.get(k).and_then(|n| format!("{n:.11e}").parse::<f64>().ok());
    number.map_or_else(|| axis.values[k].clone(), |n| n.to_string())
}

/// Forms of a heading; a column gets the first that is unique: the symbol, the label with the symbol, and the name.
fn forms(symbol: &str, label: &str, name: &str) -> [String; 3] {
    [symbol.into(), format!("{label} {symbol}"), name.into()]
}

/// Forms of the heading of a judged quantity, and its unit.
fn judged(q: &ByQuantity<Dependence>) -> ([String; 3], String) {
    (forms(&q.peak_symbol(), &q.peak_label(), &q.quantity.name), q.quantity.unit.clone())
}

/// A table with a column for every key and for every quantity of some variant.
fn points(store: &Results, a: &SweepFindings) -> Table {
    let found: Vec<HashMap<&str, f64>> =
        a.quantities.iter().map(|q| q.points.iter().map(|p| (p.case.as_str(), p.value)).collect()).collect();
    let shown = wording::distinct(a.quantities.iter().map(judged));
    let mut rows = vec![];
    let of_variants = store.cases.iter().flat_map(|c| store.study.variants.iter().map(move |v| (c, v)));
    let all = of_variants.flat_map(|(c, v)| members(&store.study, c, v).into_iter().map(move |member| (c, v, member)));
    for (c, variant, member) in all {
        let r: &CaseRecord = &c.record;
        let Some(at) = a.points.get(member) else { continue };
        let mut row: Vec<String> = at.iter().zip(&a.axes).map(|(k, axis)| value_of(axis, *k)).collect();
        row.push(variant.clone());
        row.extend(shown.iter().map(|column| {
            let own = a.quantities.iter().zip(&found).find(|(q, _)| q.variant == *variant && judged(q) == *column);
            own.and_then(|(_, found)| found.get(r.id.as_str())).map_or("–".into(), |value| plain(*value))
        }));
        row.extend([r.status.clone(), r.steps.to_string(), r.all_iterations().to_string(), r.cuts.to_string()]);
        row.push(format!("{:.*}", digits(r.cpu_s), r.cpu_s));
        rows.push(row);
    }
    let of_axes: Vec<[String; 3]> = a.axes.iter().map(|axis| forms(&axis.symbol, &axis.label, &axis.name)).collect();
    let heading = |own: &[String; 3]| {
        let all = || of_axes.iter().chain(shown.iter().map(|(forms, _)| forms));
        let form = (0..2).find(|k| all().filter(|other| other[*k] == own[*k]).count() == 1);
        own[form.unwrap_or(2)].clone()
    };
    let of_axis = |(axis, own): (&AxisRecord, &[String; 3])| {
        let is_number = !axis.numbers.is_empty();
        (heading(own), if is_number { raised(&axis.unit) } else { String::new() }, is_number)
    };
    let mut columns: Vec<(String, String, bool)> = a.axes.iter().zip(&of_axes).map(of_axis).collect();
    columns.extend(headings(&[("Control", "", false)]));
    columns.extend(shown.iter().map(|(own, unit)| (heading(own), unit.clone(), true)));
    columns.extend(headings(&[
        ("Status", "", false),
        ("Steps", "", true),
        ("Newton", "", true),
        ("Cuts", "", true),
        ("CPU", "s", true),
    ]));
    let keys: Vec<&String> = of_axes.iter().map(|[_, words, _]| words).collect();
    let quantities: Vec<&String> = shown.iter().map(|([_, words, _], _)| words).collect();
    Table {
        name: "points",
        caption: format!(
            "Every point of the sweep over {}: {} of {}, and the cost.",
            wording::all(&keys),
            a.judged.heading().to_lowercase(),
            wording::all(&quantities)
        ),
        columns,
        rows,
        pick: None,
    }
}
