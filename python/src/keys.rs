//! Keys of scenes that Python gives.

use crate::error::{input, refused};
use durometer::scene::ParameterKey;
use pyo3::prelude::*;

/// Keys of a scene, one at least.
pub fn parsed(keys: &[String]) -> PyResult<Vec<ParameterKey>> {
    if keys.is_empty() {
        return Err(input("no key is given", "write for example [\"laws.rubber.mu\"]"));
    }
    keys.iter().map(|key| key.parse()).collect::<Result<_, _>>().map_err(refused)
}
