//! A case in a process of its own: whatever kills the process is the status of this case, and ends no other.
//!
//! The process reads one [`Order`] as a line of JSON from its standard input, computes the case and stores it. On its standard output it reports its
//! progress and how it ended, in lines of JSON ([`Said`]). Before the first factorisation it reports the memory that it needs, and waits for the line
//! `go`. A line `shared` on its input means that another case has started in the meantime, a line `threads 2` that it may use two threads from now on.
//! The end of its input means that the process that requested the case is gone; it then ends itself with all processes that it has started, which form
//! a process group.

use crate::catalogue::Launch;
use crate::live::Access;
use crate::scene::Progress;
use crate::study::run::compute::{Follow, compute};
use crate::study::run::memory::Admission;
use crate::study::run::task::Task;
use crate::study::store::folder::Store;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Number of the last lines of the standard error of a process that are kept in its status.
const KEPT_LINES: usize = 6;
/// Largest number of characters of each of these lines.
const KEPT_CHARACTERS: usize = 300;
/// Flag of `CreateProcess` on Windows.
#[cfg(windows)]
const CREATE_NEW_PROCESS_GROUP: u32 = 0x200;
/// Interval between checks whether to stop.
const LOOK: Duration = Duration::from_millis(50);

/// The case that a process must compute, and the folder of its result.
#[derive(Serialize, Deserialize)]
pub struct Order {
    pub dir: PathBuf,
    pub task: Task,
    /// Access for browsers to its live view, if there is one
    pub live: Option<Access>,
}

/// A message from a process.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Said {
    /// An output line of the mesher
    Meshing(String),
    Progress {
        t: f64,
        end: f64,
    },
    /// The memory that the case is going to need \[bytes\]; it waits for the line `go`
    Needs(u64),
    /// The live view is served at this port, which the process that requested the case passes on
    Serves(u16),
    /// The result is stored
    Stored,
    /// The computation crashed with this status and reason; an earlier result may have been kept
    Broke {
        status: String,
        why: String,
    },
    /// The input was refused, or the result could not be stored
    Failed(String),
}

/// Callbacks that follow the process of a case.
pub trait Wants {
    /// Receives a message, or `None` if there has been none for a while; returns false to stop the process
    fn said(&mut self, said: Option<&Said>) -> bool;
    /// Whether another case is running at this moment.
    fn shared(&self) -> bool;
    /// Number of threads that it may use at this moment.
    fn threads(&self) -> usize;
    /// Whether it may take this amount of memory \[bytes\].
    fn admit(&mut self, bytes: u64) -> Admission;
}

/// How the process of a case ended.
pub enum End {
    Stored,
    /// The computation crashed with this status and reason
    Broke(String, String),
    Stopped,
    Failed(String),
    /// It needs more memory than is available \[bytes\]
    TooLarge(u64),
    /// It died; the text says how, with its last output lines and a remedy
    Died(String),
}

/// Computes the case of an order in this process, which computes nothing else.
pub fn obey(order: &str, shared: &AtomicBool, admitted: &mut dyn FnMut() -> bool, say: &mut dyn FnMut(&Said)) {
    let said = std::cell::RefCell::new(say);
    let say = |what: Said| (said.borrow_mut())(&what);
    let order: Order = match serde_json::from_slice(order.as_bytes()) {
        Ok(order) => order,
        Err(e) => return say(Said::Failed(format!("the order of a case cannot be read: {e}"))),
    };
    let mut serves = |port| say(Said::Serves(port));
    let mut follow = Follow {
        meshing: &mut |line| say(Said::Meshing(line.into())),
        progress: &mut |Progress { t, end }| {
            say(Said::Progress { t, end });
            true
        },
        shared: &|| shared.load(Ordering::Relaxed),
        admit: &mut |bytes| {
            say(Said::Needs(bytes));
            admitted()
        },
        live: order.live.as_ref().map(|access| (access, &mut serves as &mut dyn FnMut(u16))),
        own_process: true,
    };
    say(match compute(&order.task, &Store::at(&order.dir), &mut follow) {
        Ok(Some(record)) if record.broke() => {
            Said::Broke { status: record.status, why: record.status_detail.unwrap_or_default() }
        }
        Ok(_) => Said::Stored,
        Err(why) => Said::Failed(why.to_string()),
    });
}

