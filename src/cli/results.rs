//! Folders in which a command writes its results alone.

use durometer::storage::results::{Results, ResultsError, Subject};
use std::path::{Path, PathBuf};

/// Flag of the commands with such a folder.
#[derive(clap::Args)]
pub struct ReplaceArgs {
    /// Replace results of another command or of other input in the folder of the results
    #[arg(long)]
    replace: bool,
}

impl ReplaceArgs {
    /// The folder for the results of a command of these files, unless it holds others that are to stay. `choice` tells apart the results that the
    /// command can find in the same files.
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
