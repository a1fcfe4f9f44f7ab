//! Conversion of Python values to TOML, of Python arrays to numbers, and of results of the library to dictionaries.

use crate::error::input;
use durometer::math::tensor::Mat3;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{
    PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString, PyTuple,
};
use serde::Serialize;
use std::path::PathBuf;

/// Deepest nesting of lists and dictionaries in a value; no key of a scene is nested deeper.
const DEEPEST: usize = 32;

/// Converts a value of a key of a scene: text with a unit, a number, a flag, a path, a sequence or a mapping. numpy numbers and arrays count as numbers
/// and lists.
pub fn toml_of(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    toml_within(value, DEEPEST)
}

/// Converts a value nested at most `depth` deep.
fn toml_within(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<toml::Value> {
    let Some(depth) = depth.checked_sub(1) else {
        let fact = format!("a value has lists or dictionaries that lie more than {DEEPEST} deep in each other");
        return Err(input(&fact, "give one that does not contain itself"));
    };
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if value.is_instance_of::<PyString>() {
        return Ok(value.extract::<String>()?.into());
    }
    if value.is_instance_of::<PyInt>() {
        let number = value.extract::<i64>().map_err(|_| {
            input(&format!("{value} is too large for a whole number of a scene"), "give a number with a point")
        })?;
        return Ok(number.into());
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(value.extract::<f64>()?.into());
    }
    if let Some(entries) = entries(value)? {
        let entry = |(key, value): (String, Bound<'_, PyAny>)| Ok((key, toml_within(&value, depth)?));
        return Ok(toml::Value::Table(entries.into_iter().map(entry).collect::<PyResult<_>>()?));
    }
    if value.hasattr("__fspath__")? {
        let path = value.extract::<PathBuf>()?.into_os_string().into_string();
        return path
            .map(Into::into)
            .map_err(|path| input(&format!("the path {path:?} is no text"), "name it in UTF-8"));
    }
    if is_list(value) {
        let entries = value.try_iter()?.map(|entry| toml_within(&entry?, depth)).collect::<PyResult<_>>()?;
        return Ok(toml::Value::Array(entries));
    }
    // numpy numbers and arrays convert themselves to Python values
    if let Ok(plain) = value.call_method0("tolist")
        && !plain.is(value)
    {
        return toml_within(&plain, depth);
    }
    Err(input(
        &format!("a value of the type {} is none of a scene", kind(value)),
        "give a text with a unit such as \"18 kPa\", a number, True or False, a path, a list or a dictionary",
    ))
}

/// Whether a value is a sequence other than text and bytes.
pub fn is_list(value: &Bound<'_, PyAny>) -> bool {
    let is_text = value.is_instance_of::<PyString>()
        || value.is_instance_of::<PyBytes>()
        || value.is_instance_of::<PyByteArray>();
    !is_text && value.cast::<PySequence>().is_ok()
}

/// A key and its value in a mapping.
type Entry<'py> = (String, Bound<'py, PyAny>);

/// Returns keys and values of a dictionary or another mapping; `None` if the value is not a mapping.
pub fn entries<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Vec<Entry<'py>>>> {
    let Ok(table) = value.cast::<PyMapping>() else { return Ok(None) };
    let entry = |pair: Bound<'py, PyAny>| {
        let (key, value): (Bound<'py, PyAny>, Bound<'py, PyAny>) = pair.extract()?;
        let name = key.extract::<String>();
        Ok((name.map_err(|_| input(&format!("the key {key} is no text"), "name keys by texts"))?, value))
    };
    table.items()?.iter().map(entry).collect::<PyResult<_>>().map(Some)
}

/// Returns the entries of a value that must be a mapping.
pub fn mapping<'py>(what: &str, value: &Bound<'py, PyAny>) -> PyResult<Vec<Entry<'py>>> {
    entries(value)?.ok_or_else(|| input(&format!("{what} is of the type {}", kind(value)), "give a dictionary"))
}

/// Returns the name of the type of a value.
pub fn kind(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string())
}

