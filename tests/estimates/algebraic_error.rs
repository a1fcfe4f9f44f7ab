//! The algebraic error next to the bars of a convergence study, with synthetic cases.

use crate::common::synthetic::study;
use durometer::math::statistics::{larger, smaller};
use durometer::report::numbers::percent;
use durometer::study::analysis::Analysis;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::errors::StepCause;
use durometer::study::kinds::convergence::findings::ConvergenceFindings;
use durometer::study::store::record::*;

/// Time steps of static states that do not depend on the path measure the solver.
#[test]
fn differences_between_idle_time_steps_are_algebraic_error() {
    let (study, mut cases) = study();
    cases.iter_mut().for_each(|c| c.record.steps_matter = Some(false));
    let off = |c: &&mut StoredCase| c.record.family == "time_step" && c.record.variant == "length";
    let tension = "cable_tension_N";
    let before = analyse(&study, &cases);
    for c in cases.iter_mut().filter(off) {
        c.record.probes.get_mut(tension).expect("probe").peak += 0.05;
    }
    let a = analyse(&study, &cases);
    let step =
        |a: &Analysis<ConvergenceFindings>| a.find("length", tension).expect("listed").step.clone().expect("family");
    let most = |values: &[f64]| values.iter().fold(0.0, |m, v| larger(m, v.abs()));
    assert_eq!(step(&before).cause, StepCause::Algebraic);
    assert!((step(&a).error - step(&before).error - 0.05).abs() < 1e-9 && !step(&a).negligible, "{:?}", step(&a));
    assert!(
        a.warnings.iter().any(|w| w.contains("values at one time do not depend on the time steps")),
        "{:?}",
        a.warnings
    );
    assert!(a.warnings.iter().any(|w| w.contains("algebraic error 5.00e-2 N")), "{:?}", a.warnings);
    let share = format!("at most {} of the value", percent(step(&a).error / most(&step(&a).values)));
    assert!(a.warnings.iter().any(|w| w.contains(&share)), "{share}: {:?}", a.warnings);
    let bar = |a: &Analysis<ConvergenceFindings>| a.find("length", tension).expect("listed").errors[0].bar;
    let reference = a.find("length", tension).and_then(|q| q.reference.clone()).expect("a reference");
    assert!((bar(&a) - bar(&before) - 0.05 / reference.scale).abs() < 1e-9, "it is part of the bar");
    // The same at the end of the runs, where the peaks agree
    let mut at_end = cases.clone();
    for c in at_end.iter_mut().filter(off) {
        let probe = c.record.probes.get_mut(tension).expect("probe");
        (probe.peak, probe.last) = (probe.peak - 0.05, probe.last + 0.05);
    }
    let a = analyse(&study, &at_end);
    assert!((step(&a).error - 0.05).abs() < 1e-9, "{:?}", step(&a));
    let zero = |c: &mut StoredCase| c.record.probes.values_mut().for_each(|p| (p.peak, p.last) = (1.0, 1.0));
    at_end.iter_mut().for_each(zero);
    let a = analyse(&study, &at_end);
    let said = a
        .warnings
        .iter()
        .find(|w| w.contains("values at one time do not depend on the time steps"))
        .expect("a warning");
    assert!(said.contains("do not differ in any digit") && !said.contains("0.0e0"), "{said}");
}

/// A tension without a share in the loads is rounding next to the other one, and its digits say nothing.
#[test]
fn values_of_rounding_have_no_algebraic_error_to_tell() {
    let (mut study, mut cases) = study();
    let rounding =
        |name: &str| StudyQuantity { name: name.into(), label: "side force".into(), ..StudyQuantity::default() };
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.push(StudyQuantity { unit: "N".into(), ..rounding("side_force_N") });
    for (k, c) in cases.iter_mut().enumerate() {
        c.record.steps_matter = Some(false);
        let side = ProbeRecord { peak: 1e-12 * (1 + k % 7) as f64, ..c.record.probes["cable_tension_N"].clone() };
        c.record.probes.insert("side_force_N".into(), side);
    }
    let a = analyse(&study, &cases);
    let step = a.find("length", "side_force_N").and_then(|q| q.step.clone()).expect("a family of time steps");
    assert!(step.error > 0.1 * step.values.iter().copied().fold(0.0, larger), "{step:?}");
    let said = a
        .warnings
        .iter()
        .find(|w| w.contains("values at one time do not depend on the time steps"))
        .expect("a warning");
    assert!(!said.contains("side force"), "{said}");
}

/// The solver is asked for more where its error is no small share of what is accepted: a tenth of the tolerance, however narrow a bar is, in quantities that decide.
#[test]
fn the_solver_is_judged_by_the_tolerance() {
    let (mut study, mut cases) = study();
    let said = |study: &StudyRecord, cases: &[StoredCase], error: f64| {
        let mut cases = cases.to_vec();
        cases.iter_mut().for_each(|c| c.record.solver.algebraic_error = error);
        analyse(study, &cases).warnings.iter().any(|w| w.starts_with("The algebraic error of"))
    };
    // Every bar of an angle that no mesh changes is zero
    for c in cases.iter_mut() {
        c.record.probes.get_mut("bending_angle_deg").expect("probe").peak = 70.0;
    }
    let a = analyse(&study, &cases);
    assert!(a.find("tension", "bending_angle_deg").expect("listed").errors.iter().all(|e| e.bar < 1e-9));
    assert!(!said(&study, &cases, 0.09 * study.tolerance) && said(&study, &cases, 0.11 * study.tolerance));
    // Where the tension of a wide bar decides alone, that of its coarsest mesh allows more
    let others = study.quantities.values_mut().flatten().filter(|q| q.name == "bending_angle_deg");
    others.for_each(|q| q.deciding = false);
    study.quantities.remove("tension");
    study.variants.retain(|v| v == "length");
    let tension = analyse(&study, &cases).found;
    let bars = &tension.find("length", "cable_tension_N").expect("listed").errors;
    let least = bars.iter().map(|e| e.bar).fold(f64::INFINITY, smaller).max(study.tolerance);
    assert!(!said(&study, &cases, 0.099 * least) && said(&study, &cases, 0.101 * least));
}
