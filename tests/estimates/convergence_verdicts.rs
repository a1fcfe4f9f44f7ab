//! Verdicts of convergence studies with synthetic cases: what they say, and what is refused.

use crate::common::synthetic::{self, SIZES, size, study};
use durometer::study::analysis::{Analysis, ByQuantity};
use durometer::study::curve::Curve;
use durometer::study::estimate::curve::compare;
use durometer::study::estimate::family::{Estimate, Level, estimate};
use durometer::study::estimate::richardson::Convergence;
use durometer::study::estimate::tolerance::Tolerance;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use durometer::study::kinds::convergence::report::quantities::{quantities, settings};
use durometer::study::kinds::convergence::verdict;
use durometer::study::locking;
use durometer::study::report;
use durometer::study::run::uncertain_constants::UncertainConstantRecord;
use durometer::study::store::record::*;
use std::collections::BTreeMap;

fn refused(a: &Analysis<ConvergenceFindings>, why: &str) {
    assert!(a.recommended.is_none() && a.verdict.starts_with("No verdict"), "{}", a.verdict);
    let said = |q: &ByQuantity<MeshErrors>| q.sentence.contains(why);
    assert!(a.verdict.contains(why) || a.quantities.iter().any(said), "{why}: {}", a.verdict);
}

/// Bars that are from values without a reference are within no tolerance, however small they are: neither the table nor the mesh that would help says so.
#[test]
fn a_setting_meets_no_tolerance_where_the_verdict_is_refused() {
    let (mut study, mut cases) = study();
    let meets = |a: &Analysis<ConvergenceFindings>| {
        let table = settings(a);
        let is_within = |row: &Vec<String>| row.last().is_some_and(|cell| cell == "yes");
        (table.rows.iter().any(is_within), table.caption.contains("The verdict is refused"))
    };
    assert_eq!(meets(&analyse(&study, &cases)), (true, false));
    study.tolerance = 0.4;
    study.families.retain(|f| f.name == "sizes");
    cases.retain(|c| c.record.family == "sizes");
    for r in cases.iter_mut().map(|c| &mut c.record) {
        r.provenance.scene = format!("[mesh]\ncells = {}\n", r.mesh.cells);
        r.mesh.wall_cells = Some(1.0);
    }
    let a = analyse(&study, &cases);
    refused(&a, "cells across the thinnest wall");
    assert!(a.settings.iter().any(|s| s.worst <= study.tolerance), "{:?}", a.settings);
    assert_eq!(meets(&a), (false, true));
    let sentence = a.extension.as_ref().expect("a finer mesh").sentence.as_str();
    assert!(sentence.contains("is no claim for the reasons above"), "{sentence}");
    // Where no setting is within the tolerance, the table needs no other word
    study.tolerance = 1e-5;
    assert_eq!(meets(&analyse(&study, &cases)), (false, false));
}

/// Differences that grow from coarse to fine are monotone or not, and the reason says which.
#[test]
fn a_family_that_diverges_is_told_how() {
    let of = |f: [f64; 3]| {
        let level = |(h, f): (f64, f64)| Level { id: h.to_string(), h, f, ..Level::default() };
        let levels = [1.09e-3, 1.45e-3, 1.98e-3].into_iter().zip(f).map(level).collect();
        let e = estimate(("sizes", Role::Sizes, "tet10"), levels, None, 0.05).expect("three meshes");
        assert!(e.class == Convergence::Diverging && e.refused);
        e.reasons.join("; ")
    };
    let monotone = of([26.686, 26.612, 26.570]);
    assert!(
        monotone.contains(
            "the three finest diverge monotonically: from coarse to fine they change by 4.20e-2, then by 7.40e-2"
        ),
        "{monotone}"
    );
    assert!(monotone.contains("a ratio of 1.762 where these sizes must have one below 0.916"), "{monotone}");
    let oscillating = of([1.0, 2.0, 1.5]);
    assert!(!oscillating.contains("ratio"), "{oscillating}");
    assert!(
        oscillating.contains(
            "oscillate with differences that do not shrink: from coarse to fine they change by 5.00e-1, then by -1.00e0"
        ),
        "{oscillating}"
    );
}