/// Computes a case in a process of `program`, started as `program worker`.
pub fn compute_apart(program: &Launch, order: &Order, wants: &mut dyn Wants) -> std::io::Result<End> {
    let mut process = Process::start(program, order)?;
    let (mut end, mut told, mut asks, mut threads) = (None, false, None, 1);
    loop {
        let said = match process.lines.recv_timeout(LOOK) {
            Ok(line) => serde_json::from_slice(line.as_bytes()).ok(),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if let Some(Said::Needs(bytes)) = said {
            asks = Some(bytes);
        }
        match asks.map(|bytes| (bytes, wants.admit(bytes))) {
            Some((_, Admission::Now)) => {
                asks = None;
                process.input.write_all(b"go\n").ok();
            }
            Some((bytes, Admission::Never)) => return Ok(End::TooLarge(bytes)),
            Some((_, Admission::Later)) | None => {}
        }
        if !told && wants.shared() {
            told = true;
            // A process that has just ended no longer reads it
            process.input.write_all(b"shared\n").ok();
        }
        if wants.threads() != threads {
            threads = wants.threads();
            writeln!(process.input, "threads {threads}").ok();
        }
        match said {
            Some(Said::Stored) => end = Some(End::Stored),
            Some(Said::Broke { status, why }) => end = Some(End::Broke(status, why)),
            Some(Said::Failed(why)) => end = Some(End::Failed(why)),
            said if wants.said(said.as_ref()) => {}
            _ => return Ok(End::Stopped),
        }
    }
    let (status, lines) = process.finish()?;
    Ok(end.unwrap_or_else(|| End::Died(death(status, &lines))))
}

/// A running process; it is ended with its group when this is dropped.
struct Process {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
    errors: Option<JoinHandle<VecDeque<String>>>,
}

impl Process {
    fn start(program: &Launch, order: &Order) -> std::io::Result<Self> {
        let mut command = program.command();
        command.arg("worker").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // The last lines must be the message, not the backtrace
        command.env("RUST_BACKTRACE", "0");
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt;
            // A separate process group: Ctrl-C reaches only the process that decides what it means, and all processes started here end together
            command.process_group(0);
        }
        #[cfg(windows)]
        {
            use std::os::windows::process::CommandExt;
            // Keeps Ctrl-C from reaching it
            command.creation_flags(CREATE_NEW_PROCESS_GROUP);
        }
        let mut child = command.spawn()?;
        let mut input = child.stdin.take().expect("it is piped");
        let (output, errors) = (child.stdout.take().expect("it is piped"), child.stderr.take().expect("it is piped"));
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            let mut said = BufReader::new(output).lines().map_while(Result::ok);
            said.all(|line| sender.send(line).is_ok())
        });
        let errors = Some(std::thread::spawn(move || last_lines(errors)));
        let order = serde_json::to_string(order).expect("numbers, strings and string keys only");
        // If it dies at once, its status shows that
        input.write_all(order.as_bytes()).and_then(|()| input.write_all(b"\n")).ok();
        Ok(Self { child, input, lines, errors })
    }

    /// Waits for the end; returns the status and the last lines of the standard error.
    fn finish(mut self) -> std::io::Result<(ExitStatus, VecDeque<String>)> {
        // Its output has ended, so that its status is determined
        self.end_group();
        let status = self.child.wait()?;
        let lines = self.errors.take().and_then(|reader| reader.join().ok());
        Ok((status, lines.unwrap_or_default()))
    }

    /// Ends the process and those that it has started.
    fn end_group(&mut self) {
        #[cfg(unix)]
        {
            use nix::sys::signal::{Signal, killpg};
            killpg(nix::unistd::Pid::from_raw(self.child.id() as i32), Signal::SIGKILL).ok();
        }
        self.child.kill().ok();
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(Some(_))) {
            return;
        }
        self.end_group();
        self.child.wait().ok();
    }
}

fn last_lines(stream: impl Read) -> VecDeque<String> {
    let mut reader = BufReader::new(stream);
    let mut kept = VecDeque::new();
    loop {
        let mut line = Vec::new();
        // A line without an end is read in pieces
        match reader.by_ref().take(1 << 16).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return kept,
            Ok(_) => {}
        }
        let text = String::from_utf8_lossy(&line);
        if kept.len() == KEPT_LINES {
            kept.pop_front();
        }
        kept.push_back(text.trim_end().chars().take(KEPT_CHARACTERS).collect());
    }
}

/// How a process died, and a remedy.
fn death(status: ExitStatus, lines: &VecDeque<String>) -> String {
    let said = |words: &str| lines.iter().any(|line| line.contains(words));
    #[cfg(unix)]
    let killed = std::os::unix::process::ExitStatusExt::signal(&status) == Some(9);
    #[cfg(not(unix))]
    let killed = false;
    let remedy = if said("memory allocation of") || said("allocation failed") {
        "the memory was not sufficient; run fewer cases at a time with --jobs, set numerics.factor_memory, or take a coarser mesh"
    } else if killed {
        "it was killed from outside, as the system does when memory is short; run fewer cases at a time with --jobs, or take a coarser mesh"
    } else if said("overflowed its stack") {
        "please report this with the scene; a larger stack may help: ulimit -s unlimited"
    } else {
        "this is a bug of the program or of a library, please report it with the scene"
    };
    let last: Vec<&str> = lines.iter().map(String::as_str).filter(|line| !line.is_empty()).collect();
    let last = if last.is_empty() { String::new() } else { format!(" ({})", last.join(" / ")) };
    format!("the process of the case ended with {status}{last}: {remedy}")
}
