//! Rewriting the report of a study; the class `Report` is in `python/durometer/report.py`.

use crate::error::refused;
use crate::solve::apart;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Analyses the results that a run has stored in a folder and writes their report; nothing is solved.
#[pyfunction]
pub fn write_report(py: Python<'_>, folder: PathBuf) -> PyResult<()> {
    apart(py, None, |_| durometer::study::report::write_report(&folder).map(|_| ()))?.map_err(refused)
}
