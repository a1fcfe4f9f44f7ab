//! Convergence analysis against manufactured sequences, and the report from synthetic cases.

use crate::common::synthetic::{SIZES, size, store, study};
use durometer::math::statistics::{larger, smaller};
use durometer::report::numbers::{percent, percent_cell};
use durometer::study::analysis::{Analysis, ByQuantity};
use durometer::study::curve::{Curve, peak};
use durometer::study::estimate::curve::compare;
use durometer::study::estimate::family::{Estimate, Level, estimate};
use durometer::study::estimate::least_squares::least_squares;
use durometer::study::estimate::method::Method;
use durometer::study::estimate::richardson::{Convergence, Triple};
use durometer::study::estimate::tolerance::Tolerance;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::bars;
use durometer::study::kinds::convergence::errors::StepCause;
use durometer::study::kinds::convergence::figures;
use durometer::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use durometer::study::kinds::convergence::report::quantities::{quantities, settings};
use durometer::study::kinds::convergence::verdict;
use durometer::study::locking;
use durometer::study::report;
use durometer::study::run::inputs::InputRecord;
use durometer::study::store::record::*;
use durometer::study::store::results::Results;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

#[test]
fn a_power_law_is_recovered_with_unequal_ratios() {
    for (f0, alpha, p) in [(61.3, -4.0e5, 2.0), (5.2, 900.0, 1.37), (-7.0, 3.0, 0.62), (1.0, 2.0e9, 3.9)] {
        let h = [36_600, 16_200, 9_300].map(size);
        let f = h.map(|h: f64| f0 + alpha * h.powf(p));
        let t = Triple::new(h, f);
        let found = t.p.expect("monotone");
        // Rounding of f, eps·|f|, enters p through ln(ε₃₂/ε₂₁) over ln r ≈ 0.2, and two differences
        let noise = 40.0 * f64::EPSILON * f[0].abs().max(f[2].abs()) / (f[1] - f[0]).abs();
        assert!((found / p - 1.0).abs() < noise.max(1e-12), "p = {found}, not {p} (allowed {noise:e})");
        let star = f[0] + t.correction(found);
        // f* − f₁ = (f₁ − f₂)/(r^p − 1) inherits it, amplified by at most 1/(p ln r)
        let allowed = (noise * 20.0 / p * (f[1] - f[0]).abs()).max(1e-12 * f0.abs());
        assert!((star - f0).abs() < allowed, "f* = {star}, not {f0}");
    }
}

#[test]
fn the_limit_of_a_monotone_ratio_is_the_one_of_unequal_sizes() {
    let h = [36_600, 16_200, 9_300].map(size);
    let limit = Triple::new(h, [0.0, 1.0, 2.0]).ratio_limit;
    assert!((limit - 1.47).abs() < 5e-3, "ln r21/ln r32 = {limit}, design says 1.47");
    let class = |ratio: f64| Triple::new(h, [0.0, ratio, ratio + 1.0]).class;
    // R = 1.4 > 1 is still monotone here; just above the limit no p > 0 exists
    assert_eq!(class(1.4), Convergence::Monotone);
    assert_eq!(class(limit * (1.0 + 1e-9)), Convergence::Diverging);
    assert_eq!(class(-0.5), Convergence::Oscillatory);
    assert_eq!(class(-1.0), Convergence::Diverging);
    assert_eq!(Triple::new(h, [3.0; 3]).class, Convergence::Exact);
    let p = Triple::new(h, [0.0, 1.4, 2.4]).p.expect("monotone");
    assert!(p > 0.0 && p < 0.5, "R near the limit means p near 0, not {p}");
}

