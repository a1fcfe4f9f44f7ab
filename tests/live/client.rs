//! Runs with a live view, and clients that follow and drive them.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const SCENE: &str = "tests/cli/scene.toml";
pub const BY_HAND: &str = r#"constraint.cable.drive={ kind = "length", signal = { kind = "controlled", initial = "0 mm", range = ["0 mm", "4 mm"] } }"#;
pub const SIGNAL: &str = "cable_shortening_m";
/// Time within which whatever a test waits for must happen; runs here take a second.
pub const PATIENCE: Duration = Duration::from_secs(120);

fn simulate(out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.current_dir(ROOT).args(["simulate", SCENE, "--out"]).arg(out).args(more);
    command
}

pub fn run(out: &Path, more: &[&str]) -> Output {
    simulate(out, more).output().expect("the program starts")
}

/// A run with a live view.
pub struct Live {
    pub child: Child,
    pub port: u16,
    /// With both slashes
    pub token: String,
    out: PathBuf,
}

impl Live {
    pub fn start(out: &Path, more: &[&str]) -> Self {
        Self::of(simulate(out, &[&["--live"], more].concat()), out)
    }

    /// The live view of a command.
    pub fn of(mut command: Command, out: &Path) -> Self {
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

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("the run listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        stream
    }

    pub fn host(&self) -> String {
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
    pub fn status(&self, bytes: &[u8]) -> u16 {
        let answer = String::from_utf8_lossy(&self.raw(bytes)).into_owned();
        answer.split_whitespace().nth(1).and_then(|status| status.parse().ok()).unwrap_or(0)
    }

    pub fn get(&self, place: &str) -> (u16, Vec<u8>) {
        let answer =
            self.raw(format!("GET {}{place} HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host()).as_bytes());
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer") + 4;
        let status = std::str::from_utf8(&answer[9..12]).expect("a status").parse().expect("a number");
        (status, answer[end..].to_vec())
    }

    /// Status of the answer to a command.
    pub fn command(&self, command: &Value) -> u16 {
        let body = command.to_string();
        let head = format!(
            "POST {}command HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            self.token,
            self.host(),
            body.len()
        );
        self.status((head + &body).as_bytes())
    }

    pub fn set(&self, value: f64) {
        assert_eq!(self.command(&json!({ "set": { "signal": SIGNAL, "value": value } })), 204);
    }

    pub fn events(&self) -> Events {
        let mut stream = self.connect();
        stream
            .write_all(format!("GET {}events HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host()).as_bytes())
            .expect("the run listens");
        Events { lines: BufReader::new(stream) }
    }

    /// The end of the run, which comes by itself.
    pub fn end(mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a process") {
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "the run does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub fn file(&self, name: &str) -> String {
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
pub struct Events {
    pub lines: BufReader<TcpStream>,
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
    pub fn until(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
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
    pub fn waits(&mut self, states: u64) -> Value {
        self.until(|news| news["waiting"] == true && news["states"]["count"] == states)
    }
}

pub fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("written")
}

pub fn folders<const N: usize>() -> (TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = std::array::from_fn(|k| folder.path().join(k.to_string()));
    (folder, out)
}
