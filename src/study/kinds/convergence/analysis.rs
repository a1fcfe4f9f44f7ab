//! The analysis of the stored cases of a convergence study.

use crate::report::numbers::percent;
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::curve::{Curve, peak};
use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::family::{Estimate, Level};
use crate::study::estimate::tolerance::Tolerance;
use crate::study::estimate::{curve, family, reference};
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::errors::Noise;
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use crate::study::kinds::convergence::next_mesh::{NextMesh, next_mesh};
use crate::study::kinds::convergence::{errors, independent, verdict, warnings};
use crate::study::store::record::{Role, StoredCase, StudyQuantity, StudyRecord};

/// Analyses the stored cases; cases that are missing or did not converge are named, not guessed.
pub fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis<ConvergenceFindings> {
    let cases = Cases::new(study, stored);
    let mut quantities = ByQuantity::each(study, stored, |variant, quantity| {
        let any = study.quantities[variant].iter().any(|q| q.deciding || q.headline);
        let deciding = !any || quantity.deciding || quantity.headline;
        Some(mesh_errors(&cases, variant, quantity, deciding))
    });
    let incomplete = study.incomplete(stored);
    let settings = verdict::settings(&cases, &quantities);
    for q in &mut quantities {
        q.sentence = verdict::sentence(&settings, q, study.tolerance);
    }
    let warnings = warnings::warnings(&cases, &quantities, &incomplete);
    let (recommended, mut verdict) = verdict::conclude(&cases, &quantities, &settings, &incomplete);
    let is_open = recommended.is_none() && cases.no_limit().is_none();
    let next = is_open.then(|| next_mesh(&cases, &quantities)).flatten();
    if let Some(next) = &next {
        verdict += &format!(" {}", next.sentence());
    }
    if recommended.is_none() {
        verdict += &verdict::constants_alone(&quantities);
    }
    verdict += &verdict::undetermined_words(&quantities);
    verdict += &verdict::without_share_words(&quantities);
    let extension = next.and_then(NextMesh::extension);
    let found = ConvergenceFindings { quantities, settings, recommended, extension };
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

fn mesh_errors(cases: &Cases, variant: &str, quantity: &StudyQuantity, deciding: bool) -> MeshErrors {
    let study = cases.study;
    let tolerance = quantity.tolerance(study.tolerance);
    let quantity = quantity.name.as_str();
    let noise = errors::noise(cases, variant, quantity);
    let (estimates, curves) = families(cases, (variant, quantity), &noise, tolerance);
    let mut reference = reference::choose(&estimates, tolerance);
    let scale = reference.as_ref().map_or(f64::NAN, |r| r.scale);
    let one_run = independent::one_run(cases, variant, quantity, scale);
    if let Some(r) = &mut reference {
        let leading = estimates.iter().find(|e| e.family == r.family);
        independent::check(r, leading.and_then(|e| e.cases.first()), &one_run);
    }
    let of_constants = |r| independent::input_uncertainty(cases, (variant, quantity), &estimates, r);
    let constants = cases.constants(variant);
    let undetermined = constants.map_or(vec![], |c| c.undetermined.clone());
    let inputs = reference.as_ref().filter(|_| undetermined.is_empty()).and_then(of_constants);
    let without_share = match (&inputs, &reference) {
        (None, Some(_)) if undetermined.is_empty() => constants.map_or(vec![], |c| c.bounded.clone()),
        _ => vec![],
    };
    let step = errors::step_error(cases, variant, quantity, reference.as_ref());
    let errors = errors::errors(cases, (variant, quantity), reference.as_ref(), step.as_ref());
    let allowed = reference.as_ref().map_or(0.0, |r| tolerance.allowed(r.value));
    let unresolved = errors::unresolved(cases, variant, quantity, allowed);
    let missed_share = errors::missed_share(cases, variant, quantity);
    let is_missed = reference.as_ref().is_some_and(|r| missed_share * r.value.abs() > allowed);
    let is_within = reference.as_ref().is_some_and(|r| r.is_within(tolerance));
    let supported = is_within && unresolved.is_none() && !is_missed;
    let mut reasons: Vec<String> = unresolved.iter().map(errors::Unresolved::words).collect();
    reasons.extend(is_missed.then(|| {
        format!(
            "a prescribed signal has its extremum between two points of the time grid, which may miss {} of a peak; let a point lie on the extremum, or shorten dt",
            percent(missed_share)
        )
    }));
    match &reference {
        None => reasons.push("no family of meshes has two converged cases".to_string()),
        Some(r) if !is_within => {
            for e in &estimates {
                reasons.extend(e.reasons.iter().map(|reason| format!("{}: {reason}", e.family)));
            }
            if r.disagreement > tolerance.allowed(r.value) {
                reasons.push("the limits of the families differ by more than the tolerance".into());
            }
            reasons.extend(r.independent.as_ref().filter(|own| !own.overlaps).map(|own| {
                let (id, value, uncertainty) = (&own.of, own.value, own.uncertainty);
                format!(
                    "the estimate from the run of {id} alone, {value:.4e} ± {uncertainty:.1e}, does not overlap them"
                )
            }));
        }
        Some(r) => reasons.extend(
            r.others
                .iter()
                .filter(|o| !o.overlaps)
                .map(|o| format!("the interval of family {} does not overlap the one of {}", o.of, r.family)),
        ),
    }
    MeshErrors {
        deciding,
        estimates,
        curves,
        noise,
        step,
        unresolved,
        missed_share,
        is_missed,
        one_run,
        inputs,
        undetermined,
        without_share,
        reference,
        errors,
        supported,
        reasons,
    }
}

/// The estimates of all families of meshes, and their curves by the name of the family.
fn families(
    cases: &Cases,
    (variant, quantity): (&str, &str),
    noise: &[Noise],
    tolerance: Tolerance,
) -> (Vec<Estimate>, Vec<(String, CurveStudy)>) {
    let (mut estimates, mut curves) = (vec![], vec![]);
    for f in &cases.study.families {
        if matches!(f.role, Role::Seeds | Role::Adaptive | Role::TimeStep) {
            continue;
        }
        let members = cases.of(f, variant);
        let level = |c: &&StoredCase| {
            let level = Level::of(&c.record, quantity, peak(c, quantity)?);
            let edge = level.edge.filter(|_| f.role != Role::Nested);
            Some(Level { edge, ..level })
        };
        let formulation = f.formulation_of(&members);
        let half_width = noise.iter().find(|n| n.formulation == formulation).map(|n| n.half_width);
        let levels = members.iter().filter_map(level).collect();
        let mut estimate = family::estimate((&f.name, f.role, formulation), levels, half_width, tolerance);
        let mut series: Vec<_> = (members.iter())
            .filter_map(|c| Some((c.record.id.clone(), c.record.mesh.h_m, Curve::of(&c.series, quantity)?)))
            .collect();
        series.sort_by(|a, b| a.1.total_cmp(&b.1));
        if series.len() >= 2 {
            let formal = family::formal_order(formulation);
            let compared = curve::compare(&series, formal);
            if let (Some(estimate), Some(compared)) = (&mut estimate, &compared) {
                estimate.check_curves(compared, tolerance);
            }
            curves.extend(compared.map(|c| (f.name.clone(), c)));
        }
        estimates.extend(estimate);
    }
    (estimates, curves)
}
