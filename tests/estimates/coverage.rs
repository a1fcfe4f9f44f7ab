//! Coverage studies: what is counted, and a small part of the shipped study.

use crate::common::studies::run_study;
use durometer::scene::ExtremeKind;
use durometer::study::expand::Study;
use durometer::study::kind::StudyScope;
use durometer::study::kinds::coverage::analysis::{CoverageFindings, analyse};
use durometer::study::kinds::coverage::mark::{Estimator, Standing};
use durometer::study::kinds::coverage::record::{CoverageRecord, JudgedFamily, ProblemRecord};
use durometer::study::kinds::coverage::share::Share;
use durometer::study::run::one_run::{OneRunError, OneRunRecord};
use durometer::study::store::record::*;
use durometer::study::store::results;
use std::collections::BTreeMap;
use std::path::Path;

const TRUTH: f64 = 2.0;

/// A case of n cells along an edge with this value, and the bar of its own run where it has one.
fn case(family: &str, formulation: &str, n: usize, value: f64, bar: Option<f64>) -> StoredCase {
    let errors = bar.map(|bar| OneRunRecord {
        quantities: BTreeMap::from([(
            "F_N".into(),
            OneRunError { correction: 0.8 * bar, uncertainty: 0.2 * bar, bar, ..OneRunError::default() },
        )]),
        ..OneRunRecord::default()
    });
    let record = CaseRecord {
        id: format!("{family}-nu-n{n}"),
        family: family.into(),
        variant: "nu".into(),
        formulation: formulation.into(),
        status: "Converged".into(),
        mesh: MeshRecord { cells: n * n * n, h_m: 1.0 / n as f64, source: family.into(), ..MeshRecord::default() },
        probes: BTreeMap::from([(
            "F_N".into(),
            ProbeRecord {
                peak: value,
                peak_is: ExtremeKind::Maximum,
                peak_t_s: 1.0,
                last: value,
                opposite: None,
                motion: None,
            },
        )]),
        one_run: errors,
        ..CaseRecord::default()
    };
    StoredCase::new(record, Series::default())
}

struct Made {
    study: StudyRecord,
    coverage: CoverageRecord,
    cases: Vec<StoredCase>,
}

/// One problem: a family of tet4 with f = 2 + h², whose own bars are `bars` times the error, and two families of the truth that are
/// `apart`.
fn made(bars: [f64; 3], apart: f64, curved: bool) -> Made {
    let quantity = StudyQuantity { name: "F_N".into(), ..StudyQuantity::default() };
    let mut cases = vec![];
    for (n, bar) in [2, 3, 4].into_iter().zip(bars) {
        let error = 1.0 / (n * n) as f64;
        cases.push(case("judged", "tet4", n, TRUTH + error, Some(bar * error)));
    }
    for (family, formulation, shift) in [("one", "tet10", 0.0), ("two", "tet10_up", apart)] {
        for n in [8_usize, 12, 16] {
            let value = TRUTH + shift + 0.1 * (n as f64).powi(-4);
            cases.push(case(family, formulation, n, value, None));
        }
    }
    let family = |name: &str, role: Role, formulation: &str| FamilyRecord {
        name: name.into(),
        role,
        formulation: formulation.into(),
        cases: cases.iter().filter(|c| c.record.family == name).map(|c| c.record.id.clone()).collect(),
        members: vec![],
    };
    let study = StudyRecord {
        schema: 0,
        study: "made".into(),
        kind: "coverage".into(),
        question: String::new(),
        expectation: String::new(),
        tolerance: 0.05,
        quantities: BTreeMap::new(),
        groups: BTreeMap::new(),
        members: BTreeMap::new(),
        variants: vec!["nu".into()],
        labels: BTreeMap::new(),
        families: vec![
            family("judged", Role::Sizes, "tet4"),
            family("one", Role::Reference, "tet10"),
            family("two", Role::Reference, "tet10_up"),
        ],
        details: serde_json::Value::Null,
        version: String::new(),
        asks: None,
        inputs_sha256: BTreeMap::new(),
        overridden: vec![],
    };
    let problem = ProblemRecord {
        name: "made".into(),
        body: "block".into(),
        curved,
        quantities: vec![quantity],
        judged: vec![JudgedFamily { family: "judged".into(), seed: "a".into() }],
        truths: vec!["one".into(), "two".into()],
        ..ProblemRecord::default()
    };
    Made { study, coverage: CoverageRecord { problems: vec![problem] }, cases }
}

