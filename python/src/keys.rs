//! Keys of scenes and other names that are given as lists in Python.

use crate::error::{input, refused};
use crate::value::kind;
use durometer::scene::ParameterKey;
use pyo3::prelude::*;
use pyo3::types::PyString;

/// Extracts names from a list or another iterable; refuses a text, which would be read letter by letter.
pub fn names(what: &str, given: &Bound<'_, PyAny>, example: &str) -> PyResult<Vec<String>> {
    let wrong = || {
        input(
            &format!("{what} is of the type {}, and no list of names", kind(given)),
            &format!("write for example {example}"),
        )
    };
    if given.is_instance_of::<PyString>() {
        return Err(wrong());
    }
    given.try_iter().map_err(|_| wrong())?.map(|name| name?.extract().map_err(|_| wrong())).collect()
}

/// Parses keys of a scene; there must be at least one.
pub fn parsed(keys: &Bound<'_, PyAny>) -> PyResult<Vec<ParameterKey>> {
    let keys = names("keys", keys, "[\"laws.rubber.mu\"]")?;
    if keys.is_empty() {
        return Err(input("no key is given", "write for example [\"laws.rubber.mu\"]"));
    }
    keys.iter().map(|key| key.parse()).collect::<Result<_, _>>().map_err(refused)
}