/// A refusal names every quantity and the reasons of the first one, once for each family; those of the others are in their sentences.
#[test]
fn a_refusal_is_two_sentences() {
    let (mut study, cases) = study();
    study.tolerance = 1e-5;
    let a = analyse(&study, &cases);
    let refused: Vec<_> = a.quantities.iter().filter(|q| q.deciding && !q.supported).collect();
    assert!(refused.len() > 1, "{}", a.verdict);
    assert!(refused.iter().all(|q| a.verdict.contains(&q.peak_title())), "{}", a.verdict);
    let verdict =
        a.extension.as_ref().map_or(a.verdict.as_str(), |more| a.verdict.split(&more.sentence).next().expect("text"));
    assert!(verdict.trim_end().matches(". ").count() == 1, "{verdict}");
    for q in refused {
        let named = |e: &Estimate| q.sentence.matches(&format!("amily {}: ", e.family)).count();
        assert!(q.estimates.iter().all(|e| named(e) == usize::from(!e.reasons.is_empty())), "{}", q.sentence);
    }
}

#[test]
fn the_synthetic_study_gets_the_verdict_that_was_put_into_it() {
    let (study, cases) = study();
    let a = analyse(&study, &cases);
    let r = a.recommended.as_ref().unwrap_or_else(|| panic!("{}", a.verdict));
    // tet10 at 1100 cells is off by 0.013·(4500/1100)^(2.6/3) = 4.4 %, at 2200 by 2.4 %; U(f*) adds the 1.3 % of the finest
    assert_eq!(r.label, "tet10, 2200 cells", "{}", a.verdict);
    assert_eq!(r.case, "element-tension-2200");
    assert!(a.verdict.contains("the bending angle moves by") && a.verdict.contains("tension limits"));
    let tension = a.find("length", "cable_tension_N").expect("listed");
    let reference = tension.reference.as_ref().expect("families");
    assert!((reference.value - 6.4).abs() <= reference.uncertainty, "{reference:?}");
    assert!(tension.step.as_ref().expect("family").negligible);
    assert!(a.warnings.iter().any(|w| w.contains("family sizes") || w.contains("Family sizes")));
    assert_eq!(a.headline().expect("one").variant, "tension");
}

/// A tension that moves most with the mesh and has the smaller bar, by a tolerance of its own, limits nothing; and a bar that is not smaller by a tenth is no better one.
#[test]
fn the_verdict_names_the_quantity_that_limits_by_its_bar() {
    let (mut study, cases) = study();
    let of_length = study.quantities.get_mut("length").expect("variant");
    of_length.iter_mut().filter(|q| q.name == "cable_tension_N").for_each(|q| q.absolute_tolerance = Some(10.0));
    let a = analyse(&study, &cases);
    let r = a.recommended.as_ref().unwrap_or_else(|| panic!("{}", a.verdict));
    assert!(r.limited_by.contains("bending angle") && !a.verdict.contains("tension limits"), "{}", a.verdict);
    let rest = || a.settings.iter().filter(|s| s.cost_s > r.cost_s && s.worst < r.error_bar);
    let better = rest().find(|s| s.worst < 0.9 * r.error_bar).map(|s| s.label.clone());
    assert_eq!(r.next.as_ref().map(|next| next.0.clone()), better);
}

