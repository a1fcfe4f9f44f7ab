//! Result of a command and its exit codes.

use std::process::ExitCode;

/// Exit code of a command, or the error that ended it.
pub type Outcome = Result<ExitCode, Box<dyn std::error::Error>>;

/// Exit code when some case did not complete.
pub const INCOMPLETE: u8 = 3;
/// Exit code when the input is refused.
pub const BAD_INPUT: u8 = 2;
