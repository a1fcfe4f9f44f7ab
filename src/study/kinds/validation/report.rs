//! Report of a validation, and `predictions.toml`.

use crate::report::figure::drawn;
use crate::report::names::with_symbol;
use crate::report::numbers::{capital, digits, space};
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::kinds::validation::budget::{COVERAGE, Contribution};
use crate::study::kinds::validation::figures::{budget, score};
use crate::study::kinds::validation::findings::{Prediction, ValidationFindings};
use crate::study::kinds::validation::methods;
use crate::study::kinds::validation::predictions;
use crate::study::kinds::validation::words::{advice, sentence};
use crate::study::store::results::Results;
use crate::study::tables;
use crate::wording::count;
use serde_json::{Map, Value, json};

/// Largest number of predictions that are described in sentences.
const SHOWN: usize = 12;

pub fn content(store: &Results, a: &Analysis<ValidationFindings>) -> Content {
    let figures = budget::draw(a).into_iter().chain(drawn("score", || score::draw(a)));
    let sentences =
        a.predictions.iter().take(SHOWN).flat_map(|p| std::iter::once(sentence(p, a.reference())).chain(advice(p)));
    Content {
        facts: a.predictions.iter().take(4).map(fact).collect(),
        sentences: sentences.collect(),
        analysis: analysis(a),
        // A study without unknowns has no constants and no calibration
        tables: [constants(a), fitted(a), budgets(a)].into_iter().filter(|t| !t.rows.is_empty()).collect(),
        folded: folded(store, a),
        figures: figures.collect(),
        claims: a.predictions.iter().map(claim).collect(),
        decisions: a.predictions.iter().filter_map(decision).collect(),
        search: methods::search(a),
        files: vec![("predictions.toml".into(), predictions::text(a, &store.study.study))],
        ..Content::new(a, !a.predictions.is_empty(), ("What is predicted, and was it so", answer(a)))
    }
}

/// A prediction with its interval.
fn claim(p: &Prediction) -> Claim {
    let what = format!("{}: {}", p.record, p.quantity);
    Claim { what, value: p.value, interval: p.interval, unit: p.unit.clone() }
}

/// Whether the interval contains the measured value, if there is one.
fn decision(p: &Prediction) -> Option<(String, String)> {
    let inside = p.inside.map_or("not judged", |inside| if inside { "yes" } else { "no" });
    p.measured.map(|_| (format!("{}: {} is inside its interval", p.record, p.quantity), inside.into()))
}

fn folded(store: &Results, a: &Analysis<ValidationFindings>) -> Vec<(&'static str, Table)> {
    let tracks = (!a.tracks.is_empty()).then(|| ("How the tracks were evaluated", audit(a)));
    let rest = [("What the budget rests on", sources(a)), ("Every case", tables::cases(store))];
    tracks.into_iter().chain(rest).collect()
}

fn fact(p: &Prediction) -> (String, String) {
    let n = digits(0.1 * (p.interval[1] - p.interval[0]));
    let text = format!("{:.n$} to {:.n$}{}", p.interval[0], p.interval[1], space(&p.unit));
    (text.replace('-', "−"), format!("{}, {}", p.label, p.record_label))
}

fn analysis(a: &Analysis<ValidationFindings>) -> Map<String, Value> {
    let mut out = Map::new();
    if let Value::Object(found) = json!(a.found) {
        out.extend(found);
    }
    out.insert("incomplete".into(), json!(a.incomplete));
    out
}

/// Formats a number with the digits that its uncertainty leaves.
fn rounded(value: f64, uncertainty: f64) -> String {
    format!("{value:.*}", digits(0.1 * uncertainty))
}

fn answer(a: &ValidationFindings) -> Table {
    let row = |p: &Prediction| {
        let wide = p.interval[1] - p.interval[0];
        let number = |v: f64| rounded(v, wide);
        vec![
            p.record_label.clone(),
            with_symbol(&p.label, &p.symbol, &p.symbol),
            p.unit.clone(),
            number(p.value),
            format!("{} to {}", number(p.interval[0]), number(p.interval[1])),
            p.measured.map_or("–".into(), number),
            p.score.map_or("–".into(), |s| format!("{s:+.2}")),
            p.inside.map_or("–", |i| if i { "yes" } else { "no" }).into(),
        ]
    };
    Table {
        name: "predictions",
        caption: format!(
            "Predicted values with the 95 % interval of a further measurement; score: distance of the {} value over the half-width on its side, within ±1 inside.",
            a.reference()
        ),
        columns: headings(&[
            ("Record", "", false),
            ("Quantity", "", false),
            ("Unit", "", false),
            ("Predicted", "", true),
            ("Interval", "", true),
            (&capital(a.reference()), "", true),
            ("Score", "", true),
            ("Inside", "", false),
        ]),
        rows: a.predictions.iter().map(row).collect(),
        pick: None,
    }
}

