//! Report of a convergence study.

mod costs;
mod summary;
mod tables;

use super::content::Content;
use super::figures;
use super::store::Store;
use super::table;
use crate::study::convergence::{Analysis, analyse};
use crate::study::words::seconds;

pub fn content(store: &Store) -> Content {
    let analysis = analyse(&store.study, &store.cases);
    Content {
        verdict: analysis.verdict.clone(),
        supported: analysis.recommended.is_some(),
        facts: facts(&analysis),
        sentences: analysis.quantities.iter().map(|q| q.sentence.clone()).collect(),
        warnings: analysis.warnings.clone(),
        analysis: summary::headline(&analysis),
        answer: ("Which mesh, at what price", tables::settings(&analysis)),
        tables: vec![tables::quantities(&analysis)],
        folded: vec![
            ("Every case", table::cases(store)),
            ("What a digit costs", costs::table(store, &analysis)),
            ("Time per effect", table::effects(store)),
            ("Curves, case by case", tables::curves(&analysis)),
        ],
        figures: figures::convergence(store, &analysis),
        files: vec![],
        outcomes: Default::default(),
    }
}

fn facts(analysis: &Analysis) -> Vec<(String, String)> {
    let Some(r) = &analysis.recommended else { return vec![] };
    let mut out = vec![
        (r.label.clone(), "cheapest setting to trust".into()),
        (format!("{:.2} %", 100.0 * r.error_bar), format!("error bar, tolerance {:.0} %", 100.0 * analysis.tolerance)),
        (seconds(r.cost_s), if analysis.cost == "cpu_s" { "of one core per case" } else { "per case" }.into()),
    ];
    if let Some((label, bar, cost)) = &r.next {
        out.push((format!("{:.2} %, {}", 100.0 * bar, seconds(*cost)), format!("next better: {label}")));
    }
    out
}
