//! The live view: it changes no bit of a run, whatever its clients do; values that a page sets are recorded and set again; and who is refused.

mod tools;

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SCENE: &str = "tests/cli/scene.toml";
const BY_HAND: &str = r#"constraint.cable.drive={ kind = "length", signal = { kind = "controlled", initial = "0 mm", range = ["0 mm", "4 mm"] } }"#;
const SIGNAL: &str = "cable_shortening_m";
/// Time within which whatever a test waits for must happen; runs here take a second.
const PATIENCE: Duration = Duration::from_secs(120);

fn simulate(out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.current_dir(ROOT).args(["simulate", SCENE, "--out"]).arg(out).args(more);
    command
}

fn run(out: &Path, more: &[&str]) -> Output {
    simulate(out, more).output().expect("the program starts")
}

/// A run with a live view.
struct Live {
    child: Child,
    port: u16,
    /// With both slashes
    token: String,
    out: PathBuf,
}

impl Live {
    fn start(out: &Path, more: &[&str]) -> Self {
        Self::of(simulate(out, &[&["--live"], more].concat()), out)
    }

    /// The live view of a command.
    fn of(mut command: Command, out: &Path) -> Self {
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the program starts");
        let mut errors = BufReader::new(child.stderr.take().expect("it is piped"));
        let mut line = String::new();
        while !line.contains("http://") {
            line.clear();
            assert!(errors.read_line(&mut line).is_ok_and(|n| n > 0), "no address was printed");
        }
        // Whatever it says later is not to fill the pipe
        std::thread::spawn(move || std::io::copy(&mut errors, &mut std::io::sink()));
        let address = line.split_whitespace().find(|word| word.starts_with("http://")).expect("an address");
        let (port, token) =
            address.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.split_once('/')).expect("on the loopback");
        Self { child, port: port.parse().expect("a port"), token: format!("/{token}"), out: out.into() }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("the run listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        stream
    }

    fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// The answer to bytes.
    fn raw(&self, bytes: &[u8]) -> Vec<u8> {
        let mut stream = self.connect();
        stream.write_all(bytes).ok();
        let mut answer = vec![];
        stream.read_to_end(&mut answer).ok();
        answer
    }

    /// Status of the answer to bytes; 0 where there is none.
    fn status(&self, bytes: &[u8]) -> u16 {
        let answer = String::from_utf8_lossy(&self.raw(bytes)).into_owned();
        answer.split_whitespace().nth(1).and_then(|status| status.parse().ok()).unwrap_or(0)
    }