fn constants(a: &ValidationFindings) -> Table {
    let rows = a.constants.iter().map(|c| {
        let number = |v: f64| rounded(v, c.interval[1] - c.interval[0]);
        vec![
            format!("{} {}", c.label, c.symbol),
            c.key.clone(),
            c.unit.clone(),
            number(c.value),
            format!("{} to {}", number(c.interval[0]), number(c.interval[1])),
            number(c.numerical),
            format!("{} to {}", c.range[0], c.range[1]),
        ]
    });
    Table {
        name: "constants",
        caption: "Constants that the calibration records give, with 95 % intervals, of which the half-width by numerical errors of their simulations alone is given too, and the ranges in which they were looked for.".into(),
        columns: headings(&[
            ("Constant", "", false),
            ("Key", "", false),
            ("Unit", "", false),
            ("Value", "", true),
            ("Interval", "", true),
            ("Numerical", "", true),
            ("Range", "", true),
        ]),
        rows: rows.collect(),
        pick: None,
    }
}

fn fitted(a: &ValidationFindings) -> Table {
    let rows = a.fitted.iter().map(|d| {
        let n = digits(1e-2 * d.measured);
        vec![
            d.record.clone(),
            d.quantity.clone(),
            d.unit.clone(),
            format!("{:.n$}", d.measured),
            format!("{:.n$}", d.fitted),
            format!("{:+.2}", d.residual),
        ]
    });
    Table {
        name: "calibration",
        caption: format!(
            "Calibration records: measured and fitted values, and residuals in standard deviations of their independent errors. χ² = {:.2} with {} of freedom.",
            a.chi2,
            count(a.freedom, "degree")
        ),
        columns: headings(&[
            ("Record", "", false),
            ("Quantity", "", false),
            ("Unit", "", false),
            ("Measured", "", true),
            ("Fitted", "", true),
            ("Residual", "", true),
        ]),
        rows: rows.collect(),
        pick: None,
    }
}

/// Rows for the budget of a value, relative to the interval.
fn lines(of: [&str; 3], budget: &[Contribution], interval: [f64; 2]) -> Vec<Vec<String>> {
    let [record, quantity, unit] = of.map(String::from);
    let total: f64 = budget.iter().map(|c| c.deviation * c.deviation).sum();
    let wide = interval[1] - interval[0];
    let line = |c: &Contribution| {
        vec![
            record.clone(),
            quantity.clone(),
            c.group.clone(),
            unit.clone(),
            rounded(COVERAGE * c.deviation, wide),
            format!("{:.0}", 100.0 * c.deviation * c.deviation / total),
            rounded(c.without, wide),
        ]
    };
    budget.iter().map(line).collect()
}

fn budgets(a: &ValidationFindings) -> Table {
    let predictions = a.predictions.iter().map(|p| lines([&p.record_label, &p.label, &p.unit], &p.budget, p.interval));
    let constants = a.constants.iter().map(|c| lines(["–", &c.label, &c.unit], &c.budget, c.interval));
    let rows = predictions.chain(constants).flatten();
    Table {
        name: "budget",
        caption: "Error budget of every prediction and constant: half-width that each group alone would give, its share of the variance, and the half-width that would be left without it.".into(),
        columns: headings(&[
            ("Record", "", false),
            ("Quantity", "", false),
            ("Group", "", false),
            ("Unit", "", false),
            ("Half-width", "", true),
            ("Share", "%", true),
            ("Without it", "", true),
        ]),
        rows: rows.collect(),
        pick: None,
    }
}

fn sources(a: &ValidationFindings) -> Table {
    Table {
        name: "sources",
        caption: "Terms of the budget (and their group) with the standard deviation and where it is from.".into(),
        columns: headings(&[("Term", "", false), ("Deviation", "", true), ("Source", "", false)]),
        rows: a.sources.iter().map(|(a, b, c)| vec![a.clone(), b.clone(), c.clone()]).collect(),
        pick: None,
    }
}

fn audit(a: &ValidationFindings) -> Table {
    let rows = a.tracks.iter().flat_map(|t| {
        let doubts = t.doubts.iter().map(|d| format!("doubt: {d}"));
        let lines = t.log.iter().cloned().chain(doubts);
        lines.map(|line| vec![t.record.clone(), t.file.clone(), line])
    });
    Table {
        name: "tracks",
        caption: "Audit of the tracks that values were measured in: every decision of their evaluation.".into(),
        columns: headings(&[("Record", "", false), ("File", "", false), ("Decision", "", false)]),
        rows: rows.collect(),
        pick: None,
    }
}