/// Converts a value that the library would write as JSON to Python objects.
pub fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|e| input(&format!("the result cannot be written: {e}"), ""))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Converts a TOML value to Python objects, directly because JSON has no infinity.
pub fn object_of<'py>(py: Python<'py>, value: &toml::Value) -> PyResult<Bound<'py, PyAny>> {
    use toml::Value;
    Ok(match value {
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Float(number) => number.into_pyobject(py)?.into_any(),
        Value::Boolean(flag) => flag.into_pyobject(py)?.to_owned().into_any(),
        Value::Datetime(time) => time.to_string().into_pyobject(py)?.into_any(),
        Value::Array(entries) => {
            let entries = entries.iter().map(|entry| object_of(py, entry)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, entries)?.into_any()
        }
        Value::Table(table) => {
            let entries = PyDict::new(py);
            table.iter().try_for_each(|(key, value)| entries.set_item(key, object_of(py, value)?))?;
            entries.into_any()
        }
    })
}

/// Reads the numbers of a list or a one-dimensional array, all finite.
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

/// Reads the numbers of an array of one of these shapes, row by row; messages name the first shape.
fn shaped(name: &str, given: &Bound<'_, PyAny>, shapes: &[&[usize]]) -> PyResult<Vec<f64>> {
    let array = floats(name, given)?;
    let shape = array.getattr("shape")?;
    let own: Vec<usize> = shape.extract()?;
    if !shapes.contains(&&own[..]) {
        let wanted = PyTuple::new(given.py(), shapes[0])?;
        return Err(input(&format!("{name} has the shape {shape}"), &format!("give one of shape {wanted}")));
    }
    array.call_method0("ravel")?.extract()
}

/// Reads one number; the error names `remedy`.
pub fn number(name: &str, given: &Bound<'_, PyAny>, remedy: &str) -> PyResult<f64> {
    given.extract().map_err(|why: PyErr| match why.is_instance_of::<PyException>(given.py()) {
        true => input(&format!("{name} is of the type {}, and no number", kind(given)), remedy),
        false => why,
    })
}

/// Reads two numbers of a list or an array.
pub fn pair(name: &str, given: &Bound<'_, PyAny>) -> PyResult<(f64, f64)> {
    let both = shaped(name, given, &[&[2]])?;
    Ok((both[0], both[1]))
}

fn floats<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = given.py();
    let is_complex = |given: &Bound<'_, PyAny>| {
        let kind = given.getattr("dtype").and_then(|dtype| dtype.getattr("kind"));
        kind.and_then(|kind| kind.extract::<String>()).is_ok_and(|kind| kind == "c")
    };
    // numpy would convert these to numbers, complex ones with a warning
    if given.is_none() || is_complex(given) {
        let fact = if given.is_none() { "None" } else { "an array of complex numbers" };
        return Err(input(&format!("{name} is {fact}"), "give a list of real numbers or an array of numpy"));
    }
    if py.import("numpy.ma")?.call_method1("is_masked", (given,))?.is_truthy()? {
        let remedy =
            "leave these data points out, for example by keep = ~numpy.ma.getmaskarray(y), x[keep] and y[keep]";
        return Err(input(&format!("{name} has masked values"), remedy));
    }
    let named = PyDict::new(py);
    named.set_item("dtype", "float64")?;
    py.import("numpy")?.call_method("asarray", (given,), Some(&named)).map_err(|e| {
        input(&format!("{name} is no array of numbers: {}", e.value(py)), "give a list of numbers or an array of numpy")
    })
}

/// Refuses numbers that are not finite.
pub fn finite(name: &str, values: &[f64]) -> PyResult<()> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(input(&format!("{name} has the value {} at index {k}", values[k]), "leave such values out")),
        None => Ok(()),
    }
}

/// Reads a second-order tensor, by rows.
pub fn tensor(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Mat3> {
    Ok(Mat3::from_row_slice(&shaped(name, given, &[&[3; 2]])?))
}

/// Reads the 81 numbers of a fourth-order tensor in the order of its indices; also accepts a 9 × 9 matrix of the first two indices by the last two.
pub fn tensor_of_four(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    shaped(name, given, &[&[3; 4], &[9; 2]])
}
