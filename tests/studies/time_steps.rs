//! Time steps of stages, of variants and of families: whose error is known, and what is said where it is not.

use crate::common::synthetic;
use durometer::math::statistics::larger;
use durometer::study::analysis::Analysis;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::findings::ConvergenceFindings;
use durometer::study::kinds::cost;
use durometer::study::store::record::{FamilyRecord, Role, StoredCase, StudyRecord};

/// Warnings that the error of the time steps is in no error bar.
fn untold<T>(a: &Analysis<T>) -> Vec<&String> {
    a.warnings.iter().filter(|w| w.contains("depend on the time steps")).collect()
}

fn with_stages(cases: &[StoredCase], stages: impl Fn(&StoredCase) -> Vec<f64>) -> Vec<StoredCase> {
    let mut all = cases.to_vec();
    for c in &mut all {
        c.record.stage_dt_s = stages(c);
        c.record.dt_s = c.record.stage_dt_s.iter().copied().fold(0.0, larger);
    }
    all
}

/// A hold before the movement has a step of its own, longer or shorter than those of the movement.
#[test]
fn a_hold_changes_nothing() {
    let (study, cases) = synthetic::study();
    let found = analyse(&study, &cases);
    let step = |a: &Analysis<ConvergenceFindings>| a.find("length", "cable_tension_N").expect("listed").step.clone();
    assert_eq!(step(&found).expect("a family").dt_s, [0.025, 0.05, 0.1]);
    for hold in [1.0, 0.01] {
        let held = with_stages(&cases, |c| vec![hold, c.record.dt_s]);
        let a = analyse(&study, &held);
        assert_eq!(a, found, "a hold with steps of {hold} s");
    }
}

/// A variant may have other steps than another one: its meshes are compared at its own.
#[test]
fn a_variant_has_its_own_steps() {
    let (study, cases) = synthetic::study();
    let twice = |c: &StoredCase| vec![if c.record.variant == "tension" { 2.0 } else { 1.0 } * c.record.dt_s];
    let a = analyse(&study, &with_stages(&cases, twice));
    let found = analyse(&study, &cases);
    assert_eq!(a.verdict, found.verdict);
    assert_eq!(a.settings, found.settings);
}

/// The study with a family of time steps for each of these variants, and none for the others.
fn with_families_for(variants: &[&str]) -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, mut cases) = synthetic::study();
    study.families.retain(|f| f.role != Role::TimeStep);
    for variant in variants {
        let name = format!("steps_{variant}");
        for c in cases.iter_mut().filter(|c| c.record.family == "time_step" && c.record.variant == *variant) {
            c.record.family.clone_from(&name);
        }
        let ids = cases.iter().filter(|c| c.record.family == name).map(|c| c.record.id.clone()).collect();
        let formulation = "tet4".into();
        study.families.push(FamilyRecord { name, role: Role::TimeStep, formulation, cases: ids, members: vec![] });
    }
    cases.retain(|c| c.record.family != "time_step");
    (study, cases)
}

#[test]
fn every_variant_has_the_error_of_its_own_family() {
    let (study, cases) = synthetic::study();
    let one_family = analyse(&study, &cases);
    let (study, cases) = with_families_for(&["tension", "length"]);
    let a = analyse(&study, &cases);
    for (q, own) in one_family.quantities.iter().zip(&a.quantities) {
        let [expected, found] = [q, own].map(|q| q.step.as_ref().expect("a family").error);
        assert_eq!((expected, &q.errors), (found, &own.errors), "{}", q.title());
    }
    assert!(untold(&a).is_empty(), "{:?}", a.warnings);
}

