//! A folder of results has the report of one study, that of its present inputs.

use crate::common::program::call;
use crate::common::stores::{contents, write_study};
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::run::growing::run_study;
use durometer::study::run::runner::{Options, Watch};
use durometer::study::store::record::CaseRecord;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

fn edit(path: &Path, old: &str, new: &str) {
    let text = std::fs::read_to_string(path).expect("a file");
    assert!(text.contains(old), "{text}");
    std::fs::write(path, text.replace(old, new)).expect("room");
}

/// The files of a report, by their names.
fn files(dir: &Path) -> BTreeSet<String> {
    let folders = ["", "figures", "tables", "paper"].map(|name| dir.join(name));
    let all = folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder").flatten());
    let files = all.map(|entry| entry.path()).filter(|path| path.is_file());
    files.map(|path| path.strip_prefix(dir).expect("inside").display().to_string()).collect()
}

/// Whatever the report before was about, the folder has the files of the last one, and those of the user.
#[test]
fn a_report_leaves_no_file_of_an_earlier_one() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 3);
    call(at, &["run", "study.toml", "--out", "r"], 0);
    let first = files(&at.join("r"));
    std::fs::write(at.join("r/figures/mine.svg"), "<svg/>").expect("room");
    edit(&at.join("study.toml"), "name = \"press\"", "name = \"push\"");
    edit(&at.join("study.toml"), "name = \"E\"", "name = \"stiffness\"");
    for out in ["r", "fresh"] {
        call(at, &["run", "study.toml", "--out", out], 0);
    }
    let fresh = files(&at.join("fresh"));
    assert!(!first.is_subset(&fresh), "the names have changed: {first:?}");
    let mut found = files(&at.join("r"));
    assert!(found.remove("figures/mine.svg"));
    assert_eq!(found, fresh);
}

/// Stops the run when the first case is finished.
struct Stops<'a>(&'a AtomicBool);

impl Watch for Stops<'_> {
    fn finished(&self, _: &CaseRecord, _: bool) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A run of other inputs that is stopped leaves no verdict as that of these inputs.
#[test]
fn a_stopped_run_marks_the_earlier_report() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 2);
    let dir = at.join("r");
    let read = || Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let stopped = || {
        let stop = AtomicBool::new(false);
        run_study(&read(), &dir, &Options { jobs: 1, redo: true, ..Options::new(&stop) }, &Stops(&stop))
            .unwrap_or_else(|e| panic!("{e}"));
    };
    let report = || report::write_report(&dir).unwrap_or_else(|e| panic!("{e}"));
    let is_marked = || {
        let summary = std::fs::read(dir.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
        let page = std::fs::read_to_string(dir.join("index.html")).expect("a page");
        let marks = page.matches("have changed since this report was written").count();
        assert_eq!(marks == 1, summary["superseded"].is_string(), "{marks} in the page");
        marks == 1
    };
    stopped();
    report();
    stopped();
    assert!(!is_marked(), "of the same inputs");
    edit(&at.join("scene.toml"), "nu = 0.3", "nu = 0.31");
    stopped();
    assert!(is_marked());
    stopped();
    assert!(is_marked(), "once");
    report();
    assert!(!is_marked());
    edit(&at.join("study.toml"), "tolerance = \"5 %\"", "tolerance = \"4 %\"");
    stopped();
    assert!(is_marked(), "another tolerance");
}

/// The usual folder of a study does not take those of another one that is called the same; a study that was moved finds its results.
#[test]
fn studies_of_one_name_have_folders_of_their_own() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(&at.join("a/foo"), 2);
    write_study(&at.join("b/foo"), 2);
    call(at, &["run", "a/foo"], 0);
    let (_, errors) = call(at, &["run", "b/foo"], 2);
    assert!(errors.contains("a/foo/study.toml, which has the same name") && errors.contains("--out"), "{errors}");
    call(at, &["run", "b/foo", "--out", "other"], 0);
    call(at, &["run", "a/foo"], 0);
    std::fs::rename(at.join("a"), at.join("moved")).expect("own folder");
    let (_, errors) = call(at, &["run", "moved/foo"], 0);
    assert!(errors.contains("kept "), "{errors}");
    for folder in ["s1", "s2"] {
        write_study(&at.join(folder), 2);
    }
    std::fs::create_dir_all(at.join("reports/robustness-scene")).expect("room");
    let origin = "{ \"file\": \"../../s1/scene.toml\" }";
    std::fs::write(at.join("reports/robustness-scene/origin.json"), origin).expect("room");
    let (_, errors) = call(at, &["robustness", "s2/scene.toml"], 2);
    assert!(errors.contains("s1/scene.toml, which has the same name"), "{errors}");
}

/// A run into a folder that was given replaces no results of another study. Those of a copy of the study, of the edited study, and of one that was moved are its own.
#[test]
fn results_of_another_study_are_not_replaced() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    for study in ["a/foo", "b/foo", "c"] {
        write_study(&at.join(study), 2);
    }
    let kept = |study: &str| {
        let (_, errors) = call(at, &["run", study, "--out", "x"], 0);
        errors.lines().filter(|line| line.starts_with("kept ")).count()
    };
    let refused = |study: &str, other: &str| {
        let before = contents(&at.join("x"));
        let (_, errors) = call(at, &["run", study, "--out", "x"], 2);
        assert!(errors.contains(&format!("{other}, which those of {study}")) && errors.contains("--out"), "{errors}");
        assert_eq!(contents(&at.join("x")), before);
    };
    assert_eq!(kept("a/foo/study.toml"), 0);
    refused("c/study.toml", "a/foo/study.toml");
    assert_eq!(kept("b/foo/study.toml"), 2, "a copy");
    edit(&at.join("b/foo/scene.toml"), "nu = 0.3", "nu = 0.4");
    assert_eq!(kept("b/foo/study.toml"), 0, "the study itself was edited");
    refused("a/foo/study.toml", "b/foo/study.toml");
    std::fs::rename(at.join("b"), at.join("moved")).expect("own folder");
    assert_eq!(kept("moved/foo/study.toml"), 2);
    // Results that came in an archive say no file
    std::fs::remove_file(at.join("x/origin.json")).expect("it was noted");
    refused("c/study.toml", "the study foo");
    assert_eq!(kept("moved/foo/study.toml"), 2);
}
