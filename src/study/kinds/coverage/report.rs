//! Report of a coverage study: the counts, the truths outside their bars, and the truths themselves.

use crate::report::figure::drawn;
use crate::report::names::title;
use crate::report::numbers::percent;
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kinds::coverage::analysis::{CoverageFindings, LEAST_NEAR, LEAST_WITHIN};
use crate::study::kinds::coverage::figure;
use crate::study::kinds::coverage::mark::{Estimator, Mark, Standing};
use crate::study::kinds::coverage::share::{Effectivity, Share};
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map as Json, json};
use std::collections::BTreeMap;

pub fn content(store: &Results, a: &Analysis<CoverageFindings>) -> Content {
    let mut analysis = Json::new();
    analysis.insert("shares".into(), json!(a.shares));
    analysis.insert("effectivities".into(), json!(a.effectivities));
    analysis.insert("incomplete".into(), json!(a.incomplete));
    Content {
        facts: Estimator::ALL.into_iter().filter_map(|e| Some((percent(a.whole(e)?.share()), words(e)))).collect(),
        sentences: sentences(a),
        analysis,
        decisions: decisions(a),
        tables: vec![effectivities(a), outside(a)],
        folded: vec![("Truths", truths(a)), ("Every error bar", every(a)), ("Every case", tables::cases(store))],
        figures: drawn("coverage", || figure::draw(a)).into_iter().collect(),
        ..Content::new(a, a.passes() && a.incomplete.is_empty(), ("Coverage", coverage(a)))
    }
}

/// Whether the bars hold, and how many of them contain the truth.
fn decisions(a: &CoverageFindings) -> BTreeMap<String, String> {
    let count = |e: Estimator| Some((words(e), a.whole(e).map(|s| format!("{} of {}", s.hold, s.bars))?));
    let hold = ("the bars hold".to_string(), if a.passes() { "yes" } else { "no" }.to_string());
    Estimator::ALL.into_iter().filter_map(count).chain([hold]).collect()
}

fn words(estimator: Estimator) -> String {
    format!("of the bars from {} contain the truth", estimator.words())
}

fn sentences(a: &CoverageFindings) -> Vec<String> {
    let mut out = vec![];
    let find = |name: &str| a.effectivities.iter().find(|e| e.group == name);
    if let (Some(smooth), Some(all)) = (find("smooth"), find("all")) {
        let share = |n: usize, e: &Effectivity| n as f64 / e.bars as f64;
        let met = share(smooth.near, smooth) >= LEAST_NEAR && share(all.within, all) >= LEAST_WITHIN;
        out.push(format!(
            "Effectivity of the estimate from one run: from 0.7 to 1.4 in {} of {} on smooth problems ({}), from 0.5 to 2 in {} of {} on all ({}); \
             the aim of {} and {} is {}.",
            smooth.near,
            smooth.bars,
            percent(share(smooth.near, smooth)),
            all.within,
            all.bars,
            percent(share(all.within, all)),
            percent(LEAST_NEAR),
            percent(LEAST_WITHIN),
            if met { "met" } else { "not met" }
        ));
    }
    out
}

fn coverage(a: &CoverageFindings) -> Table {
    let row = |s: &Share| {
        let [lo, hi] = s.interval.map(|x| format!("{:.1}", 100.0 * x));
        let intervals =
            if s.intervals == 0 { "–".into() } else { format!("{} of {}", s.intervals_hold, s.intervals) };
        vec![
            s.estimator.words().to_string(),
            s.by.to_string(),
            s.group.clone(),
            s.bars.to_string(),
            s.hold.to_string(),
            format!("{:.1}", 100.0 * s.share()),
            format!("{lo} to {hi}"),
            format!("{:.2}", s.median_ratio),
            intervals,
        ]
    };
    let left_out = |e: Estimator| a.count(e, Standing::TruthUncertain);
    let rows = Estimator::ALL.iter().flat_map(|e| a.shares.iter().filter(|s| s.estimator == *e));
    Table {
        name: "coverage",
        caption: format!(
            "Error bars that contain the truth. The interval is Wilson's of 95 %, for independent bars. The last column counts intervals about \
             corrected values instead of bars about the values of meshes. Left out, as the truth is not known to a tenth of the bar: {} from one \
             run, {} from many. {} bars of families that a study refuses are no claims.",
            left_out(Estimator::OneRun),
            left_out(Estimator::ManyRuns),
            a.count(Estimator::ManyRuns, Standing::Refused)
        ),
        columns: headings(&[
            ("Bar", "", false),
            ("By", "", false),
            ("Group", "", false),
            ("Bars", "", true),
            ("Hold", "", true),
            ("Share", "%", true),
            ("Interval", "%", true),
            ("Median bar/error", "", true),
            ("Corrected interval holds", "", true),
        ]),
        rows: rows.map(row).collect(),
        pick: None,
    }
}

