//! Converts errors of the library to the exceptions of `durometer.errors`, which carry status, fact and remedy.

use durometer::scene::SceneError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::error::Error;

/// Returns the `InputError` for refused input. Messages of the library give the remedy after the fact and a semicolon.
pub fn refused<E: Into<Box<dyn Error>>>(error: E) -> PyErr {
    let error: Box<dyn Error> = error.into();
    if let Some(SceneError::Content { file, place, fact, remedy }) = error.downcast_ref() {
        return input(&format!("{}: {place}: {fact}", file.display()), remedy);
    }
    // In Python the recorder of derivatives is a method, and the folder of the results an argument
    let message = error.to_string().replace("SensitivityRecorder", "Scene.sensitivities");
    let message = message.replace("with --out", "as `out`");
    let (fact, remedy) = split(&message);
    input(fact, remedy)
}

/// Splits a message of the library into fact and remedy.
pub fn split(message: &str) -> (&str, &str) {
    message.split_once("; ").unwrap_or((message, ""))
}

/// Returns an `InputError` with this fact and remedy.
pub fn input(fact: &str, remedy: &str) -> PyErr {
    made("InputError", &[fact, remedy], None)
}

/// Returns the `RunError` of an incomplete run, search or study, with the partial result.
pub fn incomplete(status: &str, fact: &str, remedy: &str, result: Py<PyAny>) -> PyErr {
    made("RunError", &[fact, remedy, status], Some(result))
}

/// Sets the `result` of an exception to the partial result of this call, if it accepts the attribute. A `result` that it already has is from another
/// call: a nested one that did not complete, or an earlier one whose exception object is raised again.
pub fn with_result(py: Python<'_>, why: PyErr, result: Py<PyAny>) -> PyErr {
    why.value(py).setattr("result", result).ok();
    why
}

/// Returns the `OutOfDomain` exception of a law that is not defined at some F.
pub fn outside(fact: &str) -> PyErr {
    made("OutOfDomain", &[fact], None)
}

/// Whether an exception is `OutOfDomain`: a law is not defined at some F.
pub fn is_outside(py: Python<'_>, why: &PyErr) -> bool {
    py.import("durometer.errors")
        .and_then(|errors| errors.getattr("OutOfDomain"))
        .is_ok_and(|class| why.is_instance(py, &class))
}

fn made(class: &str, texts: &[&str], result: Option<Py<PyAny>>) -> PyErr {
    Python::attach(|py| {
        let named = PyDict::new(py);
        let exception = PyTuple::new(py, texts).and_then(|texts| {
            result.map_or(Ok(()), |result| named.set_item("result", result))?;
            py.import("durometer.errors")?.getattr(class)?.call(texts, Some(&named))
        });
        exception.map_or_else(|failure| failure, PyErr::from_value)
    })
}