#[test]
fn least_squares_recovers_exact_data_and_falls_back_on_insane_orders() {
    let h = SIZES.map(size);
    let fit =
        |p: f64| least_squares(&h, &h.map(|h: f64| 61.0 + 20.0 * (h / size(4500)).powf(p)), 2.0).expect("4 meshes");
    let f = fit(1.6);
    assert_eq!(f.model, "αh^p");
    assert!(f.good && f.fs == 1.25);
    // The golden section stops at Δp ≈ 1e-9, f₀ follows with ∂f₀/∂p ≈ 20
    assert!((f.p - 1.6).abs() < 1e-7 && (f.f0 - 61.0).abs() < 1e-5, "p = {}, f0 = {}", f.p, f.f0);
    let above = fit(3.5);
    assert!(above.model == "αh²" && !above.good && above.fs == 3.0, "{above:?}");
    let below = fit(0.2);
    assert!(["αh", "αh²", "αh+βh²"].contains(&below.model.as_str()) && !below.good, "{below:?}");
    let scatter = least_squares(&h, &[61.0, 62.0, 60.9, 62.1], 2.0).expect("4 meshes");
    assert!(!scatter.good && scatter.uncertainty[0] > 1.0, "{scatter:?}");
}

fn of_family(role: Role, f: &[f64], scatter: Option<f64>) -> Estimate {
    let levels =
        f.iter().zip(SIZES).map(|(f, n)| Level { id: n.to_string(), h: size(n), f: *f, ..Level::default() }).collect();
    estimate(("family", role, "tet4"), levels, scatter, 0.05).expect("two or more meshes")
}

#[test]
fn uncertainty_covers_the_truth_and_poor_data_are_not_defensible() {
    let power = |h: f64| 60.0 + 6.0 * (h / size(4500)).powf(1.8) + 0.3 * (h / size(4500)).powi(3);
    let e = of_family(Role::Sizes, &SIZES.map(|n| power(size(n))), None);
    assert!(e.defensible && (e.extrapolated - 60.0).abs() <= e.uncertainty, "{e:?}");
    assert!(e.reasons[0].contains("Roache"), "ratios below 1.3 are said: {:?}", e.reasons);
    for (name, f) in [("oscillating", [60.0, 63.0, 58.0, 64.0]), ("diverging", [60.0, 66.0, 68.0, 69.0])] {
        let e = of_family(Role::Sizes, &f, None);
        assert!(!e.defensible && e.reasons.len() > 1, "{name}: {e:?}");
    }
    // The same clean sequence under a scatter larger than its differences, which a nested family does not have
    let f = SIZES.map(|n| 60.0 + 6.0 * (size(n) / size(4500)).powf(1.8));
    let noisy = of_family(Role::Sizes, &f, Some(3.0));
    assert!(!noisy.defensible && noisy.reasons.iter().any(|r| r.contains("mesh noise")), "{noisy:?}");
    assert!(of_family(Role::Nested, &f, Some(3.0)).defensible);
    // Two meshes: Fs = 3
    let two = of_family(Role::Element, &f[..2], None);
    assert!(two.fs == 3.0 && (two.extrapolated - 60.0).abs() < two.uncertainty, "{two:?}");
}

