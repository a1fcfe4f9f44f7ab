//! Constants of law files with their intervals are inputs of a validation.

use crate::beam::{SCENE, STUDY, by_formula};
use durometer::study::kind::StudyScope;
use durometer::study::kinds::validation::analysis::analyse;
use durometer::study::kinds::validation::budget::COVERAGE;
use durometer::study::kinds::validation::plan::ValidationPlan;

/// Plan of the beam with this provenance of its law, without the input by the batch.
fn plan(provenance: &str) -> ValidationPlan {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = SCENE.replace("nu = 0.3", &format!("nu = 0.3\nprovenance = {{ {provenance} }}"));
    std::fs::write(folder.path().join("scene.toml"), scene).expect("writable");
    let read = durometer::study::study_file::parse(&folder.path().join("study.toml"), STUDY, StudyScope::Whole);
    let (_, expansion) = read.unwrap_or_else(|e| panic!("{e}"));
    serde_json::from_value(expansion.details).expect("a plan")
}

/// ν of the file is an input of every record, once; E is found, and its interval does not count.
#[test]
fn an_interval_of_a_law_file_is_an_input() {
    let plan = plan("nu_interval = [0.28, 0.31], E_interval = [\"200 kPa\", \"400 kPa\"]");
    let own: Vec<usize> = (0..plan.inputs.len()).filter(|k| plan.inputs[*k].of_law_file).collect();
    let [k] = own[..] else { panic!("{:?}", plan.inputs) };
    assert_eq!((plan.inputs[k].name.as_str(), plan.inputs[k].group.as_str()), ("laws.rubber.nu", "law file"));
    for record in &plan.records {
        let (_, amounts) = record.inputs.iter().find(|(j, _)| *j == k).expect("an input of every record");
        assert!(amounts.len() == 1 && amounts[0].0 == "laws.rubber.nu", "{amounts:?}");
        assert!((amounts[0].1 * COVERAGE - 0.02).abs() < 1e-12, "the larger side: {amounts:?}");
        assert!(record.open.is_empty());
        let place = record.inputs.iter().position(|(j, _)| *j == k).expect("an input of every record");
        let own = plan.checks.iter().filter(|(id, _)| id.starts_with(&format!("check-{}-", record.name)));
        assert!(own.map(|(_, (_, s))| s[place]).all(|s| s == 0.0), "checks leave it: {:?}", plan.checks);
    }
    // Another value than that of the file has no interval
    assert!(!self::plan("nu_interval = [0.35, 0.4]").inputs.iter().any(|i| i.of_law_file));
}

/// Where the file leaves a constant open, no side of the interval is claimed for a measured value.
#[test]
fn with_an_open_interval_nothing_is_judged() {
    assert_eq!(plan("nu_without_interval = \"the data leave it open\"").records[0].open, ["laws.rubber.nu"]);
    let (mut plan, results) = by_formula();
    plan.quantities[0].records.insert("heavy".into(), vec![9.0]);
    assert!(analyse(&results, &plan).predictions[0].inside.is_some());
    plan.records[1].open = vec!["laws.rubber.nu".into()];
    let a = analyse(&results, &plan);
    let p = &a.predictions[0];
    assert!(p.inside.is_none() && p.score.is_none(), "{p:?}");
    assert!(
        a.verdict.contains("is not judged, since its interval lacks the uncertainty of laws.rubber.nu"),
        "{}",
        a.verdict
    );
    assert!(a.warnings.iter().any(|w| w.contains("state it as an input")), "{:?}", a.warnings);
}
