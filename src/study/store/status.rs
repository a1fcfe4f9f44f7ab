//! Statuses of a case that a study adds to those of a run.

/// Status of a case whose search for constants found no further step before it settled.
pub const NOT_SETTLED: &str = "SearchNotSettled";
/// Status of a case whose search for constants ran out of time; the next run continues from its answer.
pub const OUT_OF_TIME: &str = "SearchOutOfTime";
/// Status of a case whose curves do not determine every constant.
pub const NOT_DETERMINED: &str = "ConstantsNotDetermined";
/// Status of a scene that was refused before the run.
pub const REFUSED: &str = "Refused";
/// Status of a run that ended in a panic: a bug of this program.
pub const PANICKED: &str = "Panicked";
/// Status of a case whose process died from lack of memory, a signal, or a bug.
pub const CRASHED: &str = "Crashed";
/// Status of a case that needs more memory than all cases together may take.
pub const OUT_OF_MEMORY: &str = "OutOfMemory";
/// Status of a case if one of its files was read with contents other than at the start of the run.
pub const INPUTS_CHANGED: &str = "InputsChanged";

/// The defect of a case that was not run, in reports that list the cases without a usable result.
pub const NOT_RUN: &str = "has no result";
