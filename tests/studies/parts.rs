//! A study that is run in parts, by several processes, is the study that one process runs.

use crate::common::program::{call, said, without_mesher};
use crate::common::stores;
use crate::common::stores::{assert_same, write_study};
use durometer::study::store::seal::sealed;
use serde_json::Value;
use std::path::Path;

fn number_of_results(dir: &Path) -> usize {
    stores::contents(dir).keys().filter(|name| name.ends_with(".json")).count()
}

/// The parts of 1, 3 and 13, with the processes of one division at the same time on one folder, against the plain run. Some of the
/// 13 parts of 9 cases are empty.
#[test]
fn the_parts_of_a_study_are_the_study() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 9);
    call(at, &["run", "study.toml", "--out", "whole", "--jobs", "2"], 0);
    for n in [1, 3, 13] {
        let out = format!("parts-{n}");
        let start = |k| {
            let part = format!("{k}/{n}");
            let arguments = ["run", "study.toml", "--out", &out, "--jobs", "1", "--partition", &part, "--json"];
            without_mesher(at, &arguments).stdout(std::process::Stdio::piped()).spawn().expect("the program starts")
        };
        let processes: Vec<_> = (1..=n).map(start).collect();
        let mut cases = 0;
        for process in processes {
            let output = process.wait_with_output().expect("it ends");
            let (said, _) = said(&output, "a part", 0);
            cases += serde_json::from_str::<Value>(&said).expect("JSON")["cases"].as_u64().expect("a number");
        }
        assert_eq!(cases, 9, "every case is in one part");
        assert!(!at.join(&out).join("index.html").exists(), "a part writes no report");
        assert_same(&at.join("whole"), &at.join(&out));
        let (merged, _) = call(at, &["report", &out], 0);
        let (of_whole, _) = call(at, &["report", "whole"], 0);
        assert_eq!(merged.lines().next(), of_whole.lines().next());
    }
}

/// A half-finished study goes on in other parts: what is there is kept.
#[test]
fn parts_go_on_from_what_is_there() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 6);
    call(at, &["run", "study.toml", "--out", "r", "--partition", "1/2"], 0);
    let half = number_of_results(&at.join("r"));
    assert!(half > 0 && half < 6, "{half}");
    let mut kept = 0;
    for k in 1..=3 {
        let (_, errors) = call(at, &["run", "study.toml", "--out", "r", "--partition", &format!("{k}/3")], 0);
        kept += errors.lines().filter(|l| l.starts_with("kept")).count();
    }
    assert_eq!((kept, number_of_results(&at.join("r"))), (half, 6));
}

/// A part that is run after an edit leaves the results of the others, which do not count until they are run too.
#[test]
fn parts_of_other_inputs_do_not_count() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 6);
    call(at, &["run", "study.toml", "--out", "r"], 0);
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("the scene");
    std::fs::write(at.join("scene.toml"), scene.replace("nu = 0.3", "nu = 0.31")).expect("room");
    call(at, &["run", "study.toml", "--out", "r", "--partition", "1/2"], 0);
    let of_report = || {
        let output = without_mesher(at, &["report", "r", "--json"]).output().expect("it starts");
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        ["cases", "outdated"].map(|key| summary[key].as_array().map_or(0, Vec::len))
    };
    let [counted, outdated] = of_report();
    assert!(counted > 0 && outdated > 0 && counted + outdated == 6, "{counted}, {outdated}");
    // Also where only the files of the cases were brought together
    std::fs::remove_dir_all(at.join("r/outdated")).expect("there");
    assert_eq!(of_report(), [counted, outdated]);
    call(at, &["run", "study.toml", "--out", "r", "--partition", "2/2"], 0);
    assert_eq!(of_report(), [6, 0]);
}

#[test]
fn a_part_that_does_not_exist_is_refused() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    write_study(keep.path(), 2);
    for (part, words) in [
        ("5/4", "there is no part 5 of 4"),
        ("0/4", "there is no part 0 of 4"),
        ("1/0", "nothing can be divided into 0 parts"),
        ("half", "\"half\" names no part"),
    ] {
        let (_, errors) = call(keep.path(), &["run", "study.toml", "--out", "r", "--partition", part], 2);
        assert!(errors.contains(words), "{errors}");
        assert!(!keep.path().join("r").exists());
    }
}

/// The list says what a run would do, and what it costs.
#[test]
fn the_list_of_cases_says_what_is_stored() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 5);
    let list = |set: &[&str]| {
        let (said, _) = call(at, &[&["cases", "study.toml", "--out", "r", "--json"], set].concat(), 0);
        serde_json::from_str::<Vec<Value>>(&said).expect("a list")
    };
    let states =
        |list: &[Value]| list.iter().map(|c| c["state"].as_str().expect("a word").to_string()).collect::<Vec<_>>();
    assert_eq!(states(&list(&[])), ["missing"; 5]);
    assert!(!at.join("r").exists(), "a list writes nothing");
    call(at, &["run", "study.toml", "--out", "r"], 0);
    let done = list(&[]);
    assert_eq!(states(&done), ["stored"; 5]);
    assert!(done.iter().all(|c| c["cost_s"].as_f64().expect("known") > 0.0 && c["nodes"] == 18), "{done:?}");
    let text = std::fs::read_to_string(at.join("r/cases/sweep-press-E102kPa.json")).expect("stored");
    let record: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(done[2]["identity"], record["provenance"]["identity"]["sha256"]);
    assert_eq!(states(&list(&["--set", "laws.rubber.nu=0.31"])), ["outdated"; 5]);
    let source = record["provenance"]["build"]["source_sha256"].as_str().expect("a digest");
    let own_digest = record["provenance"]["record_sha256"].as_str().expect("a digest");
    let of_another = sealed(&text.replace(own_digest, "").replace(source, &"0".repeat(64)));
    std::fs::write(at.join("r/cases/sweep-press-E102kPa.json"), of_another).expect("room");
    std::fs::write(at.join("r/cases/sweep-press-E103kPa.csv"), "t_s\n").expect("room");
    assert_eq!(states(&list(&[])), ["stored", "stored", "other_build", "damaged", "stored"]);
    let (table, _) = call(at, &["cases", "study.toml", "--out", "r"], 0);
    assert!(table.contains("5 cases: 3 stored, 1 other build, 1 damaged"), "{table}");
}
