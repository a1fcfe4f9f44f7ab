//! Sweeps and cumulative comparisons: closed forms of trend and elasticity, the points that axes make, refusals, a run from end to end.

// It serves the tests of another kind of study too.
#[allow(dead_code)]
use crate::common::synthetic;
use durometer::scene::ExtremeKind;
use durometer::study::analysis::Analysis;
use durometer::study::axis::AxisRecord;
use durometer::study::curve::{missed_extremes, peak, peak_words};
use durometer::study::expand::Study;
use durometer::study::kinds::comparison;
use durometer::study::kinds::sweep::analysis::{self, Along, Judged, SweepFindings, SweepRecord, Trend};
use durometer::study::report;
use durometer::study::store::record::{EffectRecord, FamilyRecord, Role, StoredCase, StudyQuantity, StudyRecord};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

fn sweep_of(study: &StudyRecord) -> SweepRecord {
    serde_json::from_value(study.details.clone()).expect("the record of a sweep")
}

fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis<SweepFindings> {
    analysis::analyse(study, &sweep_of(study), stored)
}

fn axis(name: &str, values: &[f64]) -> AxisRecord {
    AxisRecord {
        name: name.into(),
        keys: vec!["laws.rubber.E".into()],
        label: format!("key {name}"),
        symbol: name.into(),
        unit: "kPa".into(),
        values: values.iter().map(|v| format!("{v} kPa")).collect(),
        numbers: values.to_vec(),
    }
}

/// A grid over p and q with the peak y(p, q), from the cases of the made-up study.
fn study(p: &[f64], q: &[f64], y: impl Fn(f64, f64) -> f64) -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, cases) = synthetic::study();
    let (mut points, mut stored) = (BTreeMap::new(), vec![]);
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            let mut c = cases[0].clone();
            let member = format!("p{i}_q{j}");
            c.record.id = format!("sweep-length-{member}");
            (c.record.family, c.record.variant, c.record.member) = ("sweep".into(), "length".into(), member.clone());
            c.record.status = "Converged".into();
            let probe = c.record.probes.get_mut("cable_tension_N").expect("probe");
            probe.peak = y(*p, *q);
            probe.peak_is = if probe.peak < 0.0 { ExtremeKind::Minimum } else { ExtremeKind::Maximum };
            let n = c.series.t_s.len() - 1;
            let wave = (0..=n).map(|k| y(*p, *q) * k as f64 / n as f64).collect();
            c.series.columns.insert("cable_tension_N".into(), wave);
            points.insert(member, vec![i, j]);
            stored.push(c);
        }
    }
    let ids = stored.iter().map(|c| c.record.id.clone()).collect();
    study.kind = "sweep".into();
    study.variants = vec!["length".into()];
    study.families = vec![FamilyRecord {
        name: "sweep".into(),
        role: Role::Grid,
        formulation: "tet10".into(),
        cases: ids,
        members: vec![],
    }];
    let sweep = SweepRecord { axes: vec![axis("p", p), axis("q", q)], points, judged: Judged::Peak };
    study.details = serde_json::to_value(sweep).expect("numbers and strings");
    let tension = StudyQuantity {
        name: "cable_tension_N".into(),
        label: "cable tension".into(),
        symbol: "T".into(),
        unit: "N".into(),
        ..StudyQuantity::default()
    };
    study.quantities = BTreeMap::from([("length".into(), vec![tension])]);
    (study, stored)
}

const P: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
const Q: [f64; 3] = [1.0, 3.0, 4.0];

fn along<'a>(all: &'a [Along], name: &str) -> &'a Along {
    all.iter().find(|a| a.axis == name).expect(name)
}

/// Along q the absolute tolerance decides on the line with p = 1 only; both keys are told in the unit then, the larger change first.
#[test]
fn the_changes_of_a_quantity_are_told_in_one_form() {
    let (mut study, stored) = study(&P, &Q, |p, q| 1e-3 * (p - 1.0) + 2e-3 * (q - 1.0));
    study.tolerance = 0.05;
    for quantity in study.quantities.get_mut("length").expect("the only control") {
        quantity.absolute_tolerance = Some(4e-4);
    }
    let a = analyse(&study, &stored);
    assert!(a.verdict.contains("key p p (up to 0.00900 N), then key q q (up to 0.00600 N)"), "{}", a.verdict);
    let sentence = &a.quantities[0].sentence;
    assert!(sentence.contains("up to 0.00900 N") && sentence.contains("up to 0.00600 N"), "{sentence}");
}

/// y = 3 p^0.7/q²: the elasticities are the exponents between any two points, to the rounding of logarithms.
#[test]
fn a_power_law_has_its_exponents() {
    let (study, stored) = study(&P, &Q, |p, q| 3.0 * p.powf(0.7) / (q * q));
    let a = analyse(&study, &stored);
    let all = &a.quantities[0].along;
    for (name, exponent, trend) in [("p", 0.7, Trend::Rising), ("q", -2.0, Trend::Falling)] {
        let x = along(all, name);
        assert_eq!(x.trend, trend, "{name}");
        for e in x.elasticity.expect("positive values") {
            assert!((e - exponent).abs() < 1e-12, "{name}: {e}");
        }
    }
    // (max − min)/max along q: 1 − (1/4)²; along p: 1 − 10^−0.7
    assert!((along(all, "q").change - (1.0 - 1.0 / 16.0)).abs() < 1e-12);
    assert!((along(all, "p").change - (1.0 - 10f64.powf(-0.7))).abs() < 1e-12);
    assert!(a.verdict.contains("key q q (up to 94 %), then key p p (up to 80 %)"), "{}", a.verdict);
    let sentence = &a.quantities[0].sentence;
    assert!(sentence.contains("falls with key q q, whatever the others are"), "{sentence}");
}

/// y = −3 p^0.7: the value falls and its magnitude rises, and the elasticity is said to be that of the magnitude.
#[test]
fn words_of_a_negative_quantity_agree_with_its_elasticity() {
    let (study, stored) = study(&P, &[1.0], |p, _| -3.0 * p.powf(0.7));
    let q = &analyse(&study, &stored).quantities[0];
    let found = along(&q.along, "p");
    assert_eq!(found.trend, Trend::Falling);
    assert!(found.elasticity.expect("of one sign").iter().all(|e| (e - 0.7).abs() < 1e-12), "{found:?}");
    let expected = "falls (its magnitude rises) with key p p, by 80 % (elasticity of the magnitude 0.70 from";
    assert!(q.sentence.contains(expected), "{}", q.sentence);
}

