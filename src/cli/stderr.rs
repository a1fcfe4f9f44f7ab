//! The standard error: messages go to it by `tell!`. One that cannot be written is lost, and the command goes on.

use std::fmt::Arguments;
use std::io::Write;

/// Prints a message, like `eprintln!`, which panics where it cannot.
macro_rules! tell {
    ($($text:tt)*) => { $crate::stderr::line(format_args!($($text)*)) };
}

/// Writes one line.
pub fn line(text: Arguments) {
    std::io::stderr().write_all(format!("{text}\n").as_bytes()).ok();
}
