//! Calls of the program.

use std::borrow::BorrowMut;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The folder of the project.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// How a call has ended, and what it has printed.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ended {
    pub fn of(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    pub fn is_success(&self) -> bool {
        self.code == Some(0)
    }

    /// Standard output, then standard error.
    pub fn said(&self) -> String {
        format!("{}{}", self.out, self.err)
    }

    pub fn code_and_said(&self) -> (Option<i32>, String) {
        (self.code, self.said())
    }
}

/// The program with these arguments, in this folder.
pub fn program(folder: impl AsRef<Path>, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.args(arguments).current_dir(folder);
    command
}

/// The same without a mesher, or with that of the folder.
pub fn without_mesher(folder: impl AsRef<Path>, arguments: &[&str]) -> Command {
    let mut command = program(&folder, arguments);
    let mesher = folder.as_ref().join("mesher");
    match mesher.is_file() {
        true => command.env("DUROMETER_HOME", folder.as_ref()).env("DUROMETER_PYTHON", mesher),
        false => command.env("DUROMETER_PYTHON", "no-such-python"),
    };
    command
}

/// Calls a program and waits for its end.
pub fn ended(mut command: impl BorrowMut<Command>) -> Ended {
    Ended::of(&command.borrow_mut().output().expect("the program starts"))
}

/// Calls the program with these arguments, in this folder.
pub fn durometer(folder: impl AsRef<Path>, arguments: &[&str]) -> Ended {
    ended(program(folder, arguments))
}

/// The same with a text on standard input.
pub fn durometer_with(folder: impl AsRef<Path>, arguments: &[&str], input: &str) -> Ended {
    let mut command = program(folder, arguments);
    let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = pipes.spawn().expect("the program starts");
    child.stdin.take().expect("it is piped").write_all(input.as_bytes()).ok();
    Ended::of(&child.wait_with_output().expect("the program ends"))
}

/// Standard output and error of a call without a mesher that must end with `code`.
pub fn call(folder: impl AsRef<Path>, arguments: &[&str], code: i32) -> (String, String) {
    let output = without_mesher(folder, arguments).output().expect("the program starts");
    said(&output, &format!("{arguments:?}"), code)
}

/// Standard output and error of a program that must have ended with `code`.
pub fn said(output: &Output, call: &str, code: i32) -> (String, String) {
    let Ended { code: found, out, err } = Ended::of(output);
    assert_eq!(found, Some(code), "{call}\n{out}\n{err}");
    (out, err)
}