/// y = 3 p^0.7/q² on top of a place: whatever that is, elasticities and changes are those of y, and the final places are shown.
#[test]
fn final_places_count_from_their_first_values() {
    let judged_at = |place: f64| {
        let y = |p: f64, q: f64| 3.0 * p.powf(0.7) / (q * q);
        let (mut study, mut stored) = study(&P, &Q, y);
        study.details["judged"] = serde_json::json!("final");
        for case in &mut stored {
            let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
            tension.iter_mut().for_each(|value| *value += place);
            let probe = case.record.probes.get_mut("cable_tension_N").expect("recorded");
            (probe.peak, probe.last) = (probe.peak + place, probe.peak + place);
        }
        analyse(&study, &stored)
    };
    for place in [0.0, 50.0, -3000.0] {
        let a = judged_at(place);
        let q = &a.quantities[0];
        let found = along(&q.along, "p");
        for e in found.elasticity.expect("of one sign") {
            assert!((e - 0.7).abs() < 1e-9, "at {place}: {e}");
        }
        assert!((found.change - (1.0 - 10f64.powf(-0.7))).abs() < 1e-9, "at {place}: {}", found.change);
        assert!((q.points[0].value - place - 3.0).abs() < 1e-9, "{:?}", q.points[0]);
        let says = |words: &str| words.contains("counted from its first value");
        assert_eq!([says(&q.sentence), says(&a.verdict)], [place != 0.0; 2], "{} {}", q.sentence, a.verdict);
    }
}

/// Lines of 1e-2, 1e-6 and 1e-8 rise alike. A line of what the solver leaves, an algebraic error of 1e-8 of what moves by 1 N, is constant.
#[test]
fn each_line_has_steps_of_its_own() {
    let (grid, stored) = study(&P, &Q, |p, q| p * 10f64.powf(-2.0 * q));
    let a = analyse(&grid, &stored);
    let found = along(&a.quantities[0].along, "p");
    assert!(found.trend == Trend::Rising && found.everywhere, "{found:?}");
    let (grid, mut stored) = study(&P, &Q, |p, q| if q == 1.0 { p } else { 1e-9 * (3.0 * p).sin() });
    assert_eq!(along(&analyse(&grid, &stored).quantities[0].along, "p").trend, Trend::Turning);
    solved_to_1e8(&mut stored);
    let a = analyse(&grid, &stored);
    let found = along(&a.quantities[0].along, "p");
    assert!(found.trend == Trend::Rising && !found.everywhere, "{found:?}");
}

/// 81 points whose neighbours differ by 1e-9 N, where the solver leaves 1e-8 N: what they add up to is a change, a wave below that turns nothing around, and
/// five such points are constant.
#[test]
fn small_steps_add_up() {
    let p: Vec<f64> = (1..=81).map(f64::from).collect();
    let found = |p: &[f64], y: &dyn Fn(f64) -> f64| {
        let (grid, mut stored) = study(p, &[1.0], |p, _| 1e-9 * y(p));
        solved_to_1e8(&mut stored);
        let a = analyse(&grid, &stored);
        (along(&a.quantities[0].along, "p").clone(), a.quantities[0].sentence.clone(), a.verdict)
    };
    let (rising, sentence, verdict) = found(&p, &|p| p);
    assert_eq!(rising.trend, Trend::Rising);
    assert!((rising.change - 80.0 / 81.0).abs() < 1e-12, "{rising:?}");
    assert!(sentence.contains("rises with key p p, by 99 %") && verdict.contains("changes with key p p"), "{sentence}");
    assert_eq!(found(&p, &|p| p + 3.0 * p.sin()).0.trend, Trend::Rising);
    assert_eq!(found(&p, &|p| 90.0 - p).0.trend, Trend::Falling);
    assert_eq!(found(&p, &|p| 41.0 - (p - 41.0).abs()).0.trend, Trend::Turning);
    let constant = found(&p[..5], &|p| p).0;
    assert_eq!((constant.trend, constant.change), (Trend::Constant, 0.0));
}

/// A trend is that of a rising value, in numbers, decisions, tables and words, whichever end of the axis comes first in the file; a list has that along its
/// points.
#[test]
fn a_trend_is_that_of_a_rising_value() {
    let mut falling = P;
    falling.reverse();
    for p in [P, falling] {
        let (grid, stored) = study(&p, &Q, |p, q| 3.0 * p.powf(0.7) / (q * q));
        let q = &analyse(&grid, &stored).quantities[0];
        let found = along(&q.along, "p");
        assert_eq!(found.trend, Trend::Rising, "{p:?}");
        assert!((found.change - (1.0 - 10f64.powf(-0.7))).abs() < 1e-12, "{found:?}");
        assert!(found.elasticity.expect("positive values").iter().all(|e| (e - 0.7).abs() < 1e-12), "{found:?}");
        assert!(q.sentence.contains("rises with key p p, whatever the others are"), "{}", q.sentence);
        let dir = tempfile::tempdir().expect("temporary folder");
        synthetic::store(dir.path(), &(grid, stored));
        let summary = report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        let decisions = summary.decisions.expect("decisions");
        assert_eq!(decisions["cable_tension_N, length along p"], "rising", "{p:?}");
        let table = std::fs::read_to_string(dir.path().join("tables/dependence.csv")).expect("written");
        assert!(table.contains("key p p,rises,"), "{table}");
    }
    let (mut grid, stored) = study(&falling, &[1.0], |p, _| 1.0 / p);
    let mut sweep = sweep_of(&grid);
    sweep.axes[1] = axis("q", &falling);
    sweep.points.values_mut().for_each(|at| *at = vec![at[0]; 2]);
    grid.details = serde_json::to_value(sweep).expect("numbers and strings");
    let sentence = &analyse(&grid, &stored).quantities[0].sentence;
    assert!(sentence.contains("It rises with the points of the list"), "{sentence}");
}

/// y = q p^0.7 is zero on the lines of q = 0, wherever they come: the others keep their exponent.
#[test]
fn a_line_of_zeros_leaves_the_elasticity_of_the_others() {
    for q in [[0.0, 1.0, 3.0], [1.0, 0.0, 3.0], [0.0, 0.0, 2.0]] {
        let (grid, stored) = study(&P, &[1.0, 2.0, 3.0], |p, k| q[k as usize - 1] * p.powf(0.7));
        let found = along(&analyse(&grid, &stored).quantities[0].along, "p").clone();
        assert!(found.trend == Trend::Rising && !found.everywhere, "{found:?}");
        assert!(found.elasticity.expect("lines that move").iter().all(|e| (e - 0.7).abs() < 1e-12), "{q:?}: {found:?}");
    }
    let (grid, stored) = study(&P, &Q, |_, _| 0.0);
    let found = along(&analyse(&grid, &stored).quantities[0].along, "p").clone();
    assert_eq!((found.trend, found.elasticity), (Trend::Constant, None));
}