/// The derivatives by constants are those of the family that the limit comes from. The finest mesh of all is of another family, whose stiffness, and
/// with it the derivatives, are far off.
#[test]
fn constants_count_by_the_derivatives_of_the_leading_family() {
    const COLUMN: &str = "cable_tension_N";
    let (study, mut cases) = study();
    let of_constants = |cases: &[StoredCase]| {
        let found = analyse(&study, cases).found;
        found.find("length", COLUMN).and_then(|q| q.inputs.clone())
    };
    assert_eq!(of_constants(&cases), None);
    let found = analyse(&study, &cases).found;
    let tension = found.find("length", COLUMN).expect("listed");
    let reference = tension.reference.as_ref().expect("families");
    let leading = tension.estimate(&reference.family).expect("it leads").cases.clone();
    let finest = cases.iter().min_by(|a, b| a.record.mesh.h_m.total_cmp(&b.record.mesh.h_m)).expect("cases");
    assert!(!leading.contains(&finest.record.id) && reference.family == "element", "{reference:?}");
    for r in cases.iter_mut().map(|c| &mut c.record) {
        // 7 % of the reference on the finest mesh of the leading family, 8 % on its next, four times as much on meshes of others
        let share = leading.iter().position(|id| *id == r.id).map_or(0.28, |k| 0.07 + 0.01 * k as f64);
        let derivatives = BTreeMap::from([(COLUMN.to_string(), share * reference.value / 1e4)]);
        let correlation = BTreeMap::new();
        r.inputs = vec![UncertainConstantRecord {
            constant: "laws.rubber.mu".into(),
            half_width: 1e4,
            derivatives,
            correlation,
        }];
    }
    let inputs = of_constants(&cases).expect("every case has derivatives");
    assert!(inputs.case == leading[0] && (inputs.share - 0.07).abs() < 1e-12, "{inputs:?}");
    let verdict = analyse(&study, &cases).verdict;
    assert!(verdict.contains(", 7 % constants, together"), "{verdict}");
    // A second constant that changes as much, and of which the file says that it is correlated
    let with_second = |r: f64| {
        let mut cases = cases.clone();
        for record in cases.iter_mut().map(|c| &mut c.record) {
            let mut second = record.inputs[0].clone();
            second.constant = "laws.rubber.C01".into();
            second.correlation = BTreeMap::from([(record.inputs[0].constant.clone(), r)]);
            record.inputs[0].correlation = BTreeMap::from([(second.constant.clone(), r)]);
            record.inputs.push(second);
        }
        (of_constants(&cases).expect("derivatives by both").share, analyse(&study, &cases).verdict)
    };
    for (r, factor) in [(-1.0, 0.0), (-0.5, 1.0), (1.0, 2.0)] {
        let (share, verdict) = with_second(r);
        assert!((share - 0.07 * factor).abs() < 1e-9, "{r}: {share}");
        assert!(verdict.contains("the constants are correlated as the file says"), "{verdict}");
    }
    // Without derivatives on the finest mesh, those of the next one of the family
    let without = |id: &String, cases: &mut [StoredCase]| {
        cases.iter_mut().filter(|c| c.record.id == *id).for_each(|c| c.record.inputs.clear());
    };
    without(&leading[0], &mut cases);
    let next = of_constants(&cases).expect("coarser meshes have derivatives");
    assert!(next.case == leading[1] && (next.share - 0.08).abs() < 1e-12, "{next:?}");
    // Without any in the families that the limit comes from, no share is stated
    let supports = |id: &String| {
        let of = |e: &&Estimate| e.cases.contains(id);
        tension
            .estimates
            .iter()
            .filter(of)
            .any(|e| e.family == reference.family || reference.envelope.contains(&e.family))
    };
    let ids: Vec<String> = cases.iter().map(|c| c.record.id.clone()).filter(supports).collect();
    ids.iter().for_each(|id| without(id, &mut cases));
    assert_eq!(of_constants(&cases), None);
}

/// Two meshes tend to a limit by assumption only, however large the tolerance is.
#[test]
fn two_meshes_alone_support_no_verdict() {
    let (mut study, mut cases) = study();
    study.tolerance = 0.5;
    cases.retain(|c| c.record.family == "sizes");
    let a = analyse(&study, &cases);
    assert!(a.recommended.is_some(), "{}", a.verdict);
    cases.retain(|c| c.record.mesh.cells > 10_000);
    let a = analyse(&study, &cases);
    refused(&a, "its two members show no order, and not that there is a limit");
    assert!(quantities(&a).rows.iter().all(|row| row[4] == "not shown by two meshes"), "{:?}", quantities(&a).rows);
}

