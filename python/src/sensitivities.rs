//! The class `Sensitivities`: derivatives of the columns of a run with respect to keys of its scene.

use crate::array::array;
use crate::error::{incomplete, input};
use crate::run::Run;
use durometer::scene::{Sensitivities as Found, hint};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PySlice, PyTuple};

/// Derivatives of the rows of a run, in the unit of the column per SI unit of the key.
///
/// `found["xmax_z_m", "laws.rubber.mu"]` is one derivative as a function of time.
#[pyclass(module = "durometer", frozen)]
pub struct Sensitivities {
    /// Columns that have a derivative
    #[pyo3(get)]
    columns: Vec<String>,
    /// Keys of the scene
    #[pyo3(get)]
    keys: Vec<String>,
    /// The derivatives `[times × columns × keys]`
    #[pyo3(get)]
    values: Py<PyAny>,
    /// Largest estimated error over the times `[columns × keys]`; zero for an exact derivative
    #[pyo3(get)]
    errors: Py<PyAny>,
    /// Keys that change none of the columns; empty if the derivatives end early
    #[pyo3(get)]
    idle: Vec<String>,
    /// (column, key, error relative to the largest value) of derivatives that are less accurate than 1e-6
    #[pyo3(get)]
    doubtful: Vec<(String, String, f64)>,
    /// The run itself
    #[pyo3(get)]
    run: Py<Run>,
}

#[pymethods]
impl Sensitivities {
    /// Times of the derivatives `[s]`: those of the run, or the first of them if the derivatives end early.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = isize::try_from(self.values.bind(py).len()?)?;
        self.run.get().column(py, 0)?.get_item(PySlice::new(py, 0, rows, 1))
    }

    /// The derivatives as a pandas table, indexed by time, with columns labelled (column, key).
    #[getter]
    fn frame<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("durometer._frames")?.call_method1("of_sensitivities", (slf,))
    }

    /// Returns the table of `frame`.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::frame(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, place: (String, String)) -> PyResult<Bound<'py, PyAny>> {
        let find = |what: &str, name: &str, known: &[String]| {
            let missing = || PyKeyError::new_err(format!("no {what} {name} with a derivative; {}", hint(name, known)));
            known.iter().position(|k| k == name).ok_or_else(missing)
        };
        let (c, k) = (find("column", &place.0, &self.columns)?, find("key", &place.1, &self.keys)?);
        let all = PySlice::full(py).into_any();
        let at = PyTuple::new(py, [all, c.into_pyobject(py)?.into_any(), k.into_pyobject(py)?.into_any()])?;
        self.values.bind(py).get_item(at)
    }

    fn __repr__(&self) -> String {
        format!("<Sensitivities of {} columns by {}>", self.columns.len(), self.keys.join(", "))
    }
}

impl Sensitivities {
    pub fn new(py: Python<'_>, found: Found, run: Py<Run>, check: bool) -> PyResult<Self> {
        let (rows, columns, keys) = (found.rows.len(), found.columns.len(), found.keys.len());
        if let Some((t, why)) = found.stopped.as_ref().filter(|_| check) {
            let fact = format!("there is no derivative at t = {t} s: {why}");
            return Err(incomplete("NoDerivative", &fact, "end the run before, or take another stage", run.into_any()));
        }
        if rows == 0 {
            return Err(input("the scene records no row", "add a [[stage]]"));
        }
        let text = |key: &durometer::scene::ParameterKey| key.to_string();
        Ok(Self {
            idle: found.idle().map(text).collect(),
            doubtful: found.doubtful().into_iter().map(|(c, k, e)| (c.into(), text(k), e)).collect(),
            values: array(py, found.rows.iter().flatten().flatten().copied().collect(), [rows, columns, keys])?,
            errors: array(py, found.errors.concat(), [columns, keys])?,
            columns: found.columns.clone(),
            keys: found.keys.iter().map(text).collect(),
            run,
        })
    }
}