/// Cases with another column of 1 N and an algebraic error of 1e-8 of it.
fn solved_to_1e8(stored: &mut [StoredCase]) {
    for case in stored {
        let mut other = case.record.probes["cable_tension_N"].clone();
        other.peak = 1.0;
        case.record.probes.insert("other_N".into(), other);
        case.record.solver.algebraic_error = 1e-8;
    }
}

/// A quantity of 1e-9 N of either sign, where the solver leaves 1e-8 N, is constant: its change is zero in words, numbers and decisions. Where the solver
/// leaves less, it changes by twice its size.
#[test]
fn what_the_solver_leaves_is_no_change() {
    let (grid, mut stored) = study(&P, &Q, |p, q| 1e-9 * (3.0 * p + q).sin());
    let a = analyse(&grid, &stored);
    assert!(a.verdict.contains(" changes with ") && a.verdict.contains("key p p (up to 1"), "{}", a.verdict);
    solved_to_1e8(&mut stored);
    let a = analyse(&grid, &stored);
    for name in ["p", "q"] {
        let found = along(&a.quantities[0].along, name);
        assert_eq!((found.trend, found.change), (Trend::Constant, 0.0), "{name}");
    }
    assert!(a.verdict.contains(" stays within ") && !a.verdict.contains("change"), "{}", a.verdict);
    let sentence = &a.quantities[0].sentence;
    assert!(["p p", "q q"].iter().all(|key| sentence.contains(&format!("does not depend on key {key}"))), "{sentence}");
}

/// A curvature of 20 1/m in the record says nothing of the rounding of a place: a place that moves by 1e-7 m has its trend, where the solver leaves 1e-8 of that.
#[test]
fn the_rounding_of_a_place_is_not_that_of_a_curvature() {
    let (mut grid, mut stored) = study(&P, &Q, |p, q| 1e-8 * (p + q));
    grid.quantities.get_mut("length").expect("quantities")[0].name = "tip_x_m".into();
    for case in &mut stored {
        let (record, columns) = (&mut case.record, &mut case.series.columns);
        let mut curvature = record.probes["cable_tension_N"].clone();
        curvature.peak = 20.0;
        record.probes.insert("line_1_curvature_per_m".into(), curvature);
        let place = record.probes.remove("cable_tension_N").expect("recorded");
        record.probes.insert("tip_x_m".into(), place);
        let place = columns.remove("cable_tension_N").expect("recorded");
        columns.insert("tip_x_m".into(), place);
        record.solver.algebraic_error = 1e-8;
    }
    assert_eq!(along(&analyse(&grid, &stored).quantities[0].along, "p").trend, Trend::Rising);
}

/// y moves by 1.7 near zero, where an absolute tolerance of 2 accepts it whatever share of the value it is; a move by 2.1 it does not accept.
#[test]
fn an_absolute_tolerance_accepts_what_is_small() {
    let changes = |move_by: f64| {
        let (mut study, stored) = study(&P, &[1.0], |p, _| move_by * (p - 1.0) / 9.0);
        study.quantities.get_mut("length").expect("quantities")[0].absolute_tolerance = Some(2.0);
        let a = analyse(&study, &stored);
        let change = along(&a.quantities[0].along, "p").change;
        assert_eq!(change > study.tolerance, a.verdict.contains("changes with key p p"), "{}", a.verdict);
        change / study.tolerance
    };
    assert!((changes(1.7) - 0.85).abs() < 1e-12 && (changes(2.1) - 1.0).abs() < 0.06 && changes(2.1) > 1.0);
}

/// Two keys change y by 1.8 % each and by 3.6 % together: it does not stay within 2 % over all points. Where the absolute tolerance decides, it is the one that is named.
#[test]
fn the_verdict_of_all_points_is_not_that_of_each_axis() {
    let y = |p: f64, q: f64| if p > 1.0 { 1.018 } else { 1.0 } * if q > 1.0 { 1.018 } else { 1.0 };
    let verdict = |absolute: Option<f64>, size: f64| {
        let (mut study, stored) = study(&[1.0, 2.0], &[1.0, 2.0], |p, q| size * y(p, q));
        study.tolerance = 0.02;
        study.quantities.get_mut("length").expect("quantities")[0].absolute_tolerance = absolute;
        let a = analyse(&study, &stored);
        (a.verdict.clone(), a.quantities[0].sentence.clone())
    };
    let (all, each) = verdict(None, 1.0);
    assert!(all.contains("changes by 3.51 %, with no key alone by more than 2 %"), "{all}");
    assert!(each.contains("It hardly depends on key p p: by at most 1.77 %, within 2 %"), "{each}");
    let (all, each) = verdict(Some(0.04), 1.0);
    assert!(all.contains("stays within 0.04 N") && each.contains("by at most 0.0183 N, within 0.04 N"), "{all} {each}");
    assert!(verdict(None, 0.0).0.contains("stays within 2 %"));
}

/// What turns around, what depends on the other axis, what does not move, and a change of sign are told apart.
#[test]
fn trends_are_told_apart() {
    let trend = |y: &dyn Fn(f64, f64) -> f64, name: &str| {
        let (study, stored) = study(&P, &Q, y);
        let a = analyse(&study, &stored);
        let found = along(&a.quantities[0].along, name).clone();
        (found.trend, found.elasticity.is_some())
    };
    assert_eq!(trend(&|p, _| 10.0 - (p - 4.0) * (p - 4.0) / 10.0, "p"), (Trend::Turning, true));
    assert_eq!(trend(&|p, q| 10.0 + p * (q - 2.0), "p").0, Trend::Mixed);
    assert_eq!(trend(&|p, _| p, "q"), (Trend::Constant, false), "no elasticity out of rounding");
    // 1e-7 of the value is less than a solver leaves
    assert_eq!(trend(&|p, q| p + 1e-8 * q, "q").0, Trend::Constant);
    assert_eq!(trend(&|p, _| p - 3.0, "p"), (Trend::Rising, false), "no logarithm of a change of sign");
}

#[test]
fn a_missing_point_is_named_and_the_report_is_written() {
    let (study, mut stored) = study(&P, &Q, |p, q| p / q);
    stored[5].record.status = "StepTooSmall".into();
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    let summary = report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.warnings.iter().any(|w| w.contains("p1_q2: StepTooSmall")), "{:?}", summary.warnings);
    let decided = |along: &str| {
        summary.decisions.as_ref().expect("decisions")[&format!("cable_tension_N, length along {along}")].as_str()
    };
    assert_eq!(["p", "q"].map(decided), ["rising", "falling"]);
    let table = std::fs::read_to_string(dir.path().join("tables/points.csv")).expect("a table");
    assert!(table.starts_with("p [kPa],q [kPa],Control,T [N],Status,"), "{table}");
    for row in ["\n1,1,length,1.000,Converged,", "\n2,4,length,–,StepTooSmall,"] {
        assert!(table.contains(row), "{table}");
    }
    let points = &summary.analysis["cable_tension_N"]["length"]["points"];
    assert_eq!(points.as_array().map(Vec::len), Some(11));
    for file in [
        "figures/against-cable_tension_N-length.svg",
        "figures/map-length.pdf",
        "figures/sweep-length.png",
        "tables/dependence.csv",
        "tables/points.tex",
        "tables/effects.csv",
    ] {
        assert!(dir.path().join(file).is_file(), "{file}");
    }
}

