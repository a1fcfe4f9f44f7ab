//! The live view: it changes no bit of a run, whatever its clients do; values that a page sets are recorded and set again; and who is refused.

mod client;
#[path = "../common/mod.rs"]
mod common;
mod recording;
mod strangers;

use client::{BY_HAND, Live, PATIENCE, ROOT, SIGNAL, folders, run, text};
use durometer::live::{Access, Board, Listener, Opening};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A page that pauses, steps and reads everything changes no bit; states and rows that it gets are those of the run.
#[test]
fn a_live_run_has_the_bits_of_a_silent_one() {
    let (_folder, [silent, shown]) = folders();
    assert!(run(&silent, &[]).status.success());
    let live = Live::start(&shown, &["--paused"]);
    let mut events = live.events();
    let first = events.waits(1);
    assert_eq!((&first["t"], &first["end"], &first["ended"]), (&json!(0.0), &json!(1.0), &Value::Null));
    assert_eq!(first["signals"], json!([]), "the scene leaves no signal to a page");
    let (status, page) = live.get("");
    let page = String::from_utf8(page).expect("text");
    assert!(status == 200 && page.contains("connect-src 'self'") && page.contains("id=\"live\""), "{status}");
    assert_eq!(live.command(&json!("step")), 204);
    let second = events.waits(2);
    let iterations = second["iterations"].as_array().expect("a list");
    assert!(iterations.iter().all(|i| i[1] == 0.25 && i[2] == 0.25), "{second}");
    // The last error of a step is within the tolerance
    let last = &iterations[iterations.len() - 1];
    assert!(last[3].as_u64() > Some(1) && last[4].as_f64().is_some_and(|e| e <= 1.0), "{second}");
    let (status, bytes) = live.get("states/1");
    assert_eq!((status, &bytes[..8]), (200, &0.25f64.to_le_bytes()[..]));
    assert_eq!(live.get("states/2").0, 404);
    assert_eq!(live.command(&json!("resume")), 204);
    let last = events.until(|news| !news["ended"].is_null());
    assert_eq!((&last["ended"]["status"], &last["states"]["count"]), (&json!("Converged"), &json!(5)));
    let answer: Value = serde_json::from_slice(&live.get("rows?from=0").1).expect("rows");
    assert_eq!(
        (&answer["stride"], answer["count"].as_u64()),
        (&json!(1), answer["rows"].as_array().map(|all| all.len() as u64))
    );
    let rows: Vec<(usize, Vec<f64>)> = serde_json::from_value(answer["rows"].clone()).expect("rows");
    let lines = rows.iter().map(|(_, row)| row.iter().map(ToString::to_string).collect::<Vec<_>>().join(","));
    let written = text(&silent, "scene.csv");
    assert_eq!(written.lines().skip(1).collect::<Vec<_>>(), lines.collect::<Vec<_>>());
    drop(events);
    assert!(live.end().success());
    for name in ["scene.csv", "scene.signals.csv"] {
        assert_eq!(text(&silent, name), text(&shown, name), "{name}");
    }
    assert!(shown.join("scene.html").exists() && !shown.join("scene.control.csv").exists());
}

