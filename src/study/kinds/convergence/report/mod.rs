//! Report of a convergence study.

pub mod costs;
pub mod quantities;
pub mod summary;

use crate::report::numbers::{percent, seconds};
use crate::study::analysis::Analysis;
use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::kinds::convergence::figures;
use crate::study::kinds::convergence::findings::{Bar, ConvergenceFindings, MeshSetting};
use crate::study::store::results::Results;
use crate::study::tables;

pub fn content(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Content {
    let answer = ("Which mesh, at what cost", quantities::settings(analysis));
    Content {
        facts: facts(analysis),
        sentences: analysis.quantities.iter().map(|q| q.sentence.clone()).collect(),
        analysis: summary::headline(analysis),
        tables: std::iter::once(quantities::quantities(analysis)).chain(quantities::one_run(analysis)).collect(),
        folded: vec![
            ("Every case", tables::cases(store)),
            ("What a digit costs", costs::table(store, analysis)),
            ("Time per effect", tables::effects(store)),
            ("Curves, case by case", quantities::curves(analysis)),
        ],
        figures: figures::draw(store, analysis),
        claims: claims(analysis),
        extension: analysis.extension.clone(),
        ..Content::new(analysis, analysis.recommended.is_some(), answer)
    }
}

/// The peak of every quantity in every setting, with its error bar.
fn claims(analysis: &Analysis<ConvergenceFindings>) -> Vec<Claim> {
    let of = |s: &MeshSetting, bar: &Bar| {
        let q = analysis.find(&bar.variant, &bar.quantity)?;
        let case = s.cases.iter().find(|case| q.errors.iter().any(|e| e.id == **case))?;
        Claim::of_case(case, &bar.quantity, bar.value, bar.bar * q.reference.as_ref()?.scale, &q.quantity.unit)
    };
    analysis.settings.iter().flat_map(|s| s.bars.iter().filter_map(move |bar| of(s, bar))).collect()
}

fn facts(analysis: &Analysis<ConvergenceFindings>) -> Vec<(String, String)> {
    let Some(r) = &analysis.recommended else { return vec![] };
    let mut out = vec![
        (r.label.clone(), "cheapest setting to trust".into()),
        (percent(r.error_bar), format!("error bar, tolerance {}", percent(analysis.tolerance))),
        (seconds(r.cost_s), "of CPU time per case".into()),
    ];
    if let Some((label, bar, cost)) = &r.next {
        out.push((format!("{}, {}", percent(*bar), seconds(*cost)), format!("next better: {label}")));
    }
    out
}
