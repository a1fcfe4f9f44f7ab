//! How a command ended, and the corresponding exit code.

/// The outcome of a command, or the error that ended it: refused input, or a file that cannot be read or written.
pub type CommandResult = Result<Outcome, Box<dyn std::error::Error>>;

/// The outcome of a command that ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything requested is done, and its result can be used
    Complete,
    /// `doctor`: something that new meshes need is missing on this machine
    NotReady,
    /// Ctrl-C or SIGTERM ended the command before its result was written
    Interrupted,
    /// `run`, `robustness`, `simulate`: a run, or a derivative of it, did not reach its end
    RunIncomplete,
    /// `plan`: no setting is expected to meet the tolerance within the budget, or the advised run did not complete
    NotWithinBudget,
    /// `store`: some stored result is damaged, or differs from that of an archive
    NotSound,
    /// `compare`: a value changed beyond its error bar, the verdict changed, or a case is missing or no longer converges
    ChangedBeyondBars,
    /// `fit`: the data do not determine the constants
    NotDetermined,
}

/// Exit code if the standard output could not be written, however the command ended.
pub const UNWRITTEN: u8 = 2;

/// Returns the exit code of a command: 0 done, 2 refused or not ready, 3 ran without a complete result.
pub fn exit_code(result: &CommandResult) -> u8 {
    match result {
        Ok(Outcome::Complete) => 0,
        Err(_) | Ok(Outcome::NotReady) => 2,
        Ok(
            Outcome::Interrupted
            | Outcome::RunIncomplete
            | Outcome::NotWithinBudget
            | Outcome::NotSound
            | Outcome::ChangedBeyondBars
            | Outcome::NotDetermined,
        ) => 3,
    }
}