/// A case of a study: paused, stepped and let go, with the results of a silent run, in whose time the pause does not count.
#[test]
fn a_case_of_a_study_is_shown_while_it_runs() {
    let (_folder, [silent, shown]) = folders();
    let study = |out: &Path, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
        let flags = ["run", "tests/cli/study.toml", "--only", "sizes", "--set", "stage.0.dt=\"2 ms\"", "--out"];
        command.current_dir(ROOT).args(flags).arg(out).args(more);
        command
    };
    let output = study(&silent, &[]).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let live = Live::of(study(&shown, &["--live"]), &shown);
    // Until it has begun
    let (mut caught, start) = (None, Instant::now());
    while caught.is_none() && start.elapsed() < PATIENCE {
        let page = String::from_utf8(live.get("").1).expect("text");
        if !page.contains("id=\"live\"") {
            assert!(page.contains("No case computes at this moment"), "{page}");
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        let mut events = live.events();
        // The case may have ended since its page was there, and the next one has not begun
        if live.command(&json!("pause")) != 204 {
            continue;
        }
        let news = events.until(|news| news["waiting"] == true || !news["ended"].is_null());
        let count = news["states"]["count"].as_u64().expect("a number");
        if !news["ended"].is_null() {
            continue;
        }
        // A pause in which nothing is computed
        std::thread::sleep(Duration::from_secs(3));
        assert_eq!(live.command(&json!("step")), 204);
        events.waits(count + 1);
        assert_eq!(live.get(&format!("states/{count}")).0, 200);
        assert_eq!(live.command(&json!("resume")), 204);
        let last = events.until(|news| !news["ended"].is_null());
        assert_eq!(last["ended"]["status"], "Converged");
        caught = last["run"].as_str().map(str::to_string);
        // Title, heading and settings of the page say which case it is
        let name = format!("{}: Two rubber cubes side by side", caught.as_deref().expect("a name"));
        assert!(page.contains(&format!("<title>{name}")) && page.contains(&format!("<h1>{name}")), "{name}");
        assert!(page.contains("\"case\":true"), "{page}");
    }
    let caught = caught.expect("the case was not caught while it ran");
    assert!(live.end().success());
    let record = text(&shown.join("cases"), &format!("{caught}.json"));
    let record: Value = serde_json::from_str(&record).expect("a record");
    let (wall, all) = (record["wall_s"].as_f64().expect("a number"), start.elapsed().as_secs_f64());
    assert!(wall < all - 3.0, "the case took {wall} s of {all} s, of which it was paused for 3 s");
    let mut compared = 0;
    for entry in std::fs::read_dir(silent.join("cases")).expect("cases").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".csv") {
            compared += 1;
            let [a, b] = [&silent, &shown].map(|out| std::fs::read(out.join("cases").join(&name)).expect("stored"));
            assert!(a == b, "{name}");
        }
    }
    assert!(compared == 1, "{compared}");
    let engine = ["run", "tests/cli/study.toml", "--live", "--engine", "slurm"];
    let refused = Command::new(env!("CARGO_BIN_EXE_durometer")).current_dir(ROOT).args(engine).output();
    let refused = refused.expect("the program starts");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("--live shows cases that run on this machine"), "{said}");
}

/// A page that pauses the run and vanishes does not hold it for ever, and Ctrl-C ends a run that waits, with its results.
#[test]
#[cfg(unix)]
fn a_paused_run_is_not_lost() {
    let (_folder, [alone, stopped]) = folders();
    let live = Live::start(&alone, &["--paused"]);
    let mut events = live.events();
    events.waits(1);
    drop(events);
    let start = Instant::now();
    assert!(live.end().success());
    assert!(start.elapsed() > Duration::from_secs(9), "{:?}", start.elapsed());
    let live = Live::start(&stopped, &["--paused"]);
    let mut events = live.events();
    assert_eq!(live.command(&json!("step")), 204);
    events.waits(2);
    let process = nix::unistd::Pid::from_raw(live.child.id() as i32);
    nix::sys::signal::kill(process, nix::sys::signal::Signal::SIGINT).expect("it runs");
    let last = events.until(|news| !news["ended"].is_null());
    assert_eq!(last["ended"]["status"], "Interrupted");
    let rows = live.file("scene.csv");
    assert_eq!(live.end().code(), Some(3));
    assert_eq!(rows.lines().count(), 3);
}

/// A run that fails says so to its pages, with the reason.
#[test]
fn a_page_hears_why_a_run_fails() {
    let (_folder, [out]) = folders();
    let cuts = ["--set", "numerics.max_iterations=1", "--set", "numerics.cuts=0", "--paused"];
    let live = Live::start(&out, &cuts);
    let mut events = live.events();
    events.waits(1);
    assert_eq!(live.command(&json!("resume")), 204);
    let last = events.until(|news| !news["ended"].is_null());
    assert_eq!(last["ended"]["status"], "StepTooSmall", "{last}");
    assert!(last["ended"]["detail"].as_str().is_some_and(|why| why.len() > 20), "{last}");
    assert_eq!(live.command(&json!("pause")), 409);
    drop(events);
    assert_eq!(live.end().code(), Some(3));
}

