//! Changes of every case that override the differences between the cases: the study then compares nothing.

use crate::common::synthetic;
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::store::record::{StoredCase, StudyRecord};
use std::path::Path;
use toml::Value;

fn overridden(file: &str, key: &str, value: Value) -> Vec<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    Study::read(&file, &[(key.into(), value)]).unwrap_or_else(|e| panic!("{key}: {e}")).record.overridden
}

#[test]
fn a_change_that_overrides_the_difference_of_cases_is_known() {
    let step = || Value::from("50 ms");
    assert_eq!(overridden("tests/cli/study.toml", "stage.0.dt", step()), ["stage.0.dt"]);
    let stage = "integrator = 'static'\nduration = '1 s'\ndt = '0.5 s'".parse::<toml::Table>().expect("TOML");
    assert_eq!(overridden("tests/cli/study.toml", "stage.0", stage.into()), ["stage.0"], "the whole table");
    // The families differ in more than their members: the finer mesh would be no finer one
    assert_eq!(overridden("studies/finger-materials/study.toml", "mesh.cells", 3000.into()), ["mesh.cells"]);
    for (key, value) in [("laws.rubber.nu", 0.2.into()), ("stage.0.duration", step()), ("numerics.cuts", 3.into())] {
        assert!(overridden("tests/cli/study.toml", key, value).is_empty(), "{key}");
    }
}

#[test]
fn such_a_study_has_no_verdict() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (mut study, cases) = synthetic::study();
    let summary = |study: &(StudyRecord, Vec<StoredCase>)| {
        synthetic::store(dir.path(), study);
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"))
    };
    let before = summary(&(study.clone(), cases.clone()));
    assert!(before.supported == Some(true) && !before.claims.is_empty(), "{}", before.verdict);
    study.overridden = vec!["mesh.cells".into()];
    let after = summary(&(study, cases));
    assert!(after.verdict.starts_with("No verdict: cases of this study differ by `mesh.cells`"), "{}", after.verdict);
    assert!(after.supported == Some(false) && after.claims.is_empty());
}