    fn get(&self, place: &str) -> (u16, Vec<u8>) {
        let answer =
            self.raw(format!("GET {}{place} HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host()).as_bytes());
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer") + 4;
        let status = std::str::from_utf8(&answer[9..12]).expect("a status").parse().expect("a number");
        (status, answer[end..].to_vec())
    }

    /// Status of the answer to a command.
    fn command(&self, command: &Value) -> u16 {
        let body = command.to_string();
        let head = format!(
            "POST {}command HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            self.token,
            self.host(),
            body.len()
        );
        self.status((head + &body).as_bytes())
    }

    fn set(&self, value: f64) {
        assert_eq!(self.command(&json!({ "set": { "signal": SIGNAL, "value": value } })), 204);
    }

    fn events(&self) -> Events {
        let mut stream = self.connect();
        stream
            .write_all(format!("GET {}events HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host()).as_bytes())
            .expect("the run listens");
        Events { lines: BufReader::new(stream) }
    }

    /// The end of the run, which comes by itself.
    fn end(mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a process") {
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "the run does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn file(&self, name: &str) -> String {
        std::fs::read_to_string(self.out.join(name)).expect("written")
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// A client that follows a run.
struct Events {
    lines: BufReader<TcpStream>,
}

impl Events {
    fn next(&mut self) -> Value {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "there is no news");
            let mut line = String::new();
            assert!(self.lines.read_line(&mut line).is_ok_and(|n| n > 0), "the run has closed the stream");
            if let Some(data) = line.strip_prefix("data: ") {
                return serde_json::from_str(data).expect("JSON");
            }
        }
    }

    /// The first news for which this holds.
    fn until(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let news = self.next();
            if holds(&news) {
                return news;
            }
            assert!(start.elapsed() < PATIENCE, "in vain: {news}");
        }
    }

    /// The run waits at its state of this number.
    fn waits(&mut self, states: u64) -> Value {
        self.until(|news| news["waiting"] == true && news["states"]["count"] == states)
    }
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("written")
}

fn folders<const N: usize>() -> (TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = std::array::from_fn(|k| folder.path().join(k.to_string()));
    (folder, out)
}

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
    let rows: Vec<(usize, Vec<f64>)> = serde_json::from_slice(&live.get("rows?from=0").1).expect("rows");
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
    assert!(text(&by_hand, "scene.json").contains("set by hand and recorded"));

    let recording = recorded.to_str().expect("UTF-8");
    let replayed = run(&again, &["--set", BY_HAND, "--replay", recording]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
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
}

/// Clients that vanish, take nothing, send garbage or too much, while a good one drives the run.
#[test]
fn bad_clients_change_nothing() {
    let (_folder, [silent, shown]) = folders();
    assert!(run(&silent, &[]).status.success());
    let live = Live::start(&shown, &["--paused"]);
    let (mut good, host) = (live.events(), live.host());
    good.waits(1);
    let with = |headers: &str| format!("GET {} HTTP/1.1\r\nHost: {host}\r\n{headers}\r\n", live.token).into_bytes();
    assert_eq!(live.status(&with("Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n")), 200);
    assert_eq!(live.status(&with(&format!("X: {}\r\n", "a".repeat(1 << 20)))), 431);
    assert_eq!(live.status(&with(&"X: a\r\n".repeat(1000))), 431);
    assert_eq!(live.status(&b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".repeat(99)), 400);
    assert_eq!(live.status(b"GET / HTTP/9.9\r\n\r\n"), 400);
    let post = |length: &str| format!("POST {}command HTTP/1.1\r\nHost: {host}\r\n{length}\r\n\r\n", live.token);
    let large = [post("Content-Length: 10000000").into_bytes(), vec![b'a'; 10_000_000]].concat();
    assert_eq!(live.status(&large), 413);
    assert_eq!(live.status(post("Transfer-Encoding: chunked").as_bytes()), 411);
    assert_eq!(live.status(post("Content-Length: 18446744073709551616").as_bytes()), 400);
    // They never end a request, take no answer, or go in the middle of one
    let slow: Vec<TcpStream> = (0..20).map(|_| live.connect()).collect();
    slow.iter().for_each(|mut stream| stream.write_all(b"GET / HT").expect("the run listens"));
    let stalled: Vec<TcpStream> = (0..5).map(|_| live.events().lines.into_inner()).collect();
    (0..20).for_each(|_| drop(live.events()));
    for states in 2..=4 {
        assert_eq!(live.command(&json!("step")), 204);
        good.waits(states);
    }
    // A request that is not complete within 5 s is refused
    let start = Instant::now();
    let mut answer = vec![];
    (&slow[0]).read_to_end(&mut answer).expect("an answer");
    assert!(answer.starts_with(b"HTTP/1.1 408") && start.elapsed() < Duration::from_secs(20), "{answer:?}");
    assert_eq!(live.command(&json!("resume")), 204);
    assert!(live.end().success());
    drop((slow, stalled));
    for name in ["scene.csv", "scene.signals.csv"] {
        assert_eq!(text(&silent, name), text(&shown, name), "{name}");
    }
}

/// Nobody without the token, no page of another site, and nothing but the run.
#[test]
fn others_get_nothing_and_change_nothing() {
    let (_folder, [out]) = folders();
    let live = Live::start(&out, &["--set", BY_HAND, "--paused"]);
    let (mut events, host, token) = (live.events(), live.host(), live.token.clone());
    let news = events.waits(1);
    assert!(token.len() == 34 && token[1..33].chars().all(|c| c.is_ascii_hexdigit()), "{token}");
    let get = |path: &str, headers: &str| live.status(format!("GET {path} HTTP/1.1\r\n{headers}\r\n").as_bytes());
    let own = format!("Host: {host}\r\n");
    assert_eq!(get(&token, &own), 200);
    assert_eq!(
        get(&token, &format!("Host: localhost:{}\r\nOrigin: http://localhost:{}\r\n", live.port, live.port)),
        200
    );
    let wrong = format!("/{}/", "0".repeat(32));
    for path in ["/", "/events", &wrong, &token[..33], &format!("{wrong}events"), "//", "*"] {
        assert_eq!(get(path, &own), 403, "{path}");
    }
    for host in ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", &format!("evil.example:{}", live.port)]
    {
        assert_eq!(get(&token, &format!("Host: {host}\r\n")), 403, "{host}");
    }
    assert_eq!(get(&token, ""), 403, "without a host");
    assert_eq!(get(&token, &format!("{own}{own}")), 403, "two hosts");
    for other in
        ["Origin: http://evil.example", "Origin: null", "Origin: https://127.0.0.1", "Sec-Fetch-Site: cross-site"]
    {
        assert_eq!(get(&token, &format!("{own}{other}\r\n")), 403, "{other}");
    }
    for path in
        ["states/", "states/-1", "states/1", "states/99999999999999999999", "../scene.csv", "%2e%2e/etc/passwd", "x"]
    {
        assert_eq!(live.get(path).0, 404, "{path}");
    }
    let send = |kind: &str, body: &str| {
        let length = body.len();
        live.status(
            format!("POST {token}command HTTP/1.1\r\nHost: {host}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\r\n{body}")
                .as_bytes(),
        )
    };
    assert_eq!(send("text/plain", "\"resume\""), 415);
    assert_eq!(send("application/json", "{"), 400);
    assert_eq!(send("application/json", "\"explode\""), 400);
    assert_eq!(send("application/json", &format!("{{\"set\":{{\"signal\":\"{SIGNAL}\",\"value\":1e999}}}}")), 400);
    assert_eq!(send("application/json", &format!("{{\"set\":{{\"signal\":\"{SIGNAL}\",\"value\":null}}}}")), 400);
    assert_eq!(live.command(&json!({ "set": { "signal": SIGNAL, "value": 0.0041 } })), 409);
    assert_eq!(live.command(&json!({ "set": { "signal": "time", "value": 1 } })), 409);
    let other = live.status(format!("DELETE {token} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
    assert_eq!(other, 405);
    live.set(0.004);
    let after = events.until(|news| news["signals"][0]["value"] == 0.004);
    assert!(after["waiting"] == true && after["states"] == news["states"], "{after}");
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
        "line 2: a value is no finite number",
    );
    refuses(&["--set", BY_HAND, "--replay", &file("t_s,cable_shortening_m\n0\n")], "line 2: it has not as many values");
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

/// Drives the page in headless Chromium: the slider, single steps, and the end of the run; what it shows is what the run has written.
#[test]
fn a_browser_drives_a_run() {
    let is_there = |program: &str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    if tools::is_missing(is_there("chromium") && is_there("node"), "chromium with node") {
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
    assert_eq!((&found["clock"], &found["looksBack"]), (&json!("t = 0.25 s"), &json!("t = 0 s")));
    assert!(found["step"].as_str().is_some_and(|s| s.contains("step size 0.25 s, iteration")), "{}", found["step"]);
    assert!(
        found["ended"].as_str().is_some_and(|s| s.starts_with("The run has ended: Converged")),
        "{}",
        found["ended"]
    );
    assert_eq!((&found["states"], &found["disabled"]), (&json!(5), &json!(true)));
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