#[test]
fn curves_give_one_order_their_limit_and_their_lag() {
    let t: Vec<f64> = (0..=80).map(|k| f64::from(k) * 0.05).collect();
    let theta = |t: f64, late: f64| 30.0 * (1.0 - (PI * (t - late)).cos());
    let member = |n: usize, amplitude: f64, late: f64| {
        let f = t.iter().map(|t| amplitude * theta(*t, late)).collect();
        (n.to_string(), size(n), Curve { t: t.clone(), f })
    };
    let a = |n: usize| 1.0 + 0.1 * (size(n) / size(4500)).powf(1.5);
    let c = compare(&SIZES.map(|n| member(n, a(n), 0.0)), 2.0).expect("curves");
    // Same shape, so the norms follow the amplitude exactly
    assert!((c.observed_order.expect("monotone") - 1.5).abs() < 1e-9);
    assert!(c.t.iter().zip(&c.star).all(|(t, f)| (f - theta(*t, 0.0)).abs() < 1e-9));
    assert_eq!(c.interpolation_error, 0.0);
    // Two full cycles of 2 s
    assert!(c.norms[0].cycle_defect.expect("two cycles") < 1e-12);
    // Differences that do not shrink, and imposed curves: nothing is extrapolated
    let wild: Vec<_> = SIZES.iter().zip([1.0, 1.3, 1.4, 1.42]).map(|(n, a)| member(*n, a, 0.0)).collect();
    let w = compare(&wild, 2.0).expect("curves");
    assert!(w.observed_order.is_none() && w.order_used.is_none() && w.star.is_empty());
    // Back and forth: the norms of the differences fall as if the curves converged
    let swinging: Vec<_> = SIZES.iter().zip([1.0, 1.004, 0.99, 1.04]).map(|(n, a)| member(*n, a, 0.0)).collect();
    let s = compare(&swinging, 2.0).expect("curves");
    assert!(s.star.is_empty() && s.observed_order.is_none() && s.convergence_ratio.is_some_and(|r| r < 0.0), "{s:?}");
    // A position is judged by its changes: the norms of a curve that starts at a metre are those of one that starts at zero
    let far = |far: f64| {
        let moved = |n: usize| {
            let (id, h, mut curve) = member(n, a(n), 0.0);
            curve.f.iter_mut().for_each(|f| *f += far);
            (id, h, curve)
        };
        compare(&SIZES.map(moved), 2.0).expect("curves")
    };
    let (near, far) = (far(0.0), far(1e3));
    for (a, b) in near.norms.iter().zip(&far.norms) {
        assert!((a.peak / b.peak - 1.0).abs() < 1e-9, "{a:?} {b:?}");
        assert!((a.l2_error.expect("a limit") - b.l2_error.expect("a limit")).abs() < 1e-9, "{a:?} {b:?}");
    }
    assert!((near.gci_percent.expect("a limit") - far.gci_percent.expect("a limit")).abs() < 1e-7);
    let imposed = compare(&SIZES.map(|n| member(n, 1.0, 0.0)), 2.0).expect("curves");
    assert!(imposed.star.is_empty() && imposed.order_used.is_none());
    // Rounding of the solver has no order, however well its differences fall
    let rounding = |n: usize| member(n, 1.0 + 1e-9 * (size(n) / size(4500)).powf(1.5), 0.0);
    let noise = compare(&SIZES.map(rounding), 2.0).expect("curves");
    assert!(noise.star.is_empty() && noise.observed_order.is_none() && noise.gci_percent.is_none(), "{noise:?}");
    // Lag of 10 ms: first order in ωτ = 0.03 and finite differences over ωΔt = 0.16, both squared: 1 %
    let lagging = compare(&[member(36_600, 1.0, 0.0), member(16_200, 1.0, 0.01)], 2.0).expect("curves");
    let lag = lagging.norms[1].lag_s.expect("a small lag");
    assert!((lag / 0.01 - 1.0).abs() < 0.01, "{lag}");
    // Another grid: linear interpolation, whose error Δt²·|θ̈|/8 = 0.05²·30π²/8 is reported
    let mut other = member(16_200, 1.0, 0.0);
    let fine: Vec<f64> = (0..=80).map(|k| f64::from(k) * 0.05 + if k == 0 || k == 80 { 0.0 } else { 0.02 }).collect();
    other.2 = Curve { f: fine.iter().map(|t| theta(*t, 0.0)).collect(), t: fine };
    let c = compare(&[member(36_600, 1.0, 0.0), other], 2.0).expect("curves");
    let bound = 0.05_f64.powi(2) * 30.0 * PI * PI / 8.0;
    assert!(c.interpolation_error > 0.5 * bound && c.interpolation_error < 2.0 * bound);
    assert!(c.norms[1].linf_to_finer < 2.0 * bound);
}

#[test]
fn what_does_not_start_at_zero_is_judged_by_its_change() {
    let (_, mut cases) = study();
    let wave = cases[0].series.columns["bending_angle_deg"].clone();
    let top = wave.iter().copied().fold(0.0, larger);
    let length = wave.iter().map(|w| 0.1 - 0.016 * w / top).collect();
    cases[0].series.columns.insert("cable_length_m".into(), length);
    let change = peak(&cases[0], "cable_length_m").expect("column");
    assert!((change + 0.016).abs() < 1e-15, "{change}");
    assert_eq!(peak(&cases[0], "bending_angle_deg"), Some(top));
}

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
        r.inputs = vec![InputRecord { constant: "laws.rubber.mu".into(), half_width: 1e4, derivatives }];
    }
    let inputs = of_constants(&cases).expect("every case has derivatives");
    assert!(inputs.case == leading[0] && (inputs.share - 0.07).abs() < 1e-12, "{inputs:?}");
    let verdict = analyse(&study, &cases).verdict;
    assert!(verdict.contains(", 7 % constants, together"), "{verdict}");
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

