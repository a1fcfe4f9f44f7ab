//! Controllers in Python: a function that is called at every point of the time grid. This path is slow, because each call waits for the interpreter.

use crate::array::array;
use crate::error::input;
use crate::solve::Link;
use crate::threads::ask;
use crate::value::{entries, kind};
use durometer::math::stopwatch::{Spent, Stopwatch};
use durometer::scene::control::{ControlError, Controller, Observation as Seen, Opening, Reply};
use durometer::scene::hint;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A point of the time grid as a controller sees it: recorded values `now["column"]`, the time `now.t` `[s]`, the time of the next point `now.next`, and
/// the current values of the signals, `now.signals`. The controller returns new values by name, one number if there is only one signal, or None.
#[pyclass(module = "durometer", frozen)]
pub struct Observation {
    /// Time of the row `[s]`
    #[pyo3(get)]
    t: f64,
    /// Time of the next point `[s]`, at which the signals reach what is set now
    #[pyo3(get)]
    next: f64,
    /// Names of the recorded columns
    #[pyo3(get)]
    columns: Vec<String>,
    /// The recorded row
    #[pyo3(get)]
    row: Py<PyAny>,
    /// Signal → its current value `[SI]`
    #[pyo3(get)]
    signals: Py<PyDict>,
    values: Vec<f64>,
    ends: AtomicBool,
}

#[pymethods]
impl Observation {
    fn __getitem__(&self, column: &str) -> PyResult<f64> {
        let place = self.columns.iter().position(|name| name == column);
        let missing = || PyKeyError::new_err(format!("no column {column}; {}", hint(column, &self.columns)));
        place.map(|k| self.values[k]).ok_or_else(missing)
    }

    /// Ends the run at this point.
    fn stop(&self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}

/// A controller whose answers come from a function of Python.
pub struct Foreign {
    function: Py<PyAny>,
    columns: Vec<String>,
    signals: Vec<String>,
    /// Link of the run
    pub link: Option<Arc<Link>>,
    /// Time taken by its answers, which does not count as time of the run
    pub spent: Spent,
}

/// Makes a controller of a function; `None` if none is given.
pub fn callable(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Foreign>> {
    let Some(function) = given else { return Ok(None) };
    if !function.is_callable() {
        let fact = format!("a controller of the type {} cannot be called", kind(function));
        return Err(input(&fact, "give a function of one argument, the observation"));
    }
    let function = function.clone().unbind();
    Ok(Some(Foreign { function, columns: vec![], signals: vec![], link: None, spent: Spent::default() }))
}

impl Foreign {
    /// Calls the function; returns true if it ends the run.
    fn ask(&self, py: Python<'_>, seen: &Seen, signals: &mut [f64]) -> PyResult<bool> {
        let known = PyDict::new(py);
        self.signals.iter().zip(&*signals).try_for_each(|(name, value)| known.set_item(name, value))?;
        let now = Observation {
            t: seen.row[0],
            next: seen.next,
            columns: self.columns.clone(),
            row: array(py, seen.row.to_vec(), [seen.row.len()])?,
            signals: known.unbind(),
            values: seen.row.to_vec(),
            ends: AtomicBool::new(false),
        };
        let now = Bound::new(py, now)?;
        let answer = self.function.bind(py).call1((&now,))?;
        if let Some(set) = entries(&answer)? {
            for (name, value) in set {
                let place = self.signals.iter().position(|signal| *signal == name);
                let missing =
                    || PyKeyError::new_err(format!("no signal {name} is controlled; {}", hint(&name, &self.signals)));
                signals[place.ok_or_else(missing)?] = number(&value)?;
            }
        } else if !answer.is_none() {
            let [signal] = signals else {
                return Err(PyTypeError::new_err("of several signals the controller returns a dictionary"));
            };
            *signal = number(&answer)?;
        }
        Ok(now.get().ends.load(Ordering::Relaxed))
    }
}

/// Extracts a number; refuses a truth value, which Python and numpy would convert to 0 or 1.
fn number(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let kind = kind(value);
    let number = if kind.starts_with("bool") { None } else { value.extract().ok() };
    number.ok_or_else(|| {
        PyTypeError::new_err(format!("the controller sets a signal to a {kind}; return numbers in SI units"))
    })
}

impl Controller for Foreign {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        (self.columns, self.signals) = (opening.columns.to_vec(), opening.signals.to_vec());
        Ok(())
    }

    fn step(&mut self, observation: &Seen, signals: &mut [f64]) -> Result<Reply, ControlError> {
        let stopwatch = Stopwatch::start();
        let answer = ask(|py| self.ask(py, observation, signals));
        self.spent += stopwatch.spent();
        match answer {
            Ok(stop) => Ok(Reply { stop, ..Reply::default() }),
            Err(why) => {
                if let Some(link) = &self.link {
                    link.fail(why);
                }
                Err(ControlError::Stopped { t: observation.row[0] })
            }
        }
    }
}