/// Drives the page in headless Chromium: the slider, single steps, and the end of the run; what it shows is what the run has written.
#[test]
fn a_browser_drives_a_run() {
    let is_there = |program: &str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    if common::tools::is_missing(is_there("chromium") && is_there("node"), "chromium with node") {
        return;
    }
    let (_folder, [out]) = folders();
    let live = Live::start(&out, &["--set", BY_HAND, "--paused"]);
    let output = Command::new("node")
        .arg(Path::new(ROOT).join("viewer/test/live.mjs"))
        .arg(format!("http://{}{}", live.host(), live.token))
        .output()
        .expect("node starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(live.end().success());
    assert_eq!(found["errors"], json!([]));
    let own = format!("{}/", found["requests"][0].as_str().expect("an address").trim_end_matches('/'));
    let requests = found["requests"].as_array().expect("a list");
    assert!(requests.iter().all(|r| r.as_str().is_some_and(|r| r.starts_with(&own))), "{requests:?}");
    assert_eq!(
        (&found["begins"], &found["stepped"]),
        (&json!("Paused at t = 0 of 1 s"), &json!("Paused at t = 0.25 of 1 s"))
    );
    let number = |text: &str| {
        let said = format!("“{text}” is no number; write one in mm, such as 1.5.");
        (text.to_string(), json!(["1.5", said, "1.5 mm"]))
    };
    let mut typed: serde_json::Map<String, Value> = ["", "abc", "7 mm"].map(number).into_iter().collect();
    typed.insert("1,5".into(), json!(["1.5", "", "1.5 mm"]));
    typed.insert("99".into(), json!(["4", "The range is 0 mm to 4 mm; 4 mm is taken.", "4 mm"]));
    assert_eq!(found["typed"], Value::Object(typed));
    assert_eq!((&found["clock"], &found["looksBack"]), (&json!("t = 0.25 s"), &json!("t = 0 s")));
    assert!(found["step"].as_str().is_some_and(|s| s.contains("step size 0.25 s, iteration")), "{}", found["step"]);
    assert!(
        found["ended"].as_str().is_some_and(|s| s.starts_with("The run has ended: Converged")),
        "{}",
        found["ended"]
    );
    let title = "Two rubber cubes side by side, bent by a cable – Durometer";
    assert_eq!(found["title"], title);
    let case = found["case"].as_str().expect("text");
    assert!(case.starts_with("The case has ended: Converged"), "{case}");
    assert!(case.ends_with("stay; load the page again to see the case that runs then."), "{case}");
    assert_eq!((&found["states"], &found["disabled"]), (&json!(5), &json!(true)));
    assert_eq!(found["follows"], json!([false, true]));
    // The first state, and the last one of a run that keeps only every hundredth
    assert_eq!(found["kept"], json!([0, 4]));
    assert_eq!(found["different"].as_array().map(Vec::len), Some(3), "{}", found["different"]);
    assert_eq!(text(&out, "scene.control.csv"), format!("t_s,{SIGNAL}\n0,0.004\n"));
    let rows = found["rows"].as_array().expect("rows").iter().map(|row| {
        row.as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_f64)
            .map(|v| v.to_string())
            .collect::<Vec<_>>()
            .join(",")
    });
    assert_eq!(text(&out, "scene.csv").lines().skip(1).collect::<Vec<_>>(), rows.collect::<Vec<_>>());
    // The last state is that of the page that the run has written, to its stated error
    let written = &durometer::report::viewer::page::read(&out.join("scene.html")).expect("a page")[0];
    assert_eq!(written.head["times"].as_array().map(Vec::len), Some(5));
    assert!(found["positions"].as_array().is_some_and(|p| p.len() == 3 * 26), "{}", found["positions"]);
}

/// A process that goes on after a run, such as a session of Python, keeps neither its port nor its states.
#[test]
fn a_board_is_served_as_long_as_the_guard_lives() {
    let listener = Listener::open(0).expect("a free port");
    let Access { port, token } = listener.access().clone();
    let board = Arc::new(Board::new(Opening::default()));
    let served = listener.serve(board.clone()).expect("a thread");
    let connect = || TcpStream::connect(("127.0.0.1", port));
    let mut page = connect().expect("it is served");
    write!(page, "GET /{token}/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").expect("it listens");
    let mut first = [0; 15];
    page.read_exact(&mut first).expect("an answer");
    assert_eq!(&first, b"HTTP/1.1 200 OK");
    drop(served);
    // A page that follows is sent away, and nothing is left of the server; programs that other tests start hold its port for a moment
    page.read_to_end(&mut vec![]).expect("the end");
    let start = Instant::now();
    while Arc::strong_count(&board) > 1 || connect().is_ok() {
        assert!(start.elapsed() < PATIENCE, "a thread has the board, or the port is open");
        std::thread::sleep(Duration::from_millis(20));
    }
}
