//! Two results compared: inside and outside of the error bars.

use crate::common::synthetic;
use durometer::study::changes::{Changes, Judgement, compare};
use durometer::study::report;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

/// `study.json` and `summary.json` of the synthetic study, whose report is written once.
fn written() -> &'static [String; 2] {
    static FILES: OnceLock<[String; 2]> = OnceLock::new();
    FILES.get_or_init(|| {
        let dir = tempfile::tempdir().expect("a temporary folder");
        synthetic::store(dir.path(), &synthetic::study());
        report::write(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        ["study.json", "summary.json"].map(|name| std::fs::read_to_string(dir.path().join(name)).expect("a result"))
    })
}

/// The result of the synthetic study in a folder of its own, with its summary changed.
fn result(change: impl Fn(&mut Value)) -> tempfile::TempDir {
    let [study, summary] = written();
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut summary: Value = serde_json::from_str(summary).expect("JSON");
    change(&mut summary);
    std::fs::write(dir.path().join("study.json"), study).expect("the study");
    std::fs::write(dir.path().join("summary.json"), summary.to_string()).expect("the summary");
    dir
}

fn changes(old: &tempfile::TempDir, new: &tempfile::TempDir) -> Changes {
    compare(old.path(), new.path(), 1e-4).unwrap_or_else(|e| panic!("{e}"))
}

fn half_width(claim: &Value) -> f64 {
    0.5 * (claim["interval"][1].as_f64().expect("a number") - claim["interval"][0].as_f64().expect("a number"))
}

/// Moves the first claim by this share of √2 of its bar, with its interval.
fn moved(share: f64) -> tempfile::TempDir {
    result(|s| {
        let claim = &mut s["claims"][0];
        let by = share * std::f64::consts::SQRT_2 * half_width(claim);
        for end in 0..2 {
            claim["interval"][end] = json!(claim["interval"][end].as_f64().expect("a number") + by);
        }
        claim["value"] = json!(claim["value"].as_f64().expect("a number") + by);
    })
}

#[test]
fn the_same_result_is_unchanged() {
    let (a, b) = (result(|_| {}), result(|_| {}));
    let same = changes(&a, &b);
    assert!(!same.is_beyond() && same.values.len() > 20, "{}", same.values.len());
    assert!(same.values.iter().all(|v| v.judgement == Judgement::Same));
    assert_eq!(same.unmatched, Vec::<String>::new());
}

/// Both bars have one half-width h, so that a change of √2 h is just at the end of both together.
#[test]
fn a_change_is_judged_by_both_bars() {
    let old = result(|_| {});
    for (share, judgement, beyond) in [(0.99, Judgement::Within, false), (1.01, Judgement::Beyond, true)] {
        for sign in [1.0, -1.0] {
            let found = changes(&old, &moved(sign * share));
            let one: Vec<_> = found.values.iter().filter(|v| v.judgement != Judgement::Same).collect();
            assert_eq!(one.len(), 1, "{one:?}");
            let off = one[0].normalised.expect("a bar") - share;
            assert!(one[0].judgement == judgement && off.abs() < 1e-9, "{one:?}");
            assert_eq!(found.is_beyond(), beyond);
        }
    }
}

/// Without bars, as in results of earlier versions, the tolerance judges.
#[test]
fn a_value_without_a_bar_is_judged_by_the_tolerance() {
    let bare = |factor: f64| {
        result(|s| {
            s.as_object_mut().expect("an object").remove("claims");
            let peak = &mut s["cases"][0]["probes"]["bending_angle_deg"]["peak"];
            *peak = json!(factor * peak.as_f64().expect("a number"));
        })
    };
    let old = bare(1.0);
    for (factor, beyond) in [(1.0 + 0.9e-4, false), (1.0 - 1.1e-4, true)] {
        let found = changes(&old, &bare(factor));
        let one: Vec<_> = found.values.iter().filter(|v| v.judgement != Judgement::Same).collect();
        assert!(one.len() == 1 && one[0].normalised.is_none(), "{one:?}");
        assert_eq!(found.is_beyond(), beyond);
    }
    // Bars in one of the two only are named, and do not judge
    let found = changes(&old, &result(|_| {}));
    assert!(!found.is_beyond() && !found.unmatched.is_empty());
}

#[test]
fn a_lost_case_counts_and_a_new_one_does_not() {
    let (all, fewer) = (result(|_| {}), result(|s| drop(s["cases"].as_array_mut().expect("cases").pop())));
    let lost = changes(&all, &fewer);
    assert!(lost.is_beyond() && lost.missing.len() == 1 && lost.added.is_empty());
    let added = changes(&fewer, &all);
    assert!(!added.is_beyond() && added.added.len() == 1 && added.missing.is_empty());
    let stopped = result(|s| s["cases"][0]["status"] = json!("StepTooSmall"));
    assert!(changes(&all, &stopped).is_beyond());
    assert!(!changes(&stopped, &all).is_beyond());
}

#[test]
fn the_command_has_the_usual_exit_codes() {
    let run = |old: &Path, new: &Path, more: &[&str]| {
        let out = Command::new(env!("CARGO_BIN_EXE_durometer")).arg("compare").args([old, new]).args(more).output();
        let out = out.expect("the program");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (out.status.code(), text(&out.stdout), text(&out.stderr))
    };
    let (a, same, beyond) = (result(|_| {}), result(|_| {}), moved(2.0));
    assert_eq!(run(a.path(), same.path(), &[]).0, Some(0));
    let (code, said, _) = run(a.path(), beyond.path(), &[]);
    assert!(code == Some(3) && said.contains("BEYOND the error bars (2.0 times)"), "{said}");
    let (code, said, _) = run(a.path(), beyond.path(), &["--json"]);
    let json: Value = serde_json::from_str(&said).expect("JSON");
    assert!(code == Some(3) && json["values"].as_array().is_some_and(|v| v.iter().any(|v| v["judgement"] == "beyond")));
    let other = result(|s| s["kind"] = json!("cost"));
    let elsewhere = tempfile::tempdir().expect("a temporary folder");
    for (new, more, fact) in [
        (other.path(), &[][..], "kind \"cost\""),
        (elsewhere.path(), &[][..], "summary.json does not exist"),
        (same.path(), &["--tolerance", "1 N"][..], "--tolerance"),
        (same.path(), &["--tolerance=-1 %"][..], "--tolerance"),
    ] {
        let (code, _, said) = run(a.path(), new, more);
        assert!(code == Some(2) && said.contains(fact), "{fact}: {code:?} {said}");
    }
}
