//! Sources of the error bars in words, for the methods section of a paper: only the terms that the bars of a study contain.

use crate::study::estimate::family::Estimate;
use crate::study::estimate::method::Method;
use crate::study::estimate::reference::Reference;
use crate::study::kinds::convergence::errors::StepCause;
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use crate::wording::all;

/// The sources of the bars in words, with citations as `[@key]`.
pub fn errors(found: &ConvergenceFindings) -> String {
    let with_bars = || found.quantities.iter().filter_map(|q| Some((&q.found, q.reference.as_ref()?)));
    let limits: Vec<&Estimate> = with_bars().flat_map(|(q, r)| of_limit(q, r)).collect();
    if limits.is_empty() {
        return "No error bar is computed: no family of meshes has two converged cases.".into();
    }
    let mut methods: Vec<&str> = vec![];
    for method in limits.iter().map(|e| e.method.cited()) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    let mut uncertainty = vec![];
    let is_pair = |e: &Estimate| matches!(e.method, Method::TwoMeshes { .. });
    if limits.iter().any(|e| e.method.is_extrapolation() && !is_pair(e)) {
        uncertainty.push("grid convergence index with the safety factors of Roache [@roache1994]");
    }
    if limits.iter().any(|e| is_pair(e)) {
        uncertainty.push("the change of two meshes by a first order, with a safety factor");
    }
    if with_bars().any(|(_, r)| r.envelope.len() > 1) {
        uncertainty.push("the distance between the limits of the families");
    }
    let in_brackets = if uncertainty.is_empty() { String::new() } else { format!(" ({})", all(&uncertainty)) };
    let mut terms = vec!["the error".to_string(), format!("the uncertainty of the limit{in_brackets}")];
    for (cause, words) in
        [(StepCause::TimeStep, "the error of the time steps"), (StepCause::Algebraic, "the algebraic error")]
    {
        let has = |q: &MeshErrors| q.step.as_ref().is_some_and(|step| step.cause == cause);
        terms.extend(with_bars().any(|(q, _)| has(q)).then(|| words.to_string()));
    }
    let misses = with_bars().any(|(q, _)| q.missed_share > 0.0);
    terms.extend(misses.then(|| "the share of a peak that the time grid may miss".to_string()));
    let mut constants = String::new();
    if with_bars().any(|(q, _)| !q.undetermined.is_empty()) {
        constants += " Constants without a closed interval are in no bar.";
    } else if with_bars().any(|(q, _)| q.inputs.is_some()) {
        constants += " Shares of uncertain constants are added as root of the sum of squares [@asme2009].";
    }
    if with_bars().any(|(q, _)| !q.without_share.is_empty()) {
        constants += " Bars of quantities without a derivative by uncertain constants have no share of these.";
    }
    format!(
        "The error of a value is its distance from the limit f* for h → 0, by {}. An error bar is {}, added as absolute values.{constants}",
        all(&methods),
        all(&terms)
    )
}

/// The estimates that the limit of a quantity comes from: those of its envelope, or of the leading family if no family is defensible.
fn of_limit<'a>(q: &'a MeshErrors, r: &'a Reference) -> impl Iterator<Item = &'a Estimate> {
    q.estimates.iter().filter(|e| e.family == r.family || r.envelope.contains(&e.family))
}
