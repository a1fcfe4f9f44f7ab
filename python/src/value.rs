//! Values of Python as those of TOML, arrays of Python as numbers, and results of the library as dictionaries.

use crate::error::input;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;

/// The value of a key of a scene: text with a unit, a number, a flag, a list or a dictionary. Numbers of numpy count as numbers.
pub fn toml_of(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if value.is_instance_of::<PyString>() {
        return Ok(value.extract::<String>()?.into());
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.extract::<i64>()?.into());
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(value.extract::<f64>()?.into());
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| Ok((key.extract()?, toml_of(&value)?));
        return Ok(toml::Value::Table(table.iter().map(entry).collect::<PyResult<_>>()?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let entries = value.try_iter()?.map(|entry| toml_of(&entry?)).collect::<PyResult<_>>()?;
        return Ok(toml::Value::Array(entries));
    }
    // Numbers and arrays of numpy know their value in Python
    if let Ok(plain) = value.call_method0("tolist")
        && !plain.is(value)
    {
        return toml_of(&plain);
    }
    let kind = value.get_type().name()?;
    Err(input(
        &format!("a value of the type {kind} is none of a scene"),
        "give a text with a unit such as \"18 kPa\", a number, True or False, a list or a dictionary",
    ))
}

/// A value that the library would write as JSON, as objects of Python.
pub fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|e| input(&format!("the result cannot be written: {e}"), ""))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Numbers of a list or an array of one index, all finite.
pub fn numbers(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = floats(name, given)?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() != 1 {
        return Err(input(&format!("{name} has the shape {shape:?}"), "give a list or an array of one index"));
    }
    let values: Vec<f64> = array.extract()?;
    finite(name, &values)?;
    Ok(values)
}

/// The rows of an array of `width` columns, all finite.
pub fn rows(name: &str, given: &Bound<'_, PyAny>, width: usize) -> PyResult<Vec<f64>> {
    let array = floats(name, given)?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != width {
        return Err(input(&format!("{name} has the shape {shape:?}"), &format!("give one of shape (n, {width})")));
    }
    let values: Vec<f64> = array.call_method0("ravel")?.extract()?;
    finite(name, &values)?;
    Ok(values)
}

fn floats<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = given.py();
    let named = PyDict::new(py);
    named.set_item("dtype", "float64")?;
    py.import("numpy")?.call_method("asarray", (given,), Some(&named)).map_err(|e| {
        input(&format!("{name} is no array of numbers: {}", e.value(py)), "give a list of numbers or an array of numpy")
    })
}

fn finite(name: &str, values: &[f64]) -> PyResult<()> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(input(&format!("{name} has the value {} at index {k}", values[k]), "leave such values out")),
        None => Ok(()),
    }
}

/// The unit at the end of the name of a column; `1` of a number without one.
pub fn unit(column: &str) -> &'static str {
    durometer::scene::unit_of_column(column)
}
