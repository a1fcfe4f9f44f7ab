//! Values that a page sets are recorded and set again; recordings and flags that are refused.

use super::client::{BY_HAND, Live, SIGNAL, folders, run, text};
use serde_json::json;
use std::net::TcpListener;

/// The recording of a run by hand gives its bits again, also from a state in between, and by hand from there.
#[test]
fn a_recording_sets_the_values_of_a_page_again() {
    let (_folder, [by_hand, again, restarted, longer]) = folders();
    let more = ["--set", BY_HAND, "--save-state", "0.5 s"];
    let live = Live::start(&by_hand, &[&more[..], &["--paused"]].concat());
    let mut events = live.events();
    for (states, value) in [(1, 1e-3), (2, 1.0 / 300.0), (3, 2e-3)] {
        let news = events.waits(states);
        assert_eq!(news["signals"][0]["range"], json!([0.0, 0.004]));
        live.set(value);
        assert_eq!(live.command(&json!("step")), 204);
    }
    events.waits(4);
    assert_eq!(live.command(&json!("resume")), 204);
    drop(events);
    let recorded = by_hand.join("scene.control.csv");
    assert!(live.end().success());
    let third = 1.0 / 300.0;
    assert_eq!(text(&by_hand, "scene.control.csv"), format!("t_s,{SIGNAL}\n0,0.001\n0.25,{third}\n0.5,0.002\n"));
    // A value takes effect at the next step: it is reached at its end
    let signals = text(&by_hand, "scene.signals.csv");
    assert_eq!(signals, format!("t_s,{SIGNAL}\n0,0\n0.25,0.001\n0.5,{third}\n0.75,0.002\n1,0.002\n"));
    assert!(text(&by_hand, "scene.json").contains("set by hand, and what was set is recorded"));

    let recording = recorded.to_str().expect("UTF-8");
    let replayed = run(&again, &["--set", BY_HAND, "--replay", recording]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    assert!(text(&again, "scene.json").contains("a recording of 3 rows, the last at 0.5 s, which hold to the end"));
    let state = by_hand.join("scene-0.5s.state");
    let restart = ["--set", BY_HAND, "--restart", state.to_str().expect("UTF-8")];
    assert!(run(&restarted, &[&restart[..], &["--replay", recording]].concat()).status.success());
    for (out, name) in [(&again, "scene.csv"), (&again, "scene.signals.csv"), (&restarted, "scene.csv")] {
        assert_eq!(text(&by_hand, name), text(out, name), "{name} in {}", out.display());
    }
    // The value that was asked for last holds after a restart, and the recording is whole
    let live = Live::start(&longer, &[&restart[..], &["--paused"]].concat());
    // At the point of the checkpoint everything is decided, so that the run pauses at the next one
    let news = live.events().waits(2);
    assert_eq!((&news["t"], &news["signals"][0]["value"]), (&json!(0.75), &json!(0.002)));
    assert_eq!(live.command(&json!("resume")), 204);
    assert!(live.end().success());
    assert_eq!(text(&by_hand, "scene.csv"), text(&longer, "scene.csv"));
    let rows = text(&longer, "scene.control.csv");
    assert!(rows.starts_with(&format!("t_s,{SIGNAL}\n0,0.001\n0.25,{third}\n0.5,0.002\n")), "{rows}");
    // Another run by hand keeps what was recorded, and one that goes on with its rows replaces it
    let before = text(&by_hand, "scene.control.csv");
    assert!(Live::start(&by_hand, &["--set", BY_HAND]).end().success());
    assert_eq!(text(&by_hand, "scene.control-1.csv"), before);
    std::fs::write(&recorded, &before).expect("room");
    assert!(Live::start(&by_hand, &restart).end().success());
    assert!(text(&by_hand, "scene.control.csv").starts_with(&before) && !by_hand.join("scene.control-2.csv").exists());
}

#[test]
fn bad_flags_are_refused_before_the_run() {
    let (folder, [out]) = folders();
    let taken = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    let port = taken.local_addr().expect("an address").port().to_string();
    let file = |text: &str| {
        let file = folder.path().join("recording.csv");
        std::fs::write(&file, text).expect("room");
        file.to_string_lossy().into_owned()
    };
    let refuses = |flags: &[&str], words: &str| {
        let output = run(&out, flags);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(words), "{flags:?}: {said}");
        assert!(!out.join("scene.csv").exists(), "{flags:?}");
    };
    refuses(&["--live", "--port", &port], "another program uses this port; take another one");
    refuses(&["--port", "8000"], "--live");
    refuses(&["--paused"], "--live");
    refuses(&["--set", BY_HAND], "set it by hand: --live");
    refuses(&["--set", BY_HAND, "--live", "--error"], "do not go with signals that a page sets");
    refuses(&["--replay", "x.csv"], "leaves no signal to a controller");
    refuses(&["--set", BY_HAND, "--replay", "none.csv"], "cannot be read");
    refuses(&["--set", BY_HAND, "--replay", &file("a,b\n")], "the header is not t_s");
    refuses(
        &["--set", BY_HAND, "--replay", &file("t_s,other_m\n0,1\n")],
        "it sets other_m, and the scene leaves cable_shortening_m",
    );
    refuses(
        &["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n0,x\n")],
        "line 2: a value is not a finite number",
    );
    refuses(&["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n0\n")], "line 2: it has not as many values");
    // 0.0021 that was cut off is 0.002
    refuses(
        &["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n0,0.001\n0.25,0.002")],
        "line 3: it has no line break at its end, so that the file was cut off there; record it again",
    );
    refuses(
        &["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m")],
        "line 1: it has no line break at its end",
    );
    refuses(
        &["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n1,0\n1,0\n")],
        "line 3: its time is not after",
    );
    refuses(
        &["--set", &BY_HAND.replace("\"4 mm\"", "\"-4 mm\"")],
        "`range` of a controlled signal rises and contains `initial`",
    );
    // A value beyond the range ends the run, with the rows so far
    let output = run(&out, &["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n0.25,0.005\n")]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(3) && said.contains("its `range` is from 0 to 0.004"), "{said}");
    assert_eq!(text(&out, "scene.csv").lines().count(), 3);
}
