//! A controller in another program: JSON lines on its standard input and output, with one answer to each line.
//!
//! ```text
//! → {"durometer": "0.1.0", "columns": ["t_s", …], "signals": ["cable_shortening_m"], "t_s": 0, "memory": null}
//! ← {"ready": true}
//! → {"next_s": 0.1, "columns": {"t_s": 0, "bending_angle_deg": 0, …}, "signals": {"cable_shortening_m": 0}}
//! ← {"signals": {"cable_shortening_m": 0.001}, "memory": …, "stop": false, "save": false}
//! → {"end": "Converged", "columns": {…}}
//! ```
//!
//! All keys of an answer may be absent, and none may occur twice in one object. Numbers are read and written without losing a bit. Standard error is passed
//! on.

use super::strict_json::Strict;
use super::{ControlError, Controller, Observation, Opening, Reply};
use crate::scene::error::hint;
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::subprocess::ends_with_parent;
use serde::Deserialize;
use serde::de::Error;
use serde_json::{Map, Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// Interval at which the flag that stops the run is checked.
const LOOK: Duration = Duration::from_millis(50);

/// Longest line that a controller may write \[bytes\].
const LONGEST: u64 = 16 << 20;
/// Largest number of lines that may wait to be read.
const WAITING: usize = 16;

/// A child process that answers line by line.
pub struct Process {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<Line>,
    /// Whether another line was written together with the last answer
    unasked: bool,
    timeout: Duration,
    stop: Option<Arc<AtomicBool>>,
    columns: Vec<String>,
    signals: Vec<String>,
    identity: String,
    /// Time of the last grid point for which it was asked \[s\]
    t: f64,
    /// Time spent waiting for its answers
    pub waited: Duration,
}

/// A line of its output.
struct Line {
    /// An error holds the beginning of a line that is too long
    text: Result<String, String>,
    /// Whether the next line had arrived with it
    is_followed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ready {
    ready: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
struct Answer {
    signals: Map<String, Value>,
    memory: Value,
    stop: bool,
    save: bool,
}

/// Deserializes a message from an object. A list of values without names is not a message.
fn of_object<A: for<'a> Deserialize<'a>>(value: Value) -> serde_json::Result<A> {
    if value.is_object() { serde_json::from_value(value) } else { Err(Error::custom("it is no object")) }
}

impl Process {
    /// Starts the command. Each answer may take `timeout`, or until `stop` is set. On Linux the process ends with the thread that starts it.
    ///
    /// # Errors
    ///
    /// [`ControlError::Command`] where the quotes of the command do not close, [`ControlError::Start`] where it cannot be started.
    pub fn start(command: &str, timeout: Duration, stop: Option<Arc<AtomicBool>>) -> Result<Self, ControlError> {
        // On Windows a backslash is part of a path
        let written = if cfg!(windows) { command.replace('\\', r"\\") } else { command.into() };
        let words = shlex::split(&written).filter(|words| !words.is_empty());
        let words = words.ok_or_else(|| ControlError::Command { command: command.into() })?;
        // Computed from the files as they are before the program runs, which may write to some of them
        let identity = identity(&words);
        let failed = |reason: String| ControlError::Start { command: command.into(), reason };
        let mut process = Command::new(&words[0]);
        process.args(&words[1..]).stdin(Stdio::piped()).stdout(Stdio::piped());
        ends_with_parent(&mut process);
        let mut child = process.spawn().map_err(|e| failed(e.to_string()))?;
        let (input, output) = (child.stdin.take(), child.stdout.take().expect("it is piped"));
        // A program that writes without being asked blocks until its lines are read
        let (sender, lines) = sync_channel(WAITING);
        // Ends with the child process, or when there is no receiver any more.
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            while let Some(text) = line(&mut output) {
                let ends = text.is_err();
                let is_followed = output.buffer().contains(&b'\n');
                if sender.send(Line { text, is_followed }).is_err() || ends {
                    break;
                }
            }
        });
        let (columns, signals) = (Vec::new(), Vec::new());
        Ok(Self {
            child,
            input,
            lines,
            unasked: false,
            timeout,
            stop,
            columns,
            signals,
            identity,
            t: 0.0,
            waited: Duration::ZERO,
        })
    }

    fn stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    fn named(&self, row: &[f64]) -> Value {
        self.columns.iter().cloned().zip(row.iter().map(|v| json!(v))).collect::<Map<_, _>>().into()
    }

    fn tell(&mut self, message: &Value) -> Result<(), ControlError> {
        let line = format!("{message}\n");
        let told = self.input.as_mut().is_some_and(|i| i.write_all(line.as_bytes()).and_then(|()| i.flush()).is_ok());
        if told { Ok(()) } else { Err(self.dead()) }
    }

    fn ask<A: for<'a> Deserialize<'a>>(&mut self, message: &Value) -> Result<(A, String), ControlError> {
        let start = Instant::now();
        // Otherwise every later answer would be taken for that of the next message.
        let early = if self.unasked { self.lines.recv().ok() } else { self.lines.try_recv().ok() };
        if let Some(Line { text: Ok(line), .. }) = early {
            let fact = "nothing had asked for this line".to_string();
            return Err(self.refuse(&line, fact, "answer each message with one line"));
        }
        self.tell(message)?;
        let line = loop {
            match self.lines.recv_timeout(LOOK.min(self.timeout.saturating_sub(start.elapsed()))) {
                Ok(Line { text: Ok(line), is_followed }) => {
                    self.unasked = is_followed;
                    break line;
                }
                Ok(Line { text: Err(begin), .. }) => {
                    let fact = format!("this line has more than {} MiB", LONGEST >> 20);
                    return Err(self.refuse(&begin, fact, "end each answer with a line feed"));
                }
                Err(RecvTimeoutError::Timeout) if self.stopped() => return Err(ControlError::Stopped { t: self.t }),
                Err(RecvTimeoutError::Timeout) if start.elapsed() < self.timeout => {}
                Err(RecvTimeoutError::Timeout) => {
                    return Err(ControlError::Late { seconds: self.timeout.as_secs_f64(), t: self.t });
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.dead()),
            }
        };
        self.waited += start.elapsed();
        match serde_json::from_str(&line).and_then(|Strict(value)| of_object(value)) {
            Ok(answer) => Ok((answer, line)),
            Err(e) => Err(self.refuse(&line, format!("that is no answer: {e}"), "write one JSON object a line")),
        }
    }

    fn refuse(&self, line: &str, fact: String, remedy: &str) -> ControlError {
        // The start of a long line is enough to recognise it.
        let line =
            if line.chars().count() > 200 { line.chars().take(200).chain(['…']).collect() } else { line.into() };
        ControlError::Answer { line, t: self.t, fact, remedy: remedy.into() }
    }

    fn dead(&mut self) -> ControlError {
        // Its output is closed: it is about to end, or it is of no further use.
        let patience = Instant::now();
        let mut status = None;
        while status.is_none() && patience.elapsed() < Duration::from_secs(1) {
            status = self.child.try_wait().ok().flatten();
            std::thread::sleep(Duration::from_millis(5));
        }
        let how = status.map_or_else(|| "its output is closed".into(), |s| s.to_string());
        ControlError::Dead { how, t: self.t }
    }
}

/// The digest of a command: of its words, where a word that is the path of a file is replaced by the contents of the file.
fn identity(words: &[String]) -> String {
    let content =
        |word: &String| storage::read(Path::new(word), DATA_LIMIT).map(sha256).unwrap_or_else(|_| word.clone());
    format!("program {}", sha256(format!("{:?}", words.iter().map(content).collect::<Vec<_>>())))
}

/// The next line, or as an error the beginning of a line that is too long; `None` after the last line.
fn line(output: &mut impl BufRead) -> Option<Result<String, String>> {
    let mut bytes = Vec::new();
    output.take(LONGEST).read_until(b'\n', &mut bytes).ok().filter(|n| *n > 0)?;
    let ends = bytes.last() == Some(&b'\n') || (bytes.len() as u64) < LONGEST;
    bytes.truncate(if ends { bytes.len() } else { 1000 });
    let text = String::from_utf8_lossy(&bytes).trim_end_matches('\n').to_string();
    Some(if ends { Ok(text) } else { Err(text) })
}

impl Controller for Process {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        (self.columns, self.signals) = (opening.columns.to_vec(), opening.signals.to_vec());
        self.t = opening.t;
        let hello = json!({
            "durometer": env!("CARGO_PKG_VERSION"),
            "columns": opening.columns,
            "signals": opening.signals,
            "t_s": opening.t,
            "memory": opening.memory,
        });
        let (Ready { ready }, line) = self.ask(&hello)?;
        if ready { Ok(()) } else { Err(self.refuse(&line, "it is not ready".into(), "answer {\"ready\": true}")) }
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        self.t = observation.row[0];
        let values: Map<String, Value> = self.signals.iter().cloned().zip(signals.iter().map(|v| json!(v))).collect();
        let question = json!({ "next_s": observation.next, "columns": self.named(observation.row), "signals": values });
        let (answer, line) = self.ask::<Answer>(&question)?;
        for (name, value) in &answer.signals {
            let Some(k) = self.signals.iter().position(|s| s == name) else {
                let fact = format!("it may not set \"{name}\"");
                return Err(self.refuse(&line, fact, &hint(name, &self.signals)));
            };
            signals[k] = value.as_f64().ok_or_else(|| {
                self.refuse(&line, format!("\"{name}\" is {value}"), "give a finite number in SI units")
            })?;
        }
        Ok(Reply { stop: answer.stop, save: answer.save, memory: answer.memory })
    }

    fn identity(&self) -> Option<String> {
        Some(self.identity.clone())
    }

    fn end(&mut self, row: &[f64], status: &str) {
        let message = json!({ "end": status, "columns": self.named(row) });
        // The process may have ended already, and then needs no last message.
        self.tell(&message).ok();
    }
}

impl Drop for Process {
    /// Closes its input; the process may then take as long as for an answer to end by itself.
    fn drop(&mut self) {
        drop(self.input.take());
        let patience = Instant::now();
        while patience.elapsed() < self.timeout && !self.stopped() {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