/// Of a part of the points the verdict says so, and names the axis along which there are no two of them, with the quantity where another one is judged there.
#[test]
fn an_axis_without_two_points_is_not_judged() {
    let (mut study, mut stored) = study(&P, &Q, |p, q| p * q);
    let whole = analyse(&study, &stored).verdict;
    assert!(whole.starts_with("Over 12 points the ") && !whole.contains("not judged"), "{whole}");
    stored.retain(|c| c.record.member.starts_with("p1_"));
    let a = analyse(&study, &stored);
    assert!(a.verdict.starts_with("Over 3 of 12 points the "), "{}", a.verdict);
    let says = "Key p p is not judged: no two converged points differ in it alone.";
    assert!(a.verdict.contains(&format!(" {says} 9 cases have no usable result.")), "{}", a.verdict);
    assert!(a.quantities[0].sentence.ends_with(&format!(". {says}")), "{}", a.quantities[0].sentence);

    let (grid, mut stored) = self::study(&P, &Q, |p, q| p * q);
    let other =
        StudyQuantity { name: "other_N".into(), label: "other force".into(), ..grid.quantities["length"][0].clone() };
    study.quantities.get_mut("length").expect("quantities").push(other);
    for case in stored.iter_mut().filter(|c| c.record.member.starts_with("p1_")) {
        let probe = case.record.probes["cable_tension_N"].clone();
        case.record.probes.insert("other_N".into(), probe);
    }
    let said = analyse(&study, &stored).verdict;
    assert!(said.starts_with("Over 3 to 12 of 12 points the "), "{said}");
    assert!(said.contains("Key p p is not judged for the maximum other force (") && !said.contains("Key q"), "{said}");
}

/// A quantity that does not start at zero is judged by its change: its peaks are called so, its curve over time is not.
#[test]
fn peaks_that_are_changes_are_called_so() {
    let drawn = |start: f64| {
        let (study, mut stored) = study(&P, &Q, |p, q| p / q);
        for case in &mut stored {
            let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
            tension.iter_mut().for_each(|value| *value += start);
            case.record.probes.get_mut("cable_tension_N").expect("recorded").peak += start;
        }
        let dir = tempfile::tempdir().expect("temporary folder");
        synthetic::store(dir.path(), &(study, stored));
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        ["against-cable_tension_N-length", "map-length", "sweep-length"].map(|name| {
            let svg = std::fs::read_to_string(dir.path().join(format!("figures/{name}.svg"))).expect("drawn");
            svg.to_lowercase().contains("change of cable tension")
        })
    };
    assert_eq!(drawn(0.0), [false; 3]);
    assert_eq!(drawn(50.0), [true, true, false]);
}

/// Quantities in the same words have columns of their own, called by their names.
#[test]
fn quantities_in_the_same_words_have_columns_of_their_own() {
    let (mut study, mut stored) = study(&P, &Q, |p, q| p * q);
    for case in &mut stored {
        let (mut wave, mut probe) =
            (case.series.columns["cable_tension_N"].clone(), case.record.probes["cable_tension_N"].clone());
        wave.iter_mut().for_each(|value| *value *= 2.0);
        probe.peak *= 2.0;
        case.series.columns.insert("other_N".into(), wave);
        case.record.probes.insert("other_N".into(), probe);
    }
    let quantities = study.quantities.get_mut("length").expect("quantities");
    let other = StudyQuantity { name: "other_N".into(), ..quantities[0].clone() };
    quantities.push(other);
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let table = std::fs::read_to_string(dir.path().join("tables/points.csv")).expect("a table");
    assert!(table.starts_with("p [kPa],q [kPa],Control,cable_tension_N [N],other_N [N],Status,"), "{table}");
    assert!(table.contains("\n1,1,length,1.000,2.000,Converged,"), "{table}");
}

/// Squares without room for numbers have a colour bar from their least to their largest value; those with numbers have none.
#[test]
fn a_map_has_numbers_or_a_colour_bar() {
    let map = |q: &[f64]| {
        let dir = tempfile::tempdir().expect("temporary folder");
        synthetic::store(dir.path(), &study(&[1.0, 2.0], q, |p, q| p * q));
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        std::fs::read_to_string(dir.path().join("figures/map-length.svg")).expect("drawn")
    };
    let (few, many) = (map(&Q), map(&(1..=20).map(f64::from).collect::<Vec<_>>()));
    // 2 N is a number of a square; from 1 N to 40 N the ticks of a bar are tens, and the axis of q ends at 20
    assert!(few.contains("\n2.00\n") && few.matches("<rect").count() <= 2 * Q.len() + 1, "{few}");
    assert!(["\n30\n", "\n40\n"].iter().all(|tick| many.contains(tick)) && !many.contains("\n2.00\n"), "{many}");
    assert!(many.matches("<rect").count() > 3 * 40, "{many}");
}

/// Values that differ by rounding are one: the squares have one colour, that of the middle of their bar, whose ticks are a tenth around it.
#[test]
fn a_map_of_rounding_has_one_colour() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let q: Vec<f64> = (1..=20).map(f64::from).collect();
    synthetic::store(dir.path(), &study(&[1.0, 2.0], &q, |p, q| 100.0 * (1.0 + 2.0 * f64::EPSILON * (p + q))));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let map = std::fs::read_to_string(dir.path().join("figures/map-length.svg")).expect("drawn");
    assert!(["\n90\n", "\n100\n", "\n110\n"].iter().all(|tick| map.contains(tick)), "{map}");
}

/// The panel of a quantity against the axes, and the page.
fn against(study: &(StudyRecord, Vec<StoredCase>)) -> [String; 2] {
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), study);
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    ["figures/against-cable_tension_N-length.svg", "index.html"]
        .map(|file| std::fs::read_to_string(dir.path().join(file)).expect("written"))
}

/// A legend ends with its panel, and the caption says how many of the values it names: here 10 of 20 of q, and both of p.
#[test]
fn a_legend_of_many_values_names_some() {
    let values: Vec<f64> = (1..=20).map(f64::from).collect();
    let [svg, page] = against(&study(&[1.0, 2.0], &values, |p, q| p * q));
    assert_eq!(svg.matches("</tspan> = ").count(), 10 + 2, "{svg}");
    assert!(page.contains(" Of 20 values of key q q the legend names 10."), "{page}");
    let [_, page] = against(&study(&[1.0, 2.0], &Q, |p, q| p * q));
    assert!(!page.contains("the legend names"), "{page}");
}

