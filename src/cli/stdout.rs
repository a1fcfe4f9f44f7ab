//! The standard output: all commands write to it by `say!`, and an output that cannot be written is an error at the end of the command.
//!
//! A command goes on meanwhile, so that the files of its results are written all the same.

use durometer::math::threads::locked;
use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

/// Why the standard output could not be written, the first time.
static FAILURE: Mutex<Option<String>> = Mutex::new(None);

/// Prints a line, like `println!`, which panics where it cannot.
macro_rules! say {
    ($($text:tt)*) => { $crate::stdout::line(format_args!($($text)*)) };
}

/// The standard output, whose failure is kept.
pub struct Output;

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        kept(io::stdout().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        kept(io::stdout().flush())
    }
}

/// Writes one line.
pub fn line(text: Arguments) {
    Output.write_all(format!("{text}\n").as_bytes()).ok();
}

/// The same result, of which the first failure is kept. A reader that has closed the pipe has what it wants.
pub fn kept<T>(result: io::Result<T>) -> io::Result<T> {
    result.inspect_err(|error| {
        if !matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Interrupted) {
            locked(&FAILURE).get_or_insert_with(|| error.to_string());
        }
    })
}

/// Writes what is not written yet, and says why something could not be written.
pub fn end() -> Result<(), String> {
    Output.flush().ok();
    let failure = locked(&FAILURE).take();
    let Some(failure) = failure else { return Ok(()) };
    // Without the number of the system
    let fact = failure.split(" (os error").next().unwrap_or_default();
    Err(format!("the standard output cannot be written: {fact}; redirect it to where there is room; files are written"))
}