/// Two meshes tend to a limit by assumption only.
#[test]
fn a_reference_of_two_meshes_is_doubted() {
    let (study, mut cases) = study();
    cases.retain(|c| c.record.family == "sizes");
    let doubted = |cases: &[StoredCase]| {
        let warnings = analyse(&study, cases).warnings;
        warnings.iter().filter(|w| w.contains("two meshes of family sizes show no order")).count()
    };
    assert_eq!(doubted(&cases), 0);
    cases.retain(|c| c.record.mesh.cells > 10_000);
    assert_eq!(doubted(&cases), 3, "one for each quantity");
    let a = analyse(&study, &cases);
    assert!(quantities(&a).rows.iter().all(|row| row[4] == "not shown by two meshes"), "{:?}", quantities(&a).rows);
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

/// A study with its cases, as they are stored.
fn results(study: &StudyRecord, cases: &[StoredCase]) -> Results {
    Results {
        study: study.clone(),
        cases: cases.to_vec(),
        skins: BTreeMap::new(),
        motions: BTreeMap::new(),
        found: BTreeMap::new(),
        sensitivities: BTreeMap::new(),
        derived: None,
        damaged: vec![],
        outdated: vec![],
    }
}

/// A quantity that decides in one variant is none that another one judges: there all that is listed decides, as none of it is marked.
#[test]
fn curves_show_what_decides_in_their_variant() {
    let (mut study, cases) = study();
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().for_each(|q| q.deciding = q.name == "cable_tension_N");
    study.quantities.get_mut("tension").expect("variant").iter_mut().for_each(|q| q.headline = false);
    let found = analyse(&study, &cases).found;
    let shows = |variant: &str| {
        let svg = figures::curves::draw(&results(&study, &cases), &found, variant).expect("a figure").svg;
        ["Bending angle", "Cable tension"].map(|title| svg.contains(title))
    };
    assert_eq!([shows("length"), shows("tension")], [[false, true], [true, false]]);
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

/// The edge of the coarse meshes is longer than similar meshes would have it: the two limits differ, and U(f*) holds both.
#[test]
fn meshes_that_are_not_similar_have_a_wider_uncertainty() {
    let power = |n: usize| 60.0 + 6.0 * (size(n) / size(4500)).powf(1.8);
    let of = |grows: [f64; 4]| {
        let levels = SIZES.iter().zip(grows);
        let level = |(n, g): (&usize, f64)| Level {
            id: n.to_string(),
            h: size(*n),
            edge: Some(g * size(*n)),
            f: power(*n),
            ..Level::default()
        };
        estimate(("family", Role::Sizes, "tet4"), levels.map(level).collect(), None, 0.05).expect("four meshes")
    };
    let (similar, dissimilar) = (of([2.0; 4]), of([1.8, 2.0, 2.3, 2.9]));
    let (_, limit) = dissimilar.by_edge.expect("edges are given");
    assert!((similar.by_edge.expect("edges are given").1 - similar.extrapolated).abs() < 1e-6);
    assert!(dissimilar.uncertainty >= similar.uncertainty + 0.9 * (limit - similar.extrapolated).abs());
    assert!((limit - dissimilar.extrapolated).abs() > 0.1, "{limit}");
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

/// The uncertainty in the table is a share of what the bars are shares of.
#[test]
fn the_table_of_limits_knows_absolute_tolerances() {
    let (mut study, cases) = study();
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.iter_mut().for_each(|q| q.absolute_tolerance = Some(1e3));
    let a = analyse(&study, &cases);
    let table = quantities(&a);
    let share = table.columns.iter().position(|c| c.0 == "U(f*)").expect("a column");
    let own = a.quantities.iter().flat_map(|q| q.estimates.iter().map(move |e| (q, e)));
    for (row, (q, e)) in table.rows.iter().zip(own) {
        let scale = if q.variant == "length" { 1e3 / study.tolerance } else { e.extrapolated.abs() };
        assert_eq!(row[share], percent_cell(e.uncertainty / scale), "{row:?}");
    }
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

/// The same cells across a wall at every size: a clean order that means nothing.
#[test]
fn orders_over_unresolved_walls_are_refused() {
    let clean = |n: usize| 60.0 + 6.0 * (size(n) / size(4500)).powf(1.8);
    let of = |walls: [f64; 4]| {
        let level = |(n, wall): (&usize, f64)| Level {
            id: n.to_string(),
            h: size(*n),
            f: clean(*n),
            wall: Some(wall),
            ..Level::default()
        };
        let levels = SIZES.iter().zip(walls).map(level).collect();
        estimate(("family", Role::Sizes, "tet4"), levels, None, 0.05).expect("four meshes")
    };
    let why = |e: &Estimate| e.reasons.join("; ");
    assert!(of([4.0, 3.05, 2.5, 2.0]).defensible);
    let thin = of([1.0, 1.0, 1.0, 1.0]);
    assert!(
        !thin.defensible && why(&thin).contains("1.0, 1.0, 1.0, 1.0 cells across the thinnest wall"),
        "{}",
        why(&thin)
    );
    let same = of([3.0, 3.0, 3.0, 3.0]);
    assert!(!same.defensible && why(&same).contains("hardly change"), "{}", why(&same));
}

#[test]
fn a_diverging_family_is_no_reference_and_an_oscillating_one_has_its_spread() {
    let diverging = of_family(Role::Sizes, &[60.0, 60.3, 60.4, 60.42], None);
    assert_eq!(diverging.class, Convergence::Diverging);
    assert!(!diverging.defensible && diverging.reasons.iter().any(|r| r.contains("diverges")), "{diverging:?}");
    assert!(of_family(Role::Sizes, &[60.0, 60.3, 60.4, 60.42], Some(0.2)).defensible, "the scatter explains it");
    assert!(of_family(Role::Sizes, &[60.0, 60.003, 60.004, 60.0042], None).defensible, "0.02 % of a tolerance of 5 %");
    let oscillating = of_family(Role::Sizes, &[60.0, 60.2, 59.9, 60.3], None);
    assert_eq!(oscillating.class, Convergence::Oscillatory);
    let is = |e: &Estimate, spread: f64| (e.uncertainty - 3.0 * spread).abs() < 1e-9;
    assert!(oscillating.defensible && is(&oscillating, 0.3), "{oscillating:?}");
    assert!(oscillating.reasons.iter().any(|r| r.ends_with("½(max − min) = 1.500e-1")), "{:?}", oscillating.reasons);
}

/// Angles of an actuator on 71 790, 8 906, 4 934 and 2 755 cells: the coarsest mesh counts by its size, so that every finer mesh narrows the bar.
#[test]
fn a_coarse_mesh_does_not_hold_up_the_bar_for_ever() {
    let of = |cells: &[usize], f: &[f64]| {
        let level = |(n, f): (&usize, &f64)| Level { id: n.to_string(), h: size(*n), f: *f, ..Level::default() };
        let levels = cells.iter().zip(f).map(level).collect();
        estimate(("family", Role::Sizes, "tet10_up"), levels, None, 0.02).expect("meshes")
    };
    let (cells, f) = ([71_790, 8_906, 4_934, 2_755], [23.56, 23.49, 23.81, 21.77]);
    let (four, three) = (of(&cells, &f), of(&cells[..3], &f[..3]));
    // Three times the range, 0.32, and the error of the finest by a first order, 0.07/(2.005 − 1)
    assert!((three.uncertainty - 3.0 * (0.32 + 0.07 / (three.ratios[0] - 1.0))).abs() < 1e-9, "{three:?}");
    assert!((four.uncertainty / 23.56 - 0.116).abs() < 1e-2, "{four:?}");
    let five = of(&[&[574_000], &cells[..]].concat(), &[&[23.53], &f[..]].concat());
    assert!(five.uncertainty < 0.5 * four.uncertainty, "{five:?}");
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
    assert!(a.warnings.iter().any(|w| w.contains("nothing depends on the time steps")), "{:?}", a.warnings);
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
    let said = a.warnings.iter().find(|w| w.contains("nothing depends on the time steps")).expect("a warning");
    assert!(said.contains("do not differ in any digit") && !said.contains("0.0e0"), "{said}");
}

/// A tension without a share in the loads is rounding next to the other one, and its digits say nothing.
#[test]
fn values_of_rounding_have_no_algebraic_error_to_tell() {
    let (mut study, mut cases) = study();
    let rounding = |name: &str| Quantity { name: name.into(), label: "side force".into(), ..Quantity::default() };
    let listed = study.quantities.get_mut("length").expect("variant");
    listed.push(Quantity { unit: "N".into(), ..rounding("side_force_N") });
    for (k, c) in cases.iter_mut().enumerate() {
        c.record.steps_matter = Some(false);
        let side = ProbeRecord { peak: 1e-12 * (1 + k % 7) as f64, ..c.record.probes["cable_tension_N"].clone() };
        c.record.probes.insert("side_force_N".into(), side);
    }
    let a = analyse(&study, &cases);
    let step = a.find("length", "side_force_N").and_then(|q| q.step.clone()).expect("a family of time steps");
    assert!(step.error > 0.1 * step.values.iter().copied().fold(0.0, larger), "{step:?}");
    let said = a.warnings.iter().find(|w| w.contains("nothing depends on the time steps")).expect("a warning");
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

/// The methods of a paper name the terms of the bars, and no term that no bar has.
#[test]
fn sources_of_bars_are_those_that_were_there() {
    let (study, cases) = study();
    let all = bars::errors(&analyse(&study, &cases));
    for words in
        ["the error of the time steps", "[@celik2008]", "[@eca2014]", "[@roache1994]", "added as absolute values"]
    {
        assert!(all.contains(words), "{words}: {all}");
    }
    let several = "the distance between the limits of the families";
    let sizes: Vec<StoredCase> = cases.iter().filter(|c| c.record.family == "sizes").cloned().collect();
    assert!(all.contains(several) && !bars::errors(&analyse(&study, &sizes)).contains(several), "{all}");
    assert!(!all.contains("uncertain constants"), "{all}");
    let without_steps: Vec<StoredCase> = cases.iter().filter(|c| c.record.family != "time_step").cloned().collect();
    let fewer = bars::errors(&analyse(&study, &without_steps));
    assert!(!fewer.contains("time steps") && fewer.contains("added as absolute values"), "{fewer}");
    let one: Vec<StoredCase> = cases.iter().take(1).cloned().collect();
    assert!(bars::errors(&analyse(&study, &one)).starts_with("No error bar is computed"));
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

/// Clamped beam of tet4 under its own weight, bending angle 35.697° (2000 tet10): meshes of one size to within a tenth, whose differences say little, of independent meshers' runs.
#[test]
fn meshes_that_are_nearly_the_same_claim_an_error_of_first_order() {
    let families = [
        ([1.238653, 1.282819, 1.329745], [32.3155, 32.1962, 31.6117]),
        ([1.233672, 1.275502, 1.316165], [32.4386, 32.1947, 31.6841]),
        ([1.238653, 1.290308, 1.361878], [32.3155, 31.9364, 31.3465]),
        ([1.204389, 1.261774, 1.299968], [32.6877, 32.3581, 31.9126]),
    ];
    for (h, f) in families {
        let level = |(h, f): (&f64, &f64)| Level { id: h.to_string(), h: *h, f: *f, ..Level::default() };
        let levels = h.iter().zip(&f).map(level).collect();
        let e = estimate(("sizes", Role::Sizes, "tet4"), levels, None, 0.1).expect("three meshes");
        assert!((e.extrapolated - 35.697).abs() <= e.uncertainty && !e.defensible, "{e:?}");
    }
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

// --- the report --------------------------------------------------------------------------------------------------

#[test]
fn a_report_is_complete_and_can_be_redrawn() {
    let dir = tempfile::tempdir().expect("temporary folder");
    store(dir.path(), &study());
    // REPORT_EXAMPLE=DIR leaves the stored study and its report there, to look at the pictures
    if let Ok(keep) = std::env::var("REPORT_EXAMPLE") {
        let keep = Path::new(&keep);
        if !keep.join("study.json").exists() {
            store(keep, &study());
        }
        report::write(keep).unwrap_or_else(|e| panic!("{e}"));
    }
    let first = report::write(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let read = |name: &str| std::fs::read_to_string(dir.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (page, summary) = (read("index.html"), read("summary.json"));
    assert!(page.contains(&first.verdict) && page.contains("<svg"));
    assert!(!page.contains("src=") && !page.contains("http-equiv"), "nothing outside of the page");
    let json: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let analysis = &json["analysis"];
    assert_eq!(analysis["variant"], "tension");
    assert_eq!(analysis["recommended_case"], "element-tension-2200");
    for key in ["observed_order", "richardson_peak", "gci_percent", "convergence_ratio"] {
        assert!(analysis[key].is_f64(), "{key}: {}", analysis[key]);
    }
    assert!(analysis["cable_tension_N"]["length"]["reference"]["value"].is_f64());
    let case = &json["cases"][0];
    for key in ["id", "formulation", "law", "dt_s", "status", "wall_s", "steps", "newton_iterations", "effects"] {
        assert!(!case[key].is_null(), "{key}");
    }
    assert!(case["mesh"]["h_m"].is_f64() && case["probes"]["bending_angle_deg"]["final"].is_f64());
    assert!(read("tables/cases.csv").lines().count() > 30 && read("tables/quantities.tex").contains("\\toprule"));
    let svg = read("figures/curves-length.svg");
    assert!(svg.contains("Liberation Sans, Arial") && !svg.contains('\u{e000}'));
    for e in std::fs::read_dir(dir.path().join("figures")).expect("folder").flatten() {
        let least = if e.path().extension().is_some_and(|e| e == "tex") { 200 } else { 1000 };
        assert!(e.metadata().expect("file").len() > least, "{:?} is empty", e.path());
    }
    report::write(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary, read("summary.json"), "redrawing changes nothing");
    assert_eq!(page, read("index.html"), "redrawing changes nothing");
}

/// The error of the four sizes has two powers of h, so that the order of the least squares, which f* is found with, is not that of the three finest: next to f*
/// the table has the former, as the figure has.
#[test]
fn table_and_figure_have_the_order_of_the_limit() {
    let (study, mut cases) = study();
    for c in cases.iter_mut().filter(|c| c.is_in("sizes", "length")) {
        let h = c.record.mesh.h_m / size(4_500);
        c.record.probes.get_mut("cable_tension_N").expect("probe").peak = 6.4 * (1.0 + 0.15 * h + 0.1 * h.powi(3));
    }
    let a = analyse(&study, &cases);
    let tension = a.find("length", "cable_tension_N").expect("listed");
    let [sizes, nested] = ["sizes", "nested"].map(|family| tension.estimate(family).expect("meshes"));
    let [finest, p] = [sizes.observed_order, sizes.order_of_limit()].map(|p| p.expect("monotone"));
    assert!(
        matches!(sizes.method, Method::LeastSquares { .. }) && (finest - p).abs() > 0.05,
        "{finest} and {p}: {sizes:?}"
    );
    assert_eq!((&nested.method, nested.order_of_limit()), (&Method::Richardson, nested.observed_order));
    for e in [sizes, nested] {
        let law = |h: f64| e.power_law(h).expect("an order");
        let range = (e.values[0] - e.extrapolated).abs();
        // A millionth of h, to a power of more than one
        assert!((law(1e-6 * e.h_m[0]) - e.extrapolated).abs() < 1e-4 * range, "{e:?}");
        assert!((law(e.h_m[0]) - e.values[0]).abs() < 0.05 * range, "{e:?}");
    }
    let table = quantities(&a);
    let column = |name: &str| table.columns.iter().position(|c| c.0 == name).unwrap_or_else(|| panic!("{name}"));
    let is_row = |row: &&Vec<String>| row[0] == tension.peak_label() && row[1] == "length" && row[2].contains("sizes");
    let row = table.rows.iter().find(is_row).expect("a row");
    assert_eq!([&row[column("p finest")], &row[column("p")]], [&format!("{finest:.2}"), &format!("{p:.2}")]);
    let dir = tempfile::tempdir().expect("temporary folder");
    store(dir.path(), &(study, cases));
    report::write(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let svg = std::fs::read_to_string(dir.path().join("figures/error-h.svg")).expect("written");
    assert!(svg.contains(&format!("</tspan> = {p:.2}\n")), "no p = {p:.2}");
    // Where noise hides the differences nothing is extrapolated, although there is a fit
    let f = SIZES.map(|n| 60.0 + 6.0 * (size(n) / size(4500)).powf(1.8));
    let noisy = of_family(Role::Sizes, &f, Some(3.0));
    assert!(noisy.fit.is_some() && noisy.order_of_limit().is_none() && noisy.power_law(size(4500)).is_none());
}

#[test]
fn missing_and_failed_cases_still_get_a_report_and_broken_files_a_remedy() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let message = || report::write(dir.path()).expect_err("must be refused").to_string();
    assert!(message().contains("study.json does not exist") && message().contains("durometer run"));
    store(dir.path(), &study());
    let path = |name: &str| dir.path().join(name);
    for e in std::fs::read_dir(path("cases")).expect("folder").flatten() {
        if !e.file_name().to_string_lossy().starts_with("sizes-length") {
            std::fs::remove_file(e.path()).expect("file");
        }
    }
    let summary = report::write(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.verdict.starts_with("No verdict"), "{}", summary.verdict);
    let not_run: Vec<&String> = summary.warnings.iter().filter(|w| w.contains("no result")).collect();
    assert!(not_run.len() == 1 && not_run[0].contains(" cases have no result yet: "), "{not_run:?}");
    assert!(not_run[0].ends_with(" more.") && summary.verdict.contains(" more."), "{not_run:?}: {}", summary.verdict);
    std::fs::write(path("cases/sizes-length-4500.csv"), "t_s,bending_angle_deg\n0,0\n0.1,fast\n").expect("file");
    let damaged = || report::write(dir.path()).unwrap_or_else(|e| panic!("{e}")).damaged.join("\n");
    assert!(damaged().contains("line 3: bending_angle_deg is \"fast\""), "{}", damaged());
    std::fs::write(path("cases/sizes-length-9300.json"), "{\"id\": 3").expect("file");
    assert!(damaged().contains("sizes-length-9300.json: it is not a valid record"), "{}", damaged());
    for (provenance, wrote) in [
        (r#"{"version": "0.1.0", "scene": ""}"#, "an earlier build of durometer 0.1.0"),
        (
            r#"{"scene": "", "build": {"version": "0.0.7", "source_sha256": "4f2a00112233", "compiler": "rustc 1.70", "cpu": "x86_64"}}"#,
            "durometer 0.0.7, sources 4f2a00112233, rustc 1.70",
        ),
    ] {
        let text = format!(r#"{{"id": "sizes-length-9300", "provenance": {provenance}}}"#);
        std::fs::write(path("cases/sizes-length-9300.json"), text).expect("file");
        let said = message();
        assert!(
            said.contains(wrote) && said.contains("missing field") && said.contains("run the study again"),
            "{said}"
        );
    }
    store(dir.path(), &study());
    std::fs::remove_dir_all(path("figures")).expect("folder");
    std::fs::write(path("figures"), "in the way").expect("file");
    assert!(message().contains("cannot write") && message().contains("figures"), "{}", message());
}