/// No line joins a minimum and a maximum. Of y = p − 3 the first line along p would; that of y = p has four points.
#[test]
fn no_line_joins_a_minimum_and_a_maximum() {
    let drawn = |y: fn(f64, f64) -> f64| {
        let [svg, page] = against(&study(&P, &Q, y));
        let points = |l: &str| Some(l.split_once("points=\"")?.1.split('"').next()?.split_whitespace().count());
        let lines = svg.split("<polyline ").filter(|l| l.contains("stroke-width=\"8\""));
        (
            lines.filter(|l| points(l) == Some(P.len())).count(),
            page.contains(" Hollow marks are minima and full ones maxima"),
        )
    };
    assert_eq!(drawn(|p, _| p), (1, false));
    assert_eq!(drawn(|p, _| p - 3.0), (0, true));
}

/// A grid over p, q and r with the peak p q r, whose third axis has a long unit.
fn three_axes() -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, layer) = study(&[1.0, 2.0], &Q, |p, q| p * q);
    let mut sweep = sweep_of(&study);
    let (points, mut stored) = (std::mem::take(&mut sweep.points), vec![]);
    let r = [0.535, 1.07, 2.14];
    for (k, factor) in r.into_iter().enumerate() {
        for mut case in layer.clone() {
            let at = [points[&case.record.member].clone(), vec![k]].concat();
            case.record.member += &format!("_r{k}");
            case.record.id += &format!("_r{k}");
            case.record.probes.get_mut("cable_tension_N").expect("recorded").peak *= factor;
            let tension = case.series.columns.get_mut("cable_tension_N").expect("recorded");
            tension.iter_mut().for_each(|value| *value *= factor);
            sweep.points.insert(case.record.member.clone(), at);
            stored.push(case);
        }
    }
    let values = r.iter().map(|r| format!("{r} g/cm^3")).collect();
    sweep.axes.push(AxisRecord { unit: "g/cm^3".into(), values, ..axis("r", &r) });
    study.families[0].cases = stored.iter().map(|c| c.record.id.clone()).collect();
    study.details = serde_json::to_value(sweep).expect("numbers and strings");
    (study, stored)
}

/// Every axis of a grid has a panel with a curve for each value of the next one, named in full, and the caption says where each panel keeps the third; an axis
/// along which nothing is judged has none, and is kept where the points are.
#[test]
fn each_axis_has_a_panel() {
    let (study, stored) = three_axes();
    let drawn = |stored: Vec<StoredCase>| {
        let dir = tempfile::tempdir().expect("temporary folder");
        synthetic::store(dir.path(), &(study.clone(), stored));
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        ["figures/against-cable_tension_N-length.svg", "index.html"]
            .map(|file| std::fs::read_to_string(dir.path().join(file)).expect("written"))
    };
    let [svg, page] = drawn(stored.clone());
    assert!(["key p", "key q", "key r", "(c)"].iter().all(|words| svg.contains(words)), "one panel for each axis");
    assert!(svg.contains(" = 0.535 g/cm³") && !svg.contains('…'), "whole legends");
    let kept = "Further axes are kept in (a) at r = 1.07 g/cm³, in (b) at p = 2 kPa, in (c) at q = 3 kPa.";
    assert!(page.contains(kept), "{page}");
    let [svg, page] = drawn(stored.into_iter().filter(|c| c.record.member.ends_with("_r0")).collect());
    assert!(svg.contains("key p") && svg.contains("key q") && !svg.contains("key r"), "two panels");
    let kept = "Further axes are kept in (a) at r = 0.535 g/cm³, in (b) at r = 0.535 g/cm³.";
    assert!(page.contains(kept), "{page}");
    assert!(page.contains("coloured by key p, with q = 3 kPa and r = 0.535 g/cm³."), "{page}");
}

#[test]
fn rows_that_are_left_out_change_no_peak() {
    let (study, stored) = study(&P, &Q, |p, q| p / q);
    for start in [0.0, 50.0] {
        let mut case = stored[0].clone();
        let rows: Vec<f64> = [0.0, 1.0, 30.0, 1.0, 2.0].map(|v| start + v).into();
        case.series.t_s = vec![0.0, 0.1, 0.2, 0.3, 0.4];
        case.series.columns.insert("cable_tension_N".into(), rows);
        case.record.probes.get_mut("cable_tension_N").expect("recorded").peak = start + 30.0;
        let of_all = (peak(&case, "cable_tension_N"), peak_words([&case], "cable_tension_N"));
        assert_eq!(of_all.0, Some(30.0));
        assert_eq!(missed_extremes(&study, std::slice::from_ref(&case)), [""; 0]);
        case.series.t_s = vec![0.0, 0.4];
        case.series.columns.insert("cable_tension_N".into(), vec![start, start + 2.0]);
        assert_eq!((peak(&case, "cable_tension_N"), peak_words([&case], "cable_tension_N")), of_all);
        let said = missed_extremes(&study, &[case]);
        let miss = "the written rows of 1 of 1 case miss the extreme, by up to 93 %";
        assert!(said.len() == 1 && said[0].contains(miss), "{said:?}");
    }
}

/// Words and lists have no order in which anything could rise, and what is constant on one line is not said of all.
#[test]
fn a_trend_is_said_of_what_has_one() {
    let (mut study, stored) = study(&[1.0, 2.0], &[0.0, 1.0], |p, q| 1.0 + p * q);
    let a = analyse(&study, &stored);
    let said = &a.quantities[0].sentence;
    assert!(said.contains("rises with key p p for some values of the others (it is constant for the rest)"), "{said}");
    assert!(said.contains("rises with key q q, whatever the others are"), "{said}");
    let mut sweep = sweep_of(&study);
    (sweep.axes[0].values, sweep.axes[0].numbers) = (vec!["tet4".into(), "tet10".into()], vec![]);
    study.details = serde_json::to_value(sweep).expect("numbers and strings");
    let a = analyse(&study, &stored);
    assert_eq!(a.quantities[0].along[0].trend, Trend::Unordered);
    assert!(a.quantities[0].sentence.contains("It differs between the values of key p p, by"), "{:?}", a.quantities);
}