#[test]
fn locked_cases_are_named_and_the_verdict_says_when_it_recommends_one() {
    let (study, mut cases) = study();
    assert!(locking::sentence(&cases).is_none());
    let raise = |c: &mut StoredCase| {
        c.record.locking = Some(LockingRecord { pressure_scatter: 0.81, volumetric_share: 0.2, alarm: true });
    };
    cases.iter_mut().filter(|c| c.record.formulation == "tet4").for_each(raise);
    let a = analyse(&study, &cases);
    let sentence = locking::sentence(&cases).expect("flagged cases");
    assert!(sentence.contains("tet4") && !sentence.contains("tet10") && sentence.contains("mixed"), "{sentence}");
    assert!(!a.verdict.contains("alarm"), "{}", a.verdict);
    let of_tet4 = a.quantities.iter().flat_map(|q| &q.estimates).filter(|e| e.formulation == "tet4");
    assert!(of_tet4.clone().count() > 0 && of_tet4.clone().all(|e| !e.defensible), "a locked family is no reference");
    // A mesh that locks may still meet the tolerance against a finer one that does not
    cases.iter_mut().filter(|c| c.record.formulation == "tet10" && c.record.mesh.cells < 4_000).for_each(raise);
    let a = analyse(&study, &cases);
    assert!(a.verdict.contains("raises the locking alarm (pressure scatter 0.81)"), "{}", a.verdict);
    cases.iter_mut().for_each(raise);
    refused(&analyse(&study, &cases), "its finest mesh raises the locking alarm");
}

#[test]
fn a_recommendation_names_unstable_states_and_references_of_unknown_scatter() {
    let (study, mut cases) = study();
    let a = analyse(&study, &cases);
    assert!(!a.verdict.contains("unstable"), "{}", a.verdict);
    assert!(
        a.warnings.iter().any(|w| w.contains("A reference is of tet10") && w.contains("seeds")),
        "{:?}",
        a.warnings
    );
    cases.iter_mut().filter(|c| c.record.formulation == "tet10").for_each(|c| c.record.solver.unstable_steps = 2);
    let a = analyse(&study, &cases);
    assert!(a.verdict.starts_with("On an unstable branch of equilibria, "), "{}", a.verdict);
    assert!(a.verdict.contains("States of") && !a.verdict.contains("can be trusted"), "{}", a.verdict);
}

/// Seeds in one variant say nothing of the scatter in another one, and the best of families that are all not defensible is no reference.
#[test]
fn the_scatter_is_unknown_where_no_seeds_were_run() {
    let (mut study, mut cases) = study();
    cases.retain(|c| c.is_of_family("sizes") || c.is_in("seeds", "length"));
    let warned = |study: &StudyRecord| -> Vec<String> {
        analyse(study, &cases).warnings.into_iter().filter(|w| w.starts_with("A reference is of")).collect()
    };
    let found = warned(&study);
    assert!(found.len() == 1 && found[0].contains("no seeds were run for it in tension control."), "{found:?}");
    study.tolerance = 1e-6;
    assert_eq!(warned(&study), Vec::<String>::new());
    let a = analyse(&study, &cases);
    let crossed: Vec<String> = quantities(&a).rows.into_iter().filter_map(|mut row| row.pop()).collect();
    assert_eq!(crossed, ["reference without support"; 3]);
}

/// One mesh and no more expensive setting are not spoken of as several.
#[test]
fn one_is_not_several() {
    let (study, mut cases) = study();
    let of = |r: &CaseRecord| r.family == "element" || (r.family == "sizes" && r.mesh.cells == 4_500);
    cases.retain(|c| of(&c.record));
    let a = analyse(&study, &cases);
    assert!(a.verdict.contains("The only mesh of family sizes does not: it has an error bar of"), "{}", a.verdict);
    let q = a.find("length", "cable_tension_N").expect("listed");
    let last = a.settings.last().expect("settings");
    let words = verdict::sentence(std::slice::from_ref(last), q, study.tolerance);
    assert!(words.contains("; none is more expensive") && !words.contains("ones"), "{words}");
}