fn effectivities(a: &CoverageFindings) -> Table {
    let row = |e: &Effectivity| {
        let share = |n: usize| format!("{:.1}", 100.0 * n as f64 / e.bars as f64);
        vec![e.group.clone(), e.bars.to_string(), format!("{:.3}", e.median), share(e.near), share(e.within)]
    };
    Table {
        name: "effectivity",
        caption: "Effectivity (corrected − value)/(truth − value) of the estimate from one run.".into(),
        columns: headings(&[
            ("Solution", "", false),
            ("Estimates", "", true),
            ("Median", "", true),
            ("0.7 to 1.4", "%", true),
            ("0.5 to 2", "%", true),
        ]),
        rows: a.effectivities.iter().map(row).collect(),
        pick: None,
    }
}

const MARK: [(&str, &str, bool); 9] = [
    ("Bar", "", false),
    ("Case", "", false),
    ("Quantity", "", false),
    ("Formulation", "", false),
    ("Cells", "", true),
    ("Value", "", true),
    ("Truth", "", true),
    ("Bar", "% of truth", true),
    ("Bar/error", "", true),
];

fn cells(m: &Mark) -> Vec<String> {
    vec![
        m.estimator.words().into(),
        m.case.clone(),
        m.quantity.clone(),
        title(&m.formulation),
        m.cells.to_string(),
        format!("{:.5e}", m.value),
        format!("{:.5e}", m.truth),
        format!("{:.3}", 100.0 * m.bar / m.truth.abs()),
        format!("{:.2}", m.ratio()),
    ]
}

fn outside(a: &CoverageFindings) -> Table {
    let rows = a.marks.iter().filter(|m| m.counts() && !m.holds());
    Table {
        name: "outside",
        caption: "Bars that do not contain the truth.".into(),
        columns: headings(&MARK),
        rows: rows.map(cells).collect(),
        pick: None,
    }
}

fn every(a: &CoverageFindings) -> Table {
    let standing = |m: &Mark| match m.standing {
        Standing::Counted if m.holds() => "holds",
        Standing::Counted => "does not hold",
        Standing::TruthUncertain => "truth uncertain",
        Standing::Refused if m.holds() => "refused, would hold",
        Standing::Refused => "refused, would not hold",
    };
    let effectivity = |m: &Mark| match m.estimator {
        Estimator::OneRun => format!("{:.3}", m.effectivity()),
        Estimator::ManyRuns => "–".into(),
    };
    let row = |m: &Mark| [cells(m), vec![effectivity(m), standing(m).to_string()]].concat();
    let more = [("Effectivity", "", true), ("Standing", "", false)];
    Table {
        name: "bars",
        caption: "Every error bar.".into(),
        columns: headings(&[&MARK[..], &more[..]].concat()),
        rows: a.marks.iter().map(row).collect(),
        pick: None,
    }
}

fn truths(a: &CoverageFindings) -> Table {
    let row = |t: &crate::study::kinds::coverage::truth::Truth| {
        let of = |m: &&Mark| m.problem == t.problem && m.material == t.material && m.quantity == t.quantity.name;
        let all: Vec<&Mark> = a.marks.iter().filter(of).collect();
        let out = all.iter().filter(|m| m.standing == Standing::TruthUncertain).count();
        vec![
            t.problem.clone(),
            t.material.clone(),
            t.quantity.name.clone(),
            format!("{:.6e}", t.value),
            format!("{:.4}", 100.0 * t.uncertainty / t.value.abs()),
            t.family.clone(),
            t.cells.to_string(),
            format!("{out} of {}", all.len()),
        ]
    };
    Table {
        name: "truths",
        caption:
            "Truths, their uncertainty, and how many bars are left out because ten times that is more than the bar."
                .into(),
        columns: headings(&[
            ("Problem", "", false),
            ("Material", "", false),
            ("Quantity", "", false),
            ("Truth", "SI", true),
            ("Uncertainty", "%", true),
            ("Family", "", false),
            ("Cells", "", true),
            ("Left out", "", true),
        ]),
        rows: a.truths.iter().map(row).collect(),
        pick: None,
    }
}