/// As many cells of another element, or of a longer body, are another mesh.
#[test]
fn one_mesh_is_one_mesh() {
    let (study, mut stored) = study(&[1.0, 2.0], &[1.0, 2.0], |p, q| p * q);
    let says_so = |stored: &[StoredCase]| analyse(&study, stored).warnings.iter().any(|w| w.contains("share one mesh"));
    assert!(says_so(&stored));
    stored[0].record.formulation = "tet10".into();
    assert!(!says_so(&stored));
    stored[0].record.formulation = stored[1].record.formulation.clone();
    stored[1].record.mesh.h_m *= 1.1;
    assert!(!says_so(&stored));
}

/// A study of the small scene of the command line's tests.
fn written(text: &str) -> (tempfile::TempDir, Result<Study, String>) {
    let dir = tempfile::tempdir().expect("temporary folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/scene.toml");
    let head = format!(
        "question = \"?\"\nexpectation = \"!\"\nscene = {:?}\ntolerance = \"2 %\"\n{text}\n[[variant]]\nname = \"length\"\nquantity = [{{ name = \"bending_angle_deg\", label = \"bending angle\", symbol = \"θ\", unit = \"°\" }}, {{ name = \"cable_tension_N\", label = \"cable tension\", symbol = \"T\", unit = \"N\" }}]\n",
        scene.display().to_string()
    );
    let file = dir.path().join("study.toml");
    std::fs::write(&file, head).expect("temporary file");
    let study = Study::read(&file, &[]).map_err(|e| e.to_string());
    (dir, study)
}

const E: &str = "[[axis]]\nname = \"E\"\nkeys = [\"laws.rubber.E\"]\nlabel = \"Young's modulus\"\nsymbol = \"E\"\nunit = \"kPa\"\nvalues = [\"50 kPa\", \"0.1 MPa\"]\n";
const NU: &str = "[[axis]]\nname = \"nu\"\nkeys = [\"laws.rubber.nu\"]\nlabel = \"Poisson's ratio\"\nsymbol = \"ν\"\nvalues = [0.2, 0.3]\n";

#[test]
fn a_grid_combines_and_a_list_goes_along() {
    let (_keep, study) = written(&format!("kind = \"sweep\"\n{E}{NU}"));
    let study = study.expect("a grid");
    let members: Vec<&str> = study.cases.iter().map(|c| c.member.as_str()).collect();
    assert_eq!(members, ["E50kPa_nu0.2", "E50kPa_nu0.3", "E0.1MPa_nu0.2", "E0.1MPa_nu0.3"]);
    assert_eq!(sweep_of(&study.record).axes[0].numbers, [50.0, 100.0]);
    assert_eq!(sweep_of(&study.record).points["E0.1MPa_nu0.2"], [1, 0]);
    assert!(study.cases[2].text.contains("E = \"0.1 MPa\"") && study.cases[2].text.contains("nu = 0.2"));
    let (_keep, study) = written(&format!("kind = \"sweep\"\ncombine = \"list\"\n{E}{NU}"));
    let members: Vec<String> = study.expect("a list").cases.into_iter().map(|c| c.member).collect();
    assert_eq!(members, ["E50kPa_nu0.2", "E0.1MPa_nu0.3"]);
}

/// Points of a design, with values that occur again, are a list and no grid, and no trend is said of them.
#[test]
fn a_list_takes_values_in_any_order() {
    let design = |combine: &str, nu: &str| {
        let e = E.replace("\"50 kPa\", \"0.1 MPa\"", "\"50 kPa\", \"0.1 MPa\", \"50 kPa\"");
        let nu = NU.replace("[0.2, 0.3]", nu);
        written(&format!("kind = \"sweep\"\ncombine = \"{combine}\"\n{e}{nu}")).1
    };
    let members: Vec<String> =
        design("list", "[0.2, 0.2, 0.1]").expect("a list").cases.into_iter().map(|c| c.member).collect();
    assert_eq!(members, ["E50kPa_nu0.2", "E0.1MPa_nu0.2", "E50kPa_nu0.1"]);
    let refused = |combine, nu| design(combine, nu).expect_err("a refusal");
    assert!(refused("grid", "[0.1, 0.2, 0.3]").contains("axis E: the value 50 kPa is given twice"));
    let twice = refused("list", "[0.2, 0.2, 0.2]");
    assert!(twice.contains("two points are called E50kPa_nu0.2 in file names; remove one"), "{twice}");

    let (mut study, stored) = study(&[2.0, 1.0, 3.0], &[1.0], |p, _| p);
    let mut sweep = sweep_of(&study);
    sweep.axes[1] = axis("q", &[5.0, 5.0, 4.0]);
    sweep.points.values_mut().for_each(|at| *at = vec![at[0]; 2]);
    study.details = serde_json::to_value(sweep).expect("numbers and strings");
    let a = analyse(&study, &stored);
    assert_eq!((a.list, a.quantities[0].along[0].trend), (true, Trend::Unordered));
    let said = &a.quantities[0].sentence;
    assert!(said.contains("It differs between the points of the list, by 67 %."), "{said}");
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let drawn = std::fs::read_to_string(dir.path().join("figures/against-cable_tension_N-length.svg")).expect("drawn");
    assert!(["key p", "key q"].iter().all(|axis| drawn.contains(axis)), "one panel for each axis");
}

/// What a list does along its first key is not attributed to that one alone: the axis, the legend and the captions name the keys that go along, and none that stays.
#[test]
fn figures_of_a_list_name_all_its_keys() {
    let (mut study, stored) = study(&[1.0, 2.0, 3.0], &[1.0], |p, _| p);
    let mut sweep = sweep_of(&study);
    sweep.axes[1] = axis("q", &[5.0, 4.5, 4.0]);
    sweep.axes.push(axis("r", &[7.0, 7.0, 7.0]));
    sweep.points.values_mut().for_each(|at| *at = vec![at[0]; 3]);
    study.details = serde_json::to_value(sweep).expect("numbers and strings");
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study, stored));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    let [against, over_time, page] =
        ["figures/against-cable_tension_N-length.svg", "figures/sweep-length.svg", "index.html"]
            .map(|file| std::fs::read_to_string(dir.path().join(file)).expect("written"));
    assert!(against.contains(" (with ") && !against.contains("7 kPa"), "{against}");
    assert!(
        ["5 kPa", "4.5 kPa", "4 kPa"].iter().all(|value| over_time.contains(&format!(" = {value}"))),
        "{over_time}"
    );
    for named in ["against key p p", "coloured by key p"] {
        assert!(page.contains(&format!("{named}, along which key q q goes from 5 kPa to 4 kPa too.")), "{page}");
    }
}