fn found(made: &Made) -> CoverageFindings {
    analyse(&made.study, &made.coverage, &made.cases).found
}

/// Of three bars one is too small. Many runs extrapolate h² exactly, so that U(f*) is the change by extrapolation.
#[test]
fn a_bar_counts_where_it_contains_the_truth() {
    let a = found(&made([2.0, 0.9, 1.5], 0.0, false));
    let one = a.whole(Estimator::OneRun).expect("three bars");
    assert_eq!((one.bars, one.hold, a.problems), (3, 2, 1));
    // The truth is 2 to 1e-7; the middle one of the ratios
    assert!((one.median_ratio - 1.5).abs() < 1e-4, "{}", one.median_ratio);
    let many = a.whole(Estimator::ManyRuns).expect("one family");
    assert_eq!((many.bars, many.hold, many.intervals_hold), (1, 1, 1));
    assert!(!a.passes());
    let near: Vec<usize> = a.effectivities.iter().map(|e| e.near).collect();
    // Corrections of 1.6, 0.72 and 1.2 of the error, in the wrong direction
    assert!(a.effectivities.iter().all(|e| e.bars == 3) && near.iter().all(|n| *n == 0), "{:?}", a.effectivities);
}

/// Families with a region whose border runs through cells know no truth.
#[test]
fn a_border_through_cells_leaves_the_truth_unknown() {
    let mut made = made([2.0, 0.9, 1.5], 0.0, false);
    let is_truth = |c: &&mut StoredCase| c.record.family != "judged";
    made.cases.iter_mut().filter(is_truth).for_each(|c| c.record.cut_regions = vec!["clamp".into()]);
    let a = found(&made);
    assert!(a.truths.is_empty() && a.marks.is_empty() && a.problems == 0, "{:?}", a.truths);
}

/// Bars of less than ten times the distance of the two families of the truth are left out, and their number is told.
#[test]
fn a_bar_does_not_count_where_the_truth_is_uncertain() {
    let made = made([2.0, 2.0, 2.0], 0.015, false);
    let a = analyse(&made.study, &made.coverage, &made.cases);
    // Bars 0.5, 0.22 and 0.125
    assert_eq!(a.count(Estimator::OneRun, Standing::TruthUncertain), 1);
    assert_eq!(a.whole(Estimator::OneRun).map(|s| s.bars), Some(2));
    // The bar of the family, 1/16 + 1/16, too
    assert_eq!(a.count(Estimator::ManyRuns, Standing::TruthUncertain), 1);
    let many = "No verdict: no bar from many runs counts: 1 of truths that are not known to a tenth of them.";
    let one = " Over 1 problem, from one run 2 of 2 bars contain the truth (100 %,";
    assert!(a.verdict.starts_with(&format!("{many}{one}")), "{}", a.verdict);
}

/// The verdict says why an estimator has no bar that counts, and what holds of the other one. Only without a truth it says that there is none.
#[test]
fn a_verdict_gives_the_reason_and_what_is_known() {
    let mut made = made([2.0, 2.0, 2.0], 0.0, false);
    let verdict = |made: &Made| analyse(&made.study, &made.coverage, &made.cases).verdict;
    let alarm = LockingRecord { pressure_scatter: 2.0, volumetric_share: 0.5, alarm: true };
    for case in made.cases.iter_mut().filter(|c| c.record.family == "judged") {
        case.record.locking = Some(alarm);
    }
    let locked = verdict(&made);
    let why = "No verdict: no bar from many runs counts: 1 of families that are refused, since they diverge, lock,";
    assert!(locked.starts_with(why) && locked.contains("from one run 3 of 3 bars contain the truth"), "{locked}");
    made.cases.retain(|c| c.record.family != "judged");
    let none =
        "No verdict: there is no bar from one run; there is no bar from many runs. 3 cases have no usable result.";
    assert_eq!(verdict(&made), none);
    made.cases.clear();
    assert!(verdict(&made).starts_with("No verdict: no problem has two families of its truth"), "{}", verdict(&made));
}