/// The verdict says which quantities decide, and what bars the others have.
#[test]
fn quantities_that_do_not_decide_are_named_with_their_bars() {
    let (mut study, cases) = study();
    let a = analyse(&study, &cases);
    assert!(!a.verdict.contains("of those that decide") && !a.verdict.contains("Not decided by"), "{}", a.verdict);
    // The tension alone limits the element; without it a coarser mesh will do, whose tension is off
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().filter(|q| q.name == "cable_tension_N").for_each(|q| q.deciding = false);
    let a = analyse(&study, &cases);
    assert!(a.verdict.contains("in the worst quantity of those that decide"), "{}", a.verdict);
    let rest = a.verdict.split("Not decided by: ").nth(1).unwrap_or_else(|| panic!("{}", a.verdict));
    assert!(rest.starts_with("maximum cable tension, length control ("), "{}", a.verdict);
    let r = a.recommended.as_ref().expect("a verdict");
    let setting = a.settings.iter().find(|s| s.label == r.label).expect("a setting");
    let bar = setting.bars.iter().find(|b| b.quantity == "cable_tension_N" && b.variant == "length").expect("a bar");
    assert_eq!(rest.contains("above the tolerance"), bar.bar > study.tolerance, "{}", a.verdict);
    assert!(bar.bar > study.tolerance, "the example is to show an excess: {}", bar.bar);
}

/// A relative tolerance of a value near zero means nothing.
#[test]
fn a_quantity_near_zero_asks_for_an_absolute_tolerance() {
    let f = SIZES.map(|n| 0.002 - 0.02 * (size(n) / size(4500)).powf(1.8));
    let of = |tolerance: Tolerance| {
        let level = |(n, f): (&usize, &f64)| Level { id: n.to_string(), h: size(*n), f: *f, ..Level::default() };
        let levels = SIZES.iter().zip(&f).map(level).collect();
        estimate(("family", Role::Sizes, "tet4"), levels, None, tolerance).expect("four meshes")
    };
    let relative = of(0.05.into());
    assert!(!relative.defensible && relative.reasons.iter().any(|r| r.contains("absolute_tolerance")), "{relative:?}");
    assert!(of(Tolerance { relative: 0.05, absolute: 0.01 }).defensible);
    assert!(!of(Tolerance { relative: 0.05, absolute: 1e-4 }).defensible);

    let (mut study, mut cases) = study();
    for c in cases.iter_mut().filter(|c| c.record.variant == "length") {
        c.record.probes.get_mut("bending_angle_deg").expect("probe").peak -= 74.0;
        c.series.columns.remove("bending_angle_deg");
    }
    refused(&analyse(&study, &cases), "absolute_tolerance");
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().filter(|q| q.name == "bending_angle_deg").for_each(|q| q.absolute_tolerance = Some(1.0));
    let a = analyse(&study, &cases);
    assert!(a.recommended.is_some(), "{}", a.verdict);
}

/// A step that covers most of a motion: no difference of such steps bounds its error. Forces may jump, and so may what is within the tolerance.
#[test]
fn a_motion_that_the_steps_do_not_resolve_has_no_verdict() {
    let (study, mut cases) = study();
    let mut set = |quantity: &str, largest_step: f64| {
        for c in &mut cases {
            let motion = MotionRecord { largest_step, range: 1.0 };
            c.record.probes.get_mut(quantity).expect("probe").motion = Some(motion);
        }
        analyse(&study, &cases)
    };
    assert!(set("cable_tension_N", 0.9).recommended.is_some() && set("bending_angle_deg", 0.9).recommended.is_some());
    let mut large = cases.clone();
    for c in &mut large {
        let probe = c.record.probes.get_mut("bending_angle_deg").expect("probe");
        probe.motion = Some(MotionRecord { largest_step: 0.3 * probe.peak, range: probe.peak });
    }
    assert!(analyse(&study, &large).recommended.is_some());
    for c in &mut large {
        let probe = c.record.probes.get_mut("bending_angle_deg").expect("probe");
        probe.motion = Some(MotionRecord { largest_step: 0.4 * probe.peak, range: probe.peak });
    }
    let a = analyse(&study, &large);
    refused(&a, "the time steps do not resolve the motion: it covers 40 % of its range within one step");
    assert!(a.verdict.contains("No finer mesh would help before the time steps are shorter"), "{}", a.verdict);
}

