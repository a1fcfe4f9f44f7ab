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
        report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
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
            let value = &mut s["cases"][0]["judged"]["bending_angle_deg"];
            *value = json!(factor * value.as_f64().expect("a number"));
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
fn a_negative_value_that_grows_away_from_zero_changes_by_a_positive_share() {
    let of = |angle: f64| {
        result(|s| {
            s.as_object_mut().expect("an object").remove("claims");
            s["cases"][0]["judged"]["bending_angle_deg"] = json!(angle);
        })
    };
    let found = changes(&of(-0.125), &of(-0.1275));
    let one: Vec<_> = found.values.iter().filter(|v| v.judgement != Judgement::Same).collect();
    let share = one[0].relative.expect("a value other than zero");
    assert!(one.len() == 1 && (share - 0.02).abs() < 1e-12, "{one:?}");
}

/// The synthetic results without bars, where the angle begins at 2000° and changes by this factor of what it does otherwise.
fn raised(factor: f64) -> tempfile::TempDir {
    let (study, mut cases) = synthetic::study();
    let place = |angle: f64| 2000.0 + factor * angle;
    for case in &mut cases {
        let curve = case.series.columns.get_mut("bending_angle_deg").expect("the angle");
        curve.iter_mut().for_each(|angle| *angle = place(*angle));
        let probe = case.record.probes.get_mut("bending_angle_deg").expect("the angle");
        (probe.peak, probe.last) = (place(probe.peak), place(probe.last));
    }
    let dir = tempfile::tempdir().expect("a temporary folder");
    synthetic::store(dir.path(), &(study, cases));
    report::write_report(dir.path()).unwrap_or_else(|e| panic!("{e}"));
    rewrite(&dir, &mut |s| drop(s.as_object_mut().expect("an object").remove("claims")));
    dir
}

/// Changes the summary of a result in its place.
fn rewrite(dir: &tempfile::TempDir, change: &mut dyn FnMut(&mut Value)) {
    rewrite_file(dir, "summary.json", change);
}

fn rewrite_file(dir: &tempfile::TempDir, name: &str, change: &mut dyn FnMut(&mut Value)) {
    let file = dir.path().join(name);
    let mut content: Value = serde_json::from_slice(&std::fs::read(&file).expect("a file")).expect("JSON");
    change(&mut content);
    std::fs::write(file, content.to_string()).expect("the file");
}

/// A change of 3 % is 0.1 % of the place: what counts is the change, also in results of earlier versions, as long as their curves are there.
#[test]
fn what_does_not_start_at_zero_is_judged_by_its_change() {
    let (old, new) = (raised(1.0), raised(1.03));
    let angles = |name: &str| {
        let found = compare(old.path(), new.path(), 1e-2).unwrap_or_else(|e| panic!("{e}"));
        let all: Vec<_> = found.values.into_iter().filter(|v| v.what.ends_with(name)).collect();
        assert!(all.len() > 10, "{}", all.len());
        all
    };
    let check_changes = || {
        for v in angles(": bending_angle_deg") {
            assert!(v.judgement == Judgement::Beyond && v.old < 100.0, "{v:?}");
            assert!((v.relative.expect("not of zero") - 0.03).abs() < 1e-9, "{v:?}");
        }
    };
    check_changes();
    for dir in [&old, &new] {
        rewrite(dir, &mut |s| {
            for case in s["cases"].as_array_mut().expect("cases") {
                case.as_object_mut().expect("an object").remove("judged");
            }
        });
    }
    check_changes();
    std::fs::remove_dir_all(old.path().join("cases")).expect("its curves");
    for v in angles(": bending_angle_deg, recorded extreme") {
        assert!(v.judgement == Judgement::Within && v.old > 2000.0, "{v:?}");
    }
}

