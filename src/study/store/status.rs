//! Statuses of a case that a study adds to those of a run.

/// Status of a case whose search for constants found no further step before it had settled.
pub const NOT_SETTLED: &str = "SearchNotSettled";
/// Status of a case whose search for constants had no time left; the next run goes on from its answer.
pub const OUT_OF_TIME: &str = "SearchOutOfTime";
/// Status of a case whose curves do not determine every constant.
pub const NOT_DETERMINED: &str = "ConstantsNotDetermined";
/// Status of a scene that was refused before the run.
pub const REFUSED: &str = "Refused";
/// Status of a run that ended in a panic: a bug of this program.
pub const PANICKED: &str = "Panicked";
/// Status of a case whose process died: of memory, of a signal, or of a bug.
pub const CRASHED: &str = "Crashed";
/// Status of a case that needs more memory than all cases together may take.
pub const OUT_OF_MEMORY: &str = "OutOfMemory";
/// Status of a case one of whose files was read with other contents than it had when the run began.
pub const INPUTS_CHANGED: &str = "InputsChanged";

/// The defect of a case that was not run, where a report lists the cases without a usable result.
pub const NOT_RUN: &str = "has no result";
