//! Warnings that a reader should know before trusting the numbers.

use crate::report::numbers::capital;
use crate::study::analysis::ByQuantity;
use crate::study::estimate::richardson::LEAST_RATIO;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::findings::{MeshErrors, title};
use crate::study::record::Role;

/// One sentence each.
pub fn warnings(cases: &Cases, quantities: &[ByQuantity<MeshErrors>], incomplete: &[(String, String)]) -> Vec<String> {
    let mut out = vec![];
    for (id, what) in incomplete {
        out.push(format!("Case {id}: {what}."));
    }
    let mut seen = vec![];
    for e in quantities.iter().flat_map(|q| &q.estimates) {
        let low: Vec<String> = e.ratios.iter().filter(|r| **r < LEAST_RATIO).map(|r| format!("{r:.2}")).collect();
        if !low.is_empty() && !seen.contains(&&e.family) {
            seen.push(&e.family);
            let (n, all) = (low.len(), e.ratios.len());
            out.push(format!(
                "Family {}: {n} of {all} size ratios ({}) are below the {LEAST_RATIO} that Roache recommends.",
                e.family,
                low.join(", ")
            ));
        }
    }
    out.extend(unknown_noise(cases, quantities));
    if cases.shared {
        out.push("Cases ran at the same time: costs are CPU seconds of the solving thread, not wall seconds.".into());
    }
    for q in quantities {
        if let Some(t) = q.time_step.as_ref().filter(|t| !t.negligible) {
            out.push(format!(
                "{}: the time-step error {:.2e} is above a tenth of the mesh error {:.2e}.",
                capital(&title(q)),
                t.error,
                t.mesh_error
            ));
        }
        for r in q.reference.iter().flat_map(|r| r.others.iter().filter(|o| !o.overlaps).map(move |o| (r, o))) {
            let (a, b) = (&r.0.family, &r.1.family);
            out.push(format!("{}: the intervals of families {a} and {b} do not overlap.", capital(&title(q))));
        }
        if let Some(c) = q.curves.iter().find(|(_, c)| c.interpolation_error > 0.01 * c.norms[0].peak.abs()) {
            out.push(format!(
                "{}: time grids differ; interpolating them costs {:.1e}.",
                capital(&title(q)),
                c.1.interpolation_error
            ));
        }
    }
    if let Some(why) = cases.no_limit() {
        out.push(format!("{}: the answer has no limit as h → 0.", capital(why)));
    }
    let mut notes: Vec<&String> = cases.stored.iter().flat_map(|c| &c.record.notes).collect();
    notes.sort();
    notes.dedup();
    out.extend(notes.into_iter().map(|r| format!("{}.", capital(r))));
    out
}

/// The formulations of references whose scatter from mesh to mesh is not known.
fn unknown_noise(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Vec<String> {
    let mut formulations: Vec<&str> = vec![];
    for q in quantities {
        let Some(reference) = &q.reference else { continue };
        let Some(e) = q.estimates.iter().find(|e| e.family == reference.family) else { continue };
        let is_known = e.role == Role::Nested || q.noise.iter().any(|n| n.formulation == e.formulation);
        if !is_known && !formulations.contains(&e.formulation.as_str()) {
            formulations.push(&e.formulation);
        }
    }
    let has_seeds = cases.study.families.iter().any(|f| f.role == Role::Seeds);
    let of = if has_seeds { "no seeds were run for it" } else { "no seeds were run" };
    let warn = |formulation: &str| {
        format!(
            "A reference is of {formulation}, whose scatter from mesh to mesh is not in its uncertainty: {of}. Add a family of role \"seeds\"."
        )
    };
    formulations.into_iter().map(warn).collect()
}