/// A signal with its extremum between two points of the time grid hides a share of every peak, which no mesh shows: three times the share of the signal is part of the bars,
/// and above the tolerance there is no verdict.
#[test]
fn peaks_between_the_points_of_the_time_grid_are_in_the_bars() {
    let (study, mut cases) = study();
    let before = analyse(&study, &cases);
    let mut with = |share: f64| {
        cases.iter_mut().for_each(|c| c.record.unseen_share = Some(share));
        analyse(&study, &cases)
    };
    let told = |a: &Analysis<ConvergenceFindings>| a.warnings.iter().filter(|w| w.contains("of a peak")).count();
    let a = with(0.004);
    for (q, was) in a.quantities.iter().zip(&before.quantities) {
        let scale = q.reference.as_ref().expect("a reference").scale;
        for (error, was) in q.errors.iter().zip(&was.errors) {
            let more = 0.012 * error.value.abs() / scale;
            assert!((error.bar - was.bar - more).abs() < 1e-12 && error.error == was.error, "{error:?} {was:?}");
        }
    }
    assert_eq!([told(&before), told(&a)], [0, 2], "once in each variant: {:?}", a.warnings);
    let a = with(0.02);
    refused(
        &a,
        "a prescribed signal has its extremum between two points of the time grid, which may miss 6 % of a peak",
    );
    assert!(a.verdict.contains("No finer mesh would help before the time steps are shorter"), "{}", a.verdict);
    // Where masses move the motion of angles is looked at, and only what has none may miss as much
    let mut moving = cases.clone();
    for c in &mut moving {
        (c.record.unseen_share, c.record.unseen_force_share) = (None, Some(0.02));
    }
    let a = analyse(&study, &moving);
    assert!(
        a.quantities.iter().all(|q| (q.missed_share > 0.0) == (q.quantity.name == "cable_tension_N")),
        "{:?}",
        a.warnings
    );
    // An absolute tolerance above the largest value accepts a share of it
    let mut accepting = study.clone();
    accepting.quantities.values_mut().flatten().for_each(|q| q.absolute_tolerance = Some(100.0));
    let a = analyse(&accepting, &cases);
    assert!(a.recommended.is_some(), "{}", a.verdict);
}

/// A largest value within the body has a verdict only where four meshes show that it has a limit.
#[test]
fn a_largest_stretch_needs_orders_that_agree() {
    let (mut study, mut cases) = study();
    for list in study.quantities.values_mut() {
        list.iter_mut()
            .for_each(|q| q.name = if q.name == "cable_tension_N" { "stretch_max".into() } else { q.name.clone() });
    }
    for c in &mut cases {
        let tension = c.record.probes["cable_tension_N"].clone();
        c.record.probes.insert("stretch_max".into(), tension);
    }
    let why = "may lie at a clamped or re-entrant edge";
    let four = analyse(&study, &cases);
    let estimates = &four.find("length", "stretch_max").expect("listed").estimates;
    let shows_limit = |e: &Estimate| e.asymptotic == Some(true);
    let is_doubted = |e: &Estimate| e.reasons.iter().any(|r| r.contains(why)) && e.refused && !e.defensible;
    assert!(estimates.iter().any(shows_limit) && !estimates.iter().all(shows_limit), "both kinds of families");
    assert!(estimates.iter().all(|e| is_doubted(e) != shows_limit(e)), "{estimates:?}");
    let least = |c: &StoredCase| c.record.family != "sizes" || c.record.mesh.cells >= 9_000;
    let three: Vec<StoredCase> = cases.iter().filter(|c| least(c)).cloned().collect();
    let a = analyse(&study, &three);
    assert!(a.find("length", "stretch_max").is_some_and(|q| !q.supported && q.sentence.contains(why)), "{}", a.verdict);
    // Where no mesh is fine enough, no finer one would help
    let alone: Vec<StoredCase> = three.into_iter().filter(|c| c.record.family == "sizes").collect();
    let a = analyse(&study, &alone);
    assert!(a.verdict.contains(why) && !a.verdict.contains("would help") && a.extension.is_none(), "{}", a.verdict);
}