/// Problems that took no part in the choice of the bounds are counted with the others and apart.
#[test]
fn fresh_problems_are_counted_apart() {
    let mut made = made([0.5, 2.0, 2.0], 0.0, true);
    let group = |a: &CoverageFindings, group: &str| {
        let own = |s: &&Share| s.estimator == Estimator::OneRun && s.by == "problem" && s.group == group;
        a.shares.iter().find(own).map(|s| (s.bars, s.hold))
    };
    let known = found(&made);
    assert_eq!((group(&known, "fresh"), group(&known, "bounds were chosen on it")), (None, Some((3, 2))));
    made.coverage.problems[0].fresh = true;
    let a = analyse(&made.study, &made.coverage, &made.cases);
    assert_eq!(group(&a.found, "fresh"), Some((3, 2)));
    assert!(a.verdict.contains("took no part in the choice of the bounds, 2 of 3 and 1 of 1 bars do"), "{}", a.verdict);
}

/// A mesh that two seeds have in common counts once.
#[test]
fn the_same_mesh_counts_once() {
    let mut made = made([2.0, 2.0, 2.0], 0.0, false);
    let again: Vec<StoredCase> = (made.cases.iter().filter(|c| c.record.family == "judged"))
        .map(|c| {
            let mut c = c.clone();
            c.record.id = c.record.id.replace("judged", "again");
            c.record.family = "again".into();
            if c.record.mesh.cells > 8 {
                c.record.mesh.mean_quality = 0.9;
            }
            c
        })
        .collect();
    let ids = again.iter().map(|c| c.record.id.clone()).collect();
    let family = FamilyRecord { name: "again".into(), cases: ids, ..made.study.families[0].clone() };
    made.study.families.push(family);
    made.cases.extend(again);
    made.coverage.problems[0].judged.push(JudgedFamily { family: "again".into(), seed: "b".into() });
    let a = found(&made);
    assert_eq!(a.whole(Estimator::OneRun).map(|s| s.bars), Some(5));
}

/// A study that cannot know its truths, or lacks a series of sizes, is refused with the place and the remedy.
#[test]
fn what_cannot_be_judged_is_refused() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/coverage");
    let text = std::fs::read_to_string(root.join("study.toml")).expect("the shipped study");
    let refusal = |old: &str, new: &str| {
        assert!(text.contains(old), "{old}");
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("study.toml");
        let scenes = root.join("scenes").display().to_string();
        std::fs::write(&file, text.replace("scenes/", &format!("{scenes}/")).replacen(old, new, 1)).expect("writable");
        Study::read(&file, &[]).expect_err("a refusal").to_string()
    };
    let one = refusal("[[truth]]\nname = \"tet10\"", "[[seed]]\nname = \"c\"");
    assert!(one.contains("truth: the study has 1") && one.contains("at least 2"), "{one}");
    let none = refusal("sizes.truth", "sizes.other");
    assert!(none.contains("problem bend") && none.contains("sizes.truth"), "{none}");
    let idle = refusal("[[truth]]", "[[truth]]\nsizes = \"linear\"");
    assert!(idle.contains("truth tet10") && idle.contains("no effect"), "{idle}");
}

/// The quick problems of the shipped study in one material and with one seed: no bar from one run is missed, and every case has an estimate.
#[test]
fn a_part_of_the_shipped_study() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/coverage/study.toml");
    let mut study = Study::read_scope(&file, &[], StudyScope::Quick).unwrap_or_else(|e| panic!("{e}"));
    study.cases.retain(|c| c.variant == "nu0.45" && !c.family.ends_with("-b"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_study(&study, folder.path(), None);
    let store = results::read(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let coverage: CoverageRecord = serde_json::from_value(store.study.details.clone()).expect("problems");
    let a = analyse(&store.study, &coverage, &store.cases);
    println!("{}", a.verdict);
    let judged = |c: &StoredCase| !c.record.family.contains("-truth-");
    for c in &store.cases {
        let own = c.record.one_run.as_ref();
        assert_eq!(own.is_some(), judged(c), "{}", c.record.id);
        assert!(own.is_none_or(|e| e.refused.is_none() && !e.quantities.is_empty()), "{}", c.record.id);
    }
    assert_eq!(a.problems, 2);
    let one = a.whole(Estimator::OneRun).expect("bars that count");
    assert!(one.bars >= 20 && one.hold == one.bars, "{one:?}");
}
