//! Threads of the solver: the number that a run may use, and the refusal of forked processes, which lack them.

use crate::error::input;
use durometer::math::threads::{alone, are_left_behind, available, count, is_alone, use_threads};
use durometer_commands::arguments;
use pyo3::prelude::*;

/// Reads a number of threads, or of cases that run at the same time, with the limits of the command line; the number of cores if none is given.
pub fn number(given: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
    let Some(given) = given else { return Ok(available()) };
    let whole =
        given.call_method0("__index__").map_err(|_| input(&format!("{given} is no whole number"), "give 1 or more"))?;
    arguments::threads(&whole.to_string()).map_err(crate::error::refused)
}

/// Sets the number of threads for the work that follows; within a law or a controller, work always has one thread.
pub fn set(given: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let number = number(given)?;
    if !is_alone() {
        use_threads(number);
    }
    Ok(())
}

/// Calls Python code for which a thread of the solver waits, such as a law. A scene that this code runs has one thread, because all other threads may be
/// waiting for such code too.
pub fn ask<T>(code: impl for<'py> FnOnce(Python<'py>) -> T) -> T {
    alone(|| Python::attach(code))
}

/// Refuses work with threads in a process that was forked after they had started, and that therefore has none of them.
pub fn check_fork() -> PyResult<()> {
    if count() < 2 || !are_left_behind() {
        return Ok(());
    }
    Err(input(
        "this process was forked when the solver had started its threads, and has none of them",
        "start processes by multiprocessing.get_context(\"spawn\"), or give threads=1; what takes no threads has those of the call before",
    ))
}
