//! Meshes that would help a convergence study, and their costs, with synthetic cases.

use super::convergence_report::results;
use crate::common::synthetic::study;
use durometer::study::analysis::Analysis;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::figures;
use durometer::study::kinds::convergence::findings::ConvergenceFindings;
use durometer::study::store::record::*;

/// Every mesh of a grid has the source "grid".
#[test]
fn finer_meshes_of_one_source_are_settings_of_their_own() {
    let (study, mut cases) = study();
    let before = analyse(&study, &cases);
    cases.iter_mut().for_each(|c| c.record.mesh.source = "grid".into());
    let labels = |a: &Analysis<ConvergenceFindings>| a.settings.iter().map(|s| s.label.clone()).collect::<Vec<_>>();
    assert_eq!(labels(&analyse(&study, &cases)), labels(&before));
    assert_eq!(analyse(&study, &cases).verdict, before.verdict);
}

/// Grids of 1 × 4 × 4 and 4 × 4 × 1 boxes have the same counts and the same qualities.
#[test]
fn meshes_of_equal_counts_are_settings_of_their_own() {
    let (mut study, mut cases) = study();
    let (mut other, mut digest) = (vec![], 0);
    for c in &mut cases {
        digest += usize::from(c.record.variant == "length");
        c.record.provenance.identity.mesh_sha256 = digest.to_string();
    }
    for c in cases.iter().filter(|c| c.record.family == "element" && c.record.mesh.cells == 2_200) {
        let mut c = c.clone();
        c.record.id = c.record.id.replace("element", "thin");
        c.record.family = "thin".into();
        c.record.provenance.identity.mesh_sha256 = "thin".into();
        c.record.probes.get_mut("bending_angle_deg").expect("probe").peak *= 1.2;
        other.push(c);
    }
    let before = analyse(&study, &cases).settings.len();
    let (name, cases_of) = ("thin".into(), other.iter().map(|c| c.record.id.clone()).collect());
    let (role, formulation, members) = (Role::Element, "tet10".into(), vec![]);
    study.families.push(FamilyRecord { name, role, formulation, cases: cases_of, members });
    cases.extend(other);
    let a = analyse(&study, &cases);
    assert_eq!(a.settings.len(), before + 1);
    let own: Vec<_> = a.settings.iter().filter(|s| s.label == "tet10, 2200 cells").collect();
    assert!(own.len() == 2 && own.iter().all(|s| s.cases.len() == 2), "{own:?}");
}

/// The mesh that would help is proposed once: where it was added and has no result, the refusal names its case.
#[test]
fn a_mesh_that_failed_is_not_proposed_again() {
    let (mut study, mut cases) = study();
    study.tolerance = 1e-3;
    study.families.retain(|f| f.name == "sizes");
    cases.retain(|c| c.record.family == "sizes");
    for r in cases.iter_mut().map(|c| &mut c.record) {
        r.provenance.scene = format!("[mesh]\ncells = {}\n", r.mesh.cells);
    }
    let proposed = analyse(&study, &cases).found.extension.expect("a finer mesh");
    let mut added = cases[0].clone();
    added.record.id = format!("sizes-length-{}", proposed.member);
    (added.record.status, added.record.mesh.cells) = ("TimeBudget".into(), proposed.cells);
    added.record.provenance.scene = format!("[mesh]\ncells = {}\n", proposed.set["mesh.cells"]);
    study.families[0].cases.push(added.record.id.clone());
    let a = analyse(&study, &cases);
    assert!(a.extension.is_none() && a.verdict.contains(": has no result"), "{}", a.verdict);
    cases.push(added);
    let a = analyse(&study, &cases);
    assert_eq!(a.extension, None);
    assert!(a.verdict.contains(&format!("is case sizes-length-{}: TimeBudget", proposed.member)), "{}", a.verdict);
}

/// The law of growth of the mesh that would help goes through the mean CPU times over the variants: where one of two costs nine times as much, its cost is
/// five times that of the other. The times by the clock, which others on the machine make longer, do not count.
#[test]
fn the_cost_of_a_finer_mesh_is_the_mean_over_the_variants() {
    let (mut study, mut cases) = study();
    study.tolerance = 1e-3;
    study.families.retain(|f| f.name == "sizes");
    cases.retain(|c| c.record.family == "sizes");
    for r in cases.iter_mut().map(|c| &mut c.record) {
        r.provenance.scene = format!("[mesh]\ncells = {}\n", r.mesh.cells);
    }
    let cost = |cases: &[StoredCase]| {
        let proposed = analyse(&study, cases).found.extension.expect("a finer mesh");
        assert!(
            proposed.sentence.contains("per case on average over the variants by the law"),
            "{}",
            proposed.sentence
        );
        proposed.cost_s.expect("four meshes").value
    };
    let equal = cost(&cases);
    for r in cases.iter_mut().map(|c| &mut c.record).filter(|r| r.variant == "tension") {
        (r.wall_s, r.cpu_s) = (100.0 * r.wall_s, 9.0 * r.cpu_s);
    }
    // Rounding of logarithms
    assert!((cost(&cases) / equal - 5.0).abs() < 1e-9);
}

/// A worker that waits while others use the machine takes longer by the clock, and its mesh is chosen as before.
#[test]
fn the_choice_of_a_mesh_does_not_depend_on_what_else_the_machine_does() {
    let (study, cases) = study();
    let quiet = analyse(&study, &cases);
    let busy = |a: &Analysis<ConvergenceFindings>| a.warnings.iter().any(|w| w.contains("The machine was busy"));
    let chosen = quiet.recommended.clone().expect("a verdict");
    assert!(!busy(&quiet), "{:?}", quiet.warnings);
    let mut paused = cases.clone();
    for c in paused.iter_mut().filter(|c| chosen.cases.contains(&c.record.id)) {
        c.record.wall_s += 600.0;
    }
    let a = analyse(&study, &paused);
    assert_eq!((&a.verdict, &a.recommended), (&quiet.verdict, &quiet.recommended));
    assert_eq!(a.settings, quiet.settings);
    assert!(busy(&a), "{:?}", a.warnings);
    // Neither do the figures: their marks move with the CPU time alone
    let drawn = |cases: &[StoredCase]| {
        let results = results(&study, cases);
        let of_errors = figures::errors::against_cost(&results, &analyse(&study, cases)).expect("a figure");
        [figures::cost::draw(&results).expect("a figure").svg, of_errors.svg]
    };
    let before = drawn(&cases);
    assert!(before == drawn(&paused), "a figure has the time by the clock");
    let mut slow = cases.clone();
    slow.iter_mut().filter(|c| chosen.cases.contains(&c.record.id)).for_each(|c| c.record.cpu_s += 600.0);
    assert!(before.iter().zip(drawn(&slow)).all(|(fast, slow)| *fast != slow));
    // Cases that ran at the same time are compared by the same times
    paused.iter_mut().for_each(|c| c.record.shared = true);
    assert_eq!(analyse(&study, &paused).recommended, quiet.recommended);
}
