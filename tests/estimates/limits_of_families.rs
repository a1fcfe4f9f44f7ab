//! Limits, orders and uncertainties of families of meshes, against manufactured sequences.

use crate::common::synthetic::{SIZES, size, study};
use durometer::math::statistics::larger;
use durometer::study::curve::{Curve, peak};
use durometer::study::estimate::curve::compare;
use durometer::study::estimate::family::{Estimate, Level, estimate};
use durometer::study::estimate::least_squares::least_squares;
use durometer::study::estimate::richardson::{Convergence, Triple};
use durometer::study::store::record::*;
use std::f64::consts::PI;

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

pub fn of_family(role: Role, f: &[f64], scatter: Option<f64>) -> Estimate {
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
    // Two meshes: Fs = 4, and no support
    let two = of_family(Role::Element, &f[..2], None);
    assert!(
        two.fs == 4.0 && !two.defensible && !two.refused && (two.extrapolated - 60.0).abs() < two.uncertainty,
        "{two:?}"
    );
    // The orders that edges permit, 2λ: 1 and more at clamps and cracks, 0.6 to 1 where a held face ends at a re-entrant edge
    for (glued, orders) in [(false, [1.0, 1.2, 1.5, 2.0]), (true, [0.6, 0.7, 0.85, 1.0])] {
        for (p, ratio) in orders.into_iter().flat_map(|p| [1.3, 1.5, 2.0].map(|ratio| (p, ratio))) {
            let level = |h: f64| Level { id: h.to_string(), h, f: 60.0 + 6.0 * h.powf(p), glued, ..Level::default() };
            let levels = [1.0, ratio].map(level).to_vec();
            let e = estimate(("family", Role::Sizes, "tet10"), levels, None, 0.05).expect("two meshes");
            assert!((e.extrapolated - 60.0).abs() <= e.uncertainty, "{p} {ratio}: {e:?}");
        }
    }
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