#[test]
fn a_variant_without_the_error_of_its_steps_is_named() {
    let (study, cases) = with_families_for(&["length"]);
    let a = analyse(&study, &cases);
    let said = untold(&a);
    let own = cases.iter().filter(|c| c.record.variant == "tension").count();
    assert_eq!(said.len(), 1, "{:?}", a.warnings);
    for words in [format!("{own} of {} cases", cases.len()), "of tension control: add a family".into()] {
        assert!(said[0].contains(&words), "{words}: {said:?}");
    }
    // One step alone tells nothing
    let (study, mut cases) = with_families_for(&["length", "tension"]);
    cases.retain(|c| c.record.family != "steps_tension" || c.record.member == "dt0.1");
    cases.retain(|c| c.record.variant != "tension" || c.record.dt_s != 0.05 || c.record.mesh.cells != 4_500);
    let a = analyse(&study, &cases);
    assert!(untold(&a)[0].contains("family steps_tension has no two time steps"), "{:?}", a.warnings);
}

/// Without meshes to compare there is no error bar; the error of the steps is known all the same, and no warning says otherwise.
#[test]
fn time_steps_alone_tell_their_error() {
    let (mut study, mut cases) = synthetic::study();
    let mesh = |c: &StoredCase| c.record.mesh.cells == 4_500 && c.record.formulation == "tet4";
    cases.retain(mesh);
    for c in cases.iter_mut().filter(|c| c.record.family == "time_step") {
        c.record.probes.values_mut().for_each(|p| p.peak *= 1.5);
    }
    study.families.retain(|f| matches!(f.role, Role::TimeStep | Role::Sizes));
    let a = analyse(&study, &cases);
    assert!(a.quantities.iter().all(|q| q.estimates.is_empty() && q.reference.is_none()), "{:?}", a.quantities);
    assert!(untold(&a).is_empty(), "{:?}", a.warnings);
    let told: Vec<_> = a.warnings.iter().filter(|w| w.contains("the time-step error")).collect();
    assert!(
        !told.is_empty()
            && told.iter().all(|w| w.ends_with("is in no error bar, since no family of meshes gives a reference.")),
        "{told:?}"
    );
}

/// Where the error of the steps alone is above the tolerance, no finer mesh is proposed.
#[test]
fn no_mesh_helps_against_the_error_of_the_steps() {
    let (study, mut cases) = synthetic::study();
    let coarse = |c: &&mut StoredCase| c.record.family == "time_step" && c.record.variant == "length";
    for c in cases.iter_mut().filter(coarse) {
        c.record.probes.get_mut("cable_tension_N").expect("probe").peak *= 1.5;
    }
    let a = analyse(&study, &cases);
    assert!(a.recommended.is_none() && a.extension.is_none(), "{}", a.verdict);
    assert!(a.verdict.contains("No finer mesh would help: the time-step error"), "{}", a.verdict);
}

/// A case without a result has no states, and no kind of study counts it among those that depend on the steps.
#[test]
fn cases_without_a_result_have_no_states() {
    let (study, mut cases) = with_families_for(&[]);
    let stopped = |c: &&mut StoredCase| c.record.variant == "tension";
    cases.iter_mut().filter(stopped).for_each(|c| c.record.status = "StepTooSmall".into());
    let own = cases.iter().filter(|c| c.record.converged()).count();
    let a = analyse(&study, &cases);
    assert!(untold(&a)[0].contains(&format!("{own} of {own} cases")), "{:?}", a.warnings);
}

/// In a cost study a variant whose cases all have one step says nothing of its error, whatever the steps of another variant.
#[test]
fn costs_of_one_step_are_warned_of_in_every_variant() {
    let (study, cases) = with_families_for(&[]);
    let twice = |c: &StoredCase| vec![if c.record.variant == "tension" { 2.0 } else { 1.0 } * c.record.dt_s];
    let a = cost::analysis::analyse(&study, &with_stages(&cases, twice));
    assert_eq!(untold(&a).len(), 1, "{:?}", a.warnings);
    let (study, cases) = with_families_for(&["length"]);
    let a = cost::analysis::analyse(&study, &cases);
    assert!(untold(&a)[0].contains("tension control"), "{:?}", a.warnings);
}