#[test]
fn a_changed_verdict_counts_and_its_numbers_do_not() {
    let old = result(|_| {});
    let reworded = changes(&old, &result(|s| s["verdict"] = json!("The same for 5.3 s per case.")));
    assert!(!reworded.verdict_changed && !reworded.is_beyond() && reworded.verdict[0] != reworded.verdict[1]);
    let refused = |s: &mut Value| {
        s["supported"] = json!(false);
        s["verdict"] = json!("No verdict within 5 %: the data do not support one.");
    };
    let lost = result(refused);
    for (a, b) in [(&old, &lost), (&lost, &old)] {
        let found = changes(a, b);
        assert!(found.verdict_changed && found.is_beyond());
        assert!(found.values.iter().all(|v| v.judgement == Judgement::Same));
    }
    assert!(!changes(&lost, &lost).is_beyond());
    // As an earlier version has written it
    let earlier = result(|s| {
        refused(s);
        s.as_object_mut().expect("an object").remove("supported");
    });
    assert!(changes(&old, &earlier).verdict_changed && !changes(&lost, &earlier).verdict_changed);
    // Another setting is recommended: because it is cheaper now, or because the one of before is beyond the tolerance
    let other = |bar: f64| {
        result(|s| {
            let analysis = &mut s["analysis"];
            let was = analysis["recommended_case"].as_str().expect("a recommendation").to_string();
            let settings = analysis["settings"].as_array_mut().expect("settings");
            let is_of =
                |setting: &Value| setting["cases"].as_array().is_some_and(|ids| ids.iter().any(|id| *id == was));
            let good = |setting: &Value| setting["worst"].as_f64().is_some_and(|worst| worst <= 0.05);
            let next =
                settings.iter().find(|s| good(s) && !is_of(s)).expect("another good setting")["cases"][0].clone();
            settings.iter_mut().find(|s| is_of(s)).expect("its setting")["worst"] = json!(bar);
            analysis["recommended_case"] = next;
        })
    };
    assert!(!changes(&old, &other(1e-3)).verdict_changed);
    assert!(changes(&old, &other(0.2)).verdict_changed && changes(&other(0.2), &old).verdict_changed);
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
fn a_changed_decision_is_a_changed_verdict() {
    let decided = |decisions: Value| result(|s| s["decisions"] = decisions.clone());
    let old = decided(json!({ "b can replace a": "yes", "c can replace a": "no" }));
    let reversed = decided(json!({ "b can replace a": "no", "c can replace a": "no", "d can replace a": "yes" }));
    let fewer = decided(json!({ "c can replace a": "no" }));
    for (new, now) in [(&reversed, Some("no")), (&fewer, None)] {
        let found = changes(&old, new);
        let [one] = &found.decisions[..] else { panic!("{:?}", found.decisions) };
        assert_eq!((one.what.as_str(), one.old.as_str(), one.new.as_deref()), ("b can replace a", "yes", now));
        assert!(found.verdict_changed && found.is_beyond());
    }
    assert!(!changes(&fewer, &old).is_beyond(), "a decision that is new changes none");
    let earlier = result(|s| drop(s.as_object_mut().expect("an object").remove("decisions")));
    let found = changes(&old, &earlier);
    assert!(!found.verdict_changed && found.undecided == [false, true]);
}

/// A result without a quantity that the earlier one judges, and without its error bars.
#[test]
fn a_value_that_is_judged_no_more_is_gone() {
    let (all, fewer) = (result(|_| {}), result(|_| {}));
    let is_angle = |what: &str| what.contains("-length-") && what.ends_with(": bending_angle_deg");
    rewrite_file(&fewer, "study.json", &mut |s| {
        let quantities = s["quantities"]["length"].as_array_mut().expect("quantities");
        quantities.retain(|q| q["name"] != "bending_angle_deg");
    });
    rewrite(&fewer, &mut |s| {
        let claims = s["claims"].as_array_mut().expect("claims");
        claims.retain(|c| !is_angle(c["what"].as_str().expect("a name")));
    });
    let lost = changes(&all, &fewer);
    assert!(
        lost.is_beyond() && !lost.gone.is_empty() && lost.gone.iter().all(|what| is_angle(what)),
        "{:?}",
        lost.gone
    );
    assert!(lost.unmatched.is_empty() && lost.new.is_empty(), "{:?}", lost.unmatched);
    assert!(!lost.values.iter().any(|v| is_angle(&v.what)), "what is judged once is not compared");
    let added = changes(&fewer, &all);
    assert!(!added.is_beyond() && added.new == lost.gone && added.gone.is_empty());
    // Values of a case that is gone are named with it
    let without_case = result(|s| {
        let case = s["cases"].as_array_mut().expect("cases").pop().expect("a case")["id"].clone();
        let start = format!("{}:", case.as_str().expect("a name"));
        s["claims"]
            .as_array_mut()
            .expect("claims")
            .retain(|c| !c["what"].as_str().expect("a name").starts_with(&start));
    });
    let found = changes(&all, &without_case);
    assert!(found.missing.len() == 1 && found.gone.is_empty() && found.unmatched.is_empty(), "{:?}", found.unmatched);
}

#[test]
fn what_decides_how_values_are_judged_is_compared() {
    let judged = |by: &str| {
        let dir = result(|_| {});
        rewrite_file(&dir, "study.json", &mut |s| s["details"] = json!({ "judged": by, "points": [1] }));
        dir
    };
    let (peak, last) = (judged("peak"), judged("final"));
    rewrite_file(&last, "study.json", &mut |s| {
        let mut quantities = s["quantities"]["length"].as_array_mut().expect("quantities").iter_mut();
        let angle = quantities.find(|q| q["name"] == "bending_angle_deg").expect("the angle");
        angle["absolute_tolerance"] = json!(0.5);
    });
    let found = changes(&peak, &last);
    let said: Vec<_> = found.settings.iter().map(|s| (s.what.as_str(), s.old.as_str(), s.new.as_str())).collect();
    let tolerance = "absolute tolerance of bending_angle_deg, length";
    assert_eq!(said, [(tolerance, "none", "0.5°"), ("judged", "peak", "final")]);
    assert!(changes(&peak, &peak).settings.is_empty());
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
    let refused = result(|s| s["supported"] = json!(false));
    let (code, said, _) = run(a.path(), refused.path(), &[]);
    assert!(code == Some(3) && said.contains("0 beyond; the VERDICT CHANGED"), "{said}");
    let decided = |how: &str| result(|s| s["decisions"] = json!({ "b can replace a": how }));
    let (code, said, _) = run(decided("yes").path(), decided("no").path(), &[]);
    let words = "decision: b can replace a: yes, now no";
    assert!(code == Some(3) && said.contains(words) && said.contains("the VERDICT CHANGED"), "{said}");
    let earlier = result(|s| drop(s.as_object_mut().expect("an object").remove("decisions")));
    let (code, said, _) = run(earlier.path(), a.path(), &[]);
    assert!(code == Some(0) && said.contains("decisions are not compared: "), "{said}");
    let cost =
        |seconds: &str| result(|s| s["verdict"] = json!(format!("The finest mesh, for {seconds} s of CPU time.")));
    let (code, said, _) = run(cost("5.3").path(), cost("12").path(), &[]);
    assert!(code == Some(0) && !said.contains("verdict"), "{said}");
    let (_, said, _) = run(a.path(), cost("12").path(), &[]);
    assert!(said.contains("verdict: "), "{said}");
    let other = result(|s| s["kind"] = json!("cost"));
    let elsewhere = tempfile::tempdir().expect("a temporary folder");
    for (new, more, fact) in [
        (other.path(), &[][..], "kind \"cost\""),
        (
            elsewhere.path(),
            &[][..],
            "summary.json does not exist; give the folder that `durometer run STUDY` has written",
        ),
        (same.path(), &["--tolerance", "1 N"][..], "--tolerance"),
        (same.path(), &["--tolerance=-1 %"][..], "--tolerance"),
    ] {
        let (code, _, said) = run(a.path(), new, more);
        assert!(code == Some(2) && said.contains(fact), "{fact}: {code:?} {said}");
    }
}