/// Values that are files of curves are words: their dots begin no ending in the names of the files of a case.
#[test]
fn an_axis_of_files_has_cases() {
    let files = "[[axis]]\nname = \"curve\"\nkeys = [\"title\"]\nlabel = \"curve\"\nsymbol = \"c\"\nvalues = [\"low.csv\", \"high.csv\"]\n";
    let (_keep, study) = written(&format!("kind = \"sweep\"\n{files}"));
    let members: Vec<String> = study.expect("a sweep").cases.into_iter().map(|c| c.member).collect();
    assert_eq!(members, ["curvelow-csv", "curvehigh-csv"]);
    // A digit, a sign or a point at their beginning makes them no numbers
    let words = files.replace("low.csv", "1-slow.csv").replace("high.csv", "./2-fast.csv");
    let (_keep, study) = written(&format!("kind = \"sweep\"\n{words}"));
    let members: Vec<String> = study.expect("a sweep").cases.into_iter().map(|c| c.member).collect();
    assert_eq!(members, ["curve1-slow-csv", "curve--2-fast-csv"]);
}

#[test]
fn mistakes_in_axes_are_named() {
    let refused = |text: &str| written(text).1.err().unwrap_or_else(|| panic!("{text} must be refused"));
    let family = "[[family]]\nname = \"f\"\nrole = \"cumulative\"\n[family.members]\na = {}\n";
    let radius = |name: &str, cable: &str| {
        let keys = format!("constraint.{cable}.guide_radius");
        let axis = E.replace("laws.rubber.E", &keys).replace("\"E\"", &format!("\"{name}\"")).replace("kPa", "mm");
        axis.replace("50 mm", "2 mm").replace("0.1 MPa", "3 mm")
    };
    let variant = |set: &str| {
        let quantity = "{ name = \"bending_angle_deg\", label = \"angle\", symbol = \"θ\", unit = \"°\" }";
        format!("[[variant]]\nname = \"other\"\nset = {{ {set} }}\nquantity = [{quantity}]\n")
    };
    // A whole law that a variant gives keeps what the axis does not change
    let law = variant("laws.rubber = { law = \"neo_hookean\", E = \"9 kPa\", nu = 0.1 }");
    written(&format!("kind = \"sweep\"\n{E}{law}")).1.expect("a variant with another law");
    written(&format!("kind = \"sweep\"\n{}", radius("r", "cable"))).1.expect("an axis of radii");
    for (text, words) in [
        ("kind = \"sweep\"".to_string(), "study: the sweep has no axis; add an [[axis]]"),
        (format!("kind = \"sweep\"\n{E}{family}"), "unknown key `family`"),
        (format!("kind = \"comparison\"\n{NU}{family}"), "unknown key `axis`"),
        (format!("kind = \"sweep\"\n{E}{E}"), "axis 2: another one is called \"E\" too"),
        (format!("kind = \"sweep\"\n{}", E.replace("0.1 MPa", "2 mm")), "axis E: \"2 mm\" has the wrong dimension"),
        (format!("kind = \"sweep\"\n{}", E.replace("0.1 MPa", "0.1 MPaa")), "axis E: \"0.1 MPaa\": unknown unit"),
        (
            format!("kind = \"sweep\"\n{}", NU.replace("0.3]", "\"3-fast.csv\"]")),
            "axis nu: \"3-fast.csv\": unknown unit",
        ),
        (format!("kind = \"sweep\"\n{}", NU.replace("[0.2, 0.3]", "[0.2]")), "axis nu: it has 1 value; give at least"),
        (format!("kind = \"sweep\"\n{}", NU.replace("0.3]", "0.2]")), "axis nu: the value 0.2 is given twice"),
        (format!("kind = \"sweep\"\n{}", NU.replace("0.3]", "0.3, 0.1]")), "axis nu: the values neither rise nor fall"),
        (format!("kind = \"sweep\"\n{}", NU.replace("[\"laws.rubber.nu\"]", "[]")), "axis nu: it changes no key"),
        (
            format!("kind = \"sweep\"\n{}", NU.replace("\"ν\"", "\"\"")),
            "axis nu: its symbol is empty; give it a letter",
        ),
        (format!("kind = \"sweep\"\n{}", NU.replace("rubber.nu", "ruber.nu")), "there is no \"ruber\"; did you mean"),
        (
            format!("kind = \"sweep\"\ncombine = \"list\"\n{E}{}", NU.replace("0.3]", "0.3, 0.4]")),
            "axis nu: it has 3 values and the first axis 2; in a list",
        ),
        (
            format!("kind = \"comparison\"\n{family}{}", family.replace("\"f\"", "\"g\"")),
            "variant length: two families are run in it; a variant has one cumulative family",
        ),
        (format!("kind = \"sweep\"\nreference = \"a\"\n{E}"), "unknown key `reference`"),
        (
            format!("kind = \"sweep\"\n{E}{}", E.replace("name = \"E\"", "name = \"F\"")),
            "axis F: its key laws.rubber.E takes the place of laws.rubber.E, which axis E sets; leave one of them out",
        ),
        (
            format!("kind = \"sweep\"\ncombine = \"list\"\n{}{}", radius("r", "cable"), radius("s", "1")),
            "axis s: its key constraint.1.guide_radius takes the place of constraint.cable.guide_radius, which axis r sets",
        ),
        (
            format!("kind = \"sweep\"\n{E}{}", variant("laws.rubber.E = \"9 kPa\"")),
            "axis E: its key laws.rubber.E takes the place of laws.rubber.E, which variant other sets",
        ),
        ("kind = \"sweep\"\naxis = [[\"E\", [\"laws.rubber.E\"]]]".into(), "array; this must be a table"),
    ] {
        let said = refused(&text);
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// A study is refused by its number of cases before any of them is made, of a grid, of a list and of several variants: 990 000 took minutes and gigabytes.
#[test]
fn too_many_cases_are_refused_by_their_number() {
    let axis = |name: &str, key: &str, n: usize| {
        let values: Vec<String> = (0..n).map(|k| format!("{}", 0.1 + 1e-7 * k as f64)).collect();
        let values = values.join(", ");
        format!("[[axis]]\nname = \"{name}\"\nkeys = [\"{key}\"]\nlabel = \"l\"\nsymbol = \"s\"\nvalues = [{values}]\n")
    };
    let grid = |n: [usize; 2]| axis("nu", "laws.rubber.nu", n[0]) + &axis("mu", "laws.rubber.mu", n[1]);
    let other = "[[variant]]\nname = \"other\"\nquantity = [{ name = \"bending_angle_deg\", label = \"angle\", symbol = \"θ\", unit = \"°\" }]\n";
    let points = "or divide the study: at most 20000 points are run";
    for (text, fact, remedy) in [
        (grid([1000, 990]), "axis: the axes make 990000 points; take fewer values", points),
        (format!("combine = \"list\"\n{}", grid([20_001; 2])), "axis: the axes make 20001 points", points),
        (
            format!("{}{other}", grid([150, 100])),
            "study: its variants and families make 30000 cases",
            "it has at most 20000 cases",
        ),
    ] {
        let said = written(&format!("kind = \"sweep\"\n{text}")).1.expect_err("too many cases");
        assert!(said.contains(fact) && said.contains(remedy), "{said}");
    }
}

/// Under length control without other loads the angle of a homogeneous body does not depend on E, and the tension is
/// proportional to it: an elasticity of 1, at the residual of Newton's method (1e-8) over ln 2.
#[test]
fn a_sweep_runs_from_end_to_end() {
    let (dir, study) = written(&format!("kind = \"sweep\"\n{E}"));
    study.expect("a sweep");
    let out = dir.path().join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_durometer"))
        .args(["run", "--json", "--out"])
        .args([&out, &dir.path().join("study.toml")])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let tension = &summary["analysis"]["cable_tension_N"]["length"]["along"][0];
    let e = tension["elasticity"][2].as_f64().expect("a number");
    assert!((e - 1.0).abs() < 1e-6, "{e}");
    let angle = &summary["analysis"]["bending_angle_deg"]["length"]["along"][0];
    assert_eq!(angle["trend"], "constant", "{angle}");
    assert!(out.join("index.html").is_file());
}

/// The changes of a cumulative family add up; two members of known times have known costs.
#[test]
fn a_cumulative_family_adds_up() {
    let gravity = "{ kind = \"gravity\", region = \"body\", density = \"1 g/cm^3\", direction = [0, 0, -1], acceleration = \"1 m/s^2\" }";
    let (_keep, study) = written(&format!(
        "kind = \"comparison\"\n[[family]]\nname = \"f\"\nrole = \"cumulative\"\n[family.members]\na = {{}}\nb = {{ \"effect.+\" = {gravity} }}\nc = {{ \"numerics.cuts\" = 3 }}\n"
    ));
    let study = study.expect("a cumulative family");
    let effects: Vec<usize> = study.cases.iter().map(|c| c.spec.effects.len()).collect();
    assert_eq!(effects, [1, 2, 2], "a member keeps what the one before has added");
    let (_, cases) = synthetic::study();
    let timed = |k: usize, seconds: f64, effects: &[(&str, f64)]| {
        let mut c = cases[0].clone();
        c.record.id.clone_from(&study.cases[k].id);
        (c.record.variant, c.record.member) = ("length".into(), study.cases[k].member.clone());
        (c.record.status, c.record.cpu_s, c.record.steps) = ("Converged".into(), seconds, 10);
        // Twice as long by the clock, with as much of it in every part
        c.record.wall_s = 2.0 * seconds;
        c.record.shared = false;
        let record = |(name, s): &(&str, f64)| EffectRecord { name: name.to_string(), role: None, wall_s: 2.0 * s };
        c.record.effects = effects.iter().map(record).collect();
        c
    };
    let stored = [timed(0, 1.0, &[("elastic", 0.5)]), timed(1, 1.4, &[("elastic", 0.6), ("gravity", 0.1)])];
    let a = comparison::analysis::analyse(&study.record, &Default::default(), &stored);
    let added = &a.sequences[0].additions;
    assert_eq!(added.len(), 2, "{added:?}");
    assert_eq!(added[1].new, ["gravity"]);
    assert!(
        (added[1].step_s - 0.14).abs() < 1e-15 && (added[1].added_s.expect("a member before") - 0.04).abs() < 1e-15
    );
    assert!((added[1].new_evaluation_s() - 0.01).abs() < 1e-15);
    assert!(a.warnings.iter().any(|w| w.contains("f-length-c: has no result")), "{:?}", a.warnings);
    assert!(a.verdict.starts_with("With all up to b (no result with c), length, a step takes"), "{}", a.verdict);
    assert!(a.sequences[0].sentence.ends_with("; no result with c."), "{}", a.sequences[0].sentence);
    // Two members before are two additions in one
    let last = timed(2, 1.9, &[("elastic", 0.6), ("gravity", 0.1), ("cable", 0.2)]);
    let gap = comparison::analysis::analyse(&study.record, &Default::default(), &[stored[0].clone(), last.clone()]);
    let sentence = &gap.sequences[0].sentence;
    assert!(sentence.contains("c with b +90 ms") && sentence.ends_with("; no result with b."), "{sentence}");
    assert!(gap.verdict.starts_with("With everything declared (no result with b), length"), "{}", gap.verdict);
    let whole = [&stored[..], &[last]].concat();
    let whole = comparison::analysis::analyse(&study.record, &Default::default(), &whole);
    assert!(whole.verdict.starts_with("With everything declared, length, a step takes"), "{}", whole.verdict);
    let dir = tempfile::tempdir().expect("temporary folder");
    synthetic::store(dir.path(), &(study.record.clone(), stored.to_vec()));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    for file in
        ["figures/sequence-length.pdf", "tables/sequence-costs.csv", "tables/evaluations.csv", "tables/answers.csv"]
    {
        assert!(dir.path().join(file).is_file(), "{file}");
    }
}

/// y = p − 3 is a minimum at six of twelve points: the report says that unlike extremes are compared, unless the ends are, or all are maxima.
#[test]
fn peaks_of_both_signs_are_named() {
    let opposite = |y: fn(f64, f64) -> f64, judged: &str| {
        let (mut study, stored) = study(&P, &Q, y);
        study.details["judged"] = judged.into();
        let found = analyse(&study, &stored).warnings;
        found.into_iter().find(|w| w.contains("is a minimum in 6 and a maximum in 6 of the points"))
    };
    let found = opposite(|p, _| p - 3.0, "peak").expect("a warning");
    assert!(found.starts_with("The peak of cable tension"), "{found}");
    assert_eq!([opposite(|p, _| p - 3.0, "final"), opposite(|p, _| p, "peak")], [None, None]);
}

/// y turns back before the end, by a half: the peaks are twice the final values, and the words say which is meant.
#[test]
fn a_sweep_can_judge_the_end() {
    let (mut study, mut stored) = study(&P, &Q, |p, q| 2.0 * p * q);
    for c in &mut stored {
        let probe = c.record.probes.get_mut("cable_tension_N").expect("probe");
        probe.last = 0.5 * probe.peak;
    }
    let peaks = analyse(&study, &stored);
    study.details["judged"] = "final".into();
    let ends = analyse(&study, &stored);
    for (peak, end) in peaks.quantities[0].points.iter().zip(&ends.quantities[0].points) {
        assert!((peak.value, 0.5 * peak.value) == (2.0 * end.value, end.value), "{peak:?} {end:?}");
    }
    assert!(ends.quantities[0].sentence.starts_with("Final cable tension"), "{}", ends.quantities[0].sentence);
    assert!(ends.verdict.contains("the final cable tension") && !peaks.verdict.contains("final"), "{}", ends.verdict);
}
