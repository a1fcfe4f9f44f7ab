//! Result folders that belong to a single command.

use durometer::storage::results::{Results, ResultsError, Subject};
use std::path::{Path, PathBuf};

/// The flag of commands that write into a result folder of their own.
#[derive(clap::Args)]
pub struct ReplaceArgs {
    /// Replace results of another command or of other input in the folder of the results
    #[arg(long)]
    replace: bool,
}

impl ReplaceArgs {
    /// Checks that the results of a command on these files may be written into the folder; other results there are only replaced with `--replace`.
    /// `choice` distinguishes different results that the command can compute from the same files.
    pub fn check(
        &self,
        out: &Path,
        command: &str,
        choice: impl Into<String>,
        files: &[PathBuf],
    ) -> Result<Results, ResultsError> {
        Results::check(out, Subject::read(command, choice, files)?, self.replace)
    }
}