/// A family that is refused is no reference where another one is not, however small its U(f*) is. Where all are refused, the captions say so.
#[test]
fn a_refused_family_is_the_last_to_be_a_reference() {
    let (study, mut cases) = study();
    let study = StudyRecord { tolerance: 1e-4, ..study };
    let leads = |cases: &[StoredCase]| {
        let a = analyse(&study, cases);
        let q = a.find("length", "cable_tension_N").expect("listed");
        (q.reference.as_ref().expect("a reference").family.clone(), q.has_refused_reference())
    };
    let (first, is_refused) = leads(&cases);
    assert!(!is_refused);
    let cut = |cases: &mut [StoredCase], family: Option<&str>| {
        let own = cases.iter_mut().filter(|c| family.is_none_or(|name| c.record.family == name));
        own.for_each(|c| c.record.cut_regions = vec!["clamp".into()]);
    };
    cut(&mut cases, Some(&first));
    let (second, is_refused) = leads(&cases);
    assert!(second != first && !is_refused, "{second} in place of {first}");
    cut(&mut cases, None);
    assert!(leads(&cases).1);
    let dir = tempfile::tempdir().expect("a folder");
    synthetic::store(dir.path(), &(study, cases));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let page = std::fs::read_to_string(dir.path().join("index.html")).expect("a page");
    assert!(page.contains("distances from the limit of one that is refused"));
}

#[test]
fn verdicts_are_refused_with_the_reason() {
    let (study, cases) = study();
    let without = |drop: &dyn Fn(&CaseRecord) -> bool| -> Vec<StoredCase> {
        cases.iter().filter(|c| !drop(&c.record)).cloned().collect()
    };
    let few = without(&|r| r.family != "sizes" || r.mesh.cells != 4_500);
    let alone = analyse(&study, &few);
    refused(&alone, "no family of meshes has two converged cases");
    assert!(alone.settings.iter().all(|s| s.worst.is_finite() || s.limited_by.starts_with("no error bar of the ")));
    let mut stopped = cases.clone();
    for c in stopped.iter_mut().filter(|c| c.record.family != "sizes") {
        c.record.status = "StepTooSmall".into();
        c.record.status_detail = Some("at t = 0.6 s".into());
    }
    let a = analyse(&study, &stopped);
    assert!(a.incomplete.iter().any(|(id, what)| id == "element-length-1100" && what.contains("at t = 0.6 s")));
    let mut point = cases.clone();
    point[0].record.no_limit = Some("the cable acts through points".into());
    refused(&analyse(&study, &point), "through points");
    let mut strict = study.clone();
    strict.tolerance = 1e-5;
    refused(&analyse(&strict, &cases), "above the tolerance");
    let mut noisy = without(&|r| r.family == "nested" || r.family == "element");
    for (k, c) in noisy.iter_mut().filter(|c| c.record.family == "seeds" && c.record.variant == "length").enumerate() {
        c.record.probes.get_mut("cable_tension_N").expect("probe").peak = 6.4 + 0.5 * k as f64;
    }
    refused(&analyse(&study, &noisy), "mesh noise");
}

/// A peak that a prescribed value cuts off is the same on every mesh, which says nothing where the curves differ; where they agree, it is independent of the mesh.
#[test]
fn a_peak_that_is_cut_off_is_no_limit() {
    let tolerance: Tolerance = 0.05.into();
    let of = |slope: fn(usize) -> f64| {
        let level = |n: &usize| Level { id: n.to_string(), h: size(*n), f: 1.0, ..Level::default() };
        let levels = SIZES.iter().map(level).collect();
        let mut e = estimate(("family", Role::Sizes, "tet4"), levels, None, tolerance).expect("four meshes");
        assert!(e.class == Convergence::Exact && e.defensible, "{e:?}");
        let t: Vec<f64> = (0..=20).map(|k| f64::from(k) / 20.0).collect();
        let curve = |n: usize| {
            let value: Vec<f64> = t.iter().map(|t| (slope(n) * t).min(1.0)).collect();
            Curve { t: t.clone(), f: value }
        };
        let members: Vec<_> = SIZES.iter().map(|n| (n.to_string(), size(*n), curve(*n))).collect();
        e.check_curves(&compare(&members, 2.0).expect("four curves"), tolerance);
        e
    };
    let cut = of(|n| 2.0 + 2000.0 / n as f64);
    assert!(cut.refused && !cut.defensible && cut.reasons.iter().any(|why| why.contains("cuts it off")), "{cut:?}");
    assert!(of(|_| 2.0).defensible);
}
