//! The standard error, to which `tell!` prints. A message that cannot be written is lost, and the command continues.

use std::fmt::Arguments;
use std::io::Write;

/// Prints a message like `eprintln!`, but does not panic if it cannot be written.
macro_rules! tell {
    ($($text:tt)*) => { $crate::stderr::line(format_args!($($text)*)) };
}

/// Writes one line to the standard error.
pub fn line(text: Arguments) {
    std::io::stderr().write_all(format!("{text}\n").as_bytes()).ok();
}
