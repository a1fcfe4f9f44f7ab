//! The analysis of the stored cases of a convergence study.

use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::curve::{Curve, peak, starts_elsewhere};
use crate::study::estimate::family::Level;
use crate::study::estimate::{curve, family, reference};
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use crate::study::kinds::convergence::{errors, verdict, warnings};
use crate::study::record::{Role, StoredCase, StudyRecord};

/// Analyses what is there; cases that are missing or did not converge are named, not guessed.
pub fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis<ConvergenceFindings> {
    let cases = Cases::new(study, stored);
    let mut quantities = ByQuantity::each(study, |variant, quantity| {
        let any = study.quantities[variant].iter().any(|q| q.deciding || q.headline);
        let deciding = !any || quantity.deciding || quantity.headline;
        Some(mesh_errors(&cases, variant, &quantity.name, deciding))
    });
    let incomplete = study.incomplete(stored);
    let settings = verdict::settings(&cases, &quantities);
    for q in &mut quantities {
        q.sentence = verdict::sentence(&settings, q, study.tolerance);
    }
    let warnings = warnings::warnings(&cases, &quantities, &incomplete);
    let (recommended, verdict) = verdict::conclude(&cases, &quantities, &settings, &incomplete);
    let cost = if cases.shared { "cpu_s" } else { "wall_s" };
    let found = ConvergenceFindings { quantities, settings, recommended, cost };
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

fn mesh_errors(cases: &Cases, variant: &str, quantity: &str, deciding: bool) -> MeshErrors {
    let study = cases.study;
    let noise = errors::noise(cases, variant, quantity);
    let (mut estimates, mut curves) = (vec![], vec![]);
    for f in &study.families {
        if matches!(f.role, Role::Seeds | Role::TimeStep) {
            continue;
        }
        let members = cases.of(f, variant);
        let edge = |c: &StoredCase| c.record.mesh.edge_m.filter(|_| f.role != Role::Nested);
        let level = |c: &&StoredCase| {
            let (id, h) = (c.record.id.clone(), c.record.mesh.h_m);
            Some(Level { id, h, edge: edge(c), f: peak(c, quantity)? })
        };
        let scatter = noise.iter().find(|n| n.formulation == f.formulation).map(|n| n.scatter);
        let levels = members.iter().filter_map(level).collect();
        estimates.extend(family::estimate((&f.name, f.role, &f.formulation), levels, scatter, study.tolerance));
        let mut series: Vec<_> = (members.iter())
            .filter_map(|c| Some((c.record.id.clone(), c.record.mesh.h_m, Curve::of(&c.series, quantity)?)))
            .collect();
        series.sort_by(|a, b| a.1.total_cmp(&b.1));
        if series.len() >= 2 {
            let formal = family::formal_order(&f.formulation);
            curves.extend(curve::compare(&series, formal).map(|c| (f.name.clone(), c)));
        }
    }
    let of_variant = cases.stored.iter().filter(|c| c.record.variant == variant);
    let change = of_variant.filter_map(|c| Curve::of(&c.series, quantity)).any(|c| starts_elsewhere(&c));
    let reference = reference::choose(&estimates);
    let errors = errors::errors(cases, variant, quantity, reference.as_ref());
    let time_step = errors::time_step(cases, variant, quantity, &estimates);
    let supported = reference.as_ref().is_some_and(|r| r.uncertainty <= study.tolerance * r.value.abs());
    let mut reasons = vec![];
    match &reference {
        None => reasons.push("no family of meshes has two converged cases".to_string()),
        Some(r) if !supported => {
            for e in &estimates {
                reasons.extend(e.reasons.iter().map(|reason| format!("{}: {reason}", e.family)));
            }
            if r.disagreement > study.tolerance * r.value.abs() {
                reasons.push("the families disagree by more than the tolerance".into());
            }
        }
        Some(r) => reasons.extend(
            r.others
                .iter()
                .filter(|o| !o.overlaps)
                .map(|o| format!("the interval of family {} does not overlap the one of {}", o.family, r.family)),
        ),
    }
    MeshErrors { deciding, change, estimates, curves, noise, time_step, reference, errors, supported, reasons }
}
