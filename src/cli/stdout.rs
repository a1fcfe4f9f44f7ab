//! The standard output, to which all commands print with `say!`. A failure to write is reported as an error at the end of the command.
//!
//! Until then the command continues, so that the files of its results are written anyway.

use durometer::math::threads::locked;
use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// The first failure to write to the standard output.
static FAILURE: Mutex<Option<String>> = Mutex::new(None);

/// Prints a line like `println!`, but does not panic if it cannot be written.
macro_rules! say {
    ($($text:tt)*) => { $crate::stdout::line(format_args!($($text)*)) };
}

/// The standard output; its first failure is recorded.
pub struct Output;

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        kept(io::stdout().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        kept(io::stdout().flush())
    }
}

/// Writes one line to the standard output.
pub fn line(text: Arguments) {
    Output.write_all(format!("{text}\n").as_bytes()).ok();
}

/// Returns `result` unchanged and records the first failure. A closed pipe does not count as a failure, because its reader has what it wants.
pub fn kept<T>(result: io::Result<T>) -> io::Result<T> {
    result.inspect_err(|error| {
        if !matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Interrupted) {
            locked(&FAILURE).get_or_insert_with(|| error.to_string());
        }
    })
}

/// Flushes the standard output; returns an error if something could not be written.
pub fn end() -> Result<(), String> {
    Output.flush().ok();
    let failure = locked(&FAILURE).take();
    let Some(failure) = failure else { return Ok(()) };
    // Without the system's error number
    let fact = failure.split(" (os error").next().unwrap_or_default();
    Err(format!("the standard output cannot be written: {fact}; redirect it to where there is room; files are written"))
}
