//! Measured values in a table.

use crate::math::units;
use crate::storage::columns::{Named, TableError};
use crate::storage::table::Line;
use crate::storage::{self, DATA_LIMIT};
use crate::study::kinds::validation::spec::TableSpec;
use crate::study::spec::EXPERIMENT;
use std::collections::BTreeMap;
use std::path::Path;

/// A table whose first column holds the values, while the other columns, in the order of `chosen`, select rows; with a factor to the unit of the
/// quantity.
pub struct MeasuredTable {
    table: Named,
    chosen: BTreeMap<String, String>,
    factor: f64,
}

/// Reads a table; the error describes the mistake in words.
pub fn table(base: &Path, spec: &TableSpec, unit: &str) -> Result<MeasuredTable, String> {
    let factor = units::in_unit(&format!("1 {}", spec.unit), unit).map_err(|e| format!("table: unit: {e}"))?;
    let choosing: Vec<&str> = spec.rows.keys().map(String::as_str).collect();
    let table = read(base, &spec.file.display().to_string(), (&[&spec.column], &spec.unit), &choosing)?;
    Ok(MeasuredTable { table, chosen: spec.rows.clone(), factor })
}

/// Reads columns of numbers in one unit, followed by columns of text, from a file given relative to the study.
pub(super) fn read(base: &Path, file: &str, (numbers, unit): (&[&str], &str), texts: &[&str]) -> Result<Named, String> {
    let bytes = storage::read(&base.join(file), DATA_LIMIT)
        .map_err(|e| format!("{file}: {e}; the path is relative to the study"))?;
    let checked = || -> Result<Named, TableError> {
        let table = Named::read(file, &bytes, numbers, texts, units::is_unit)?;
        table.check_lengths()?;
        table.check_units(&vec![Some(unit); numbers.len()], "study", units::ratio)?;
        Ok(table)
    };
    checked().map_err(|e| e.to_string())
}

impl MeasuredTable {
    /// Returns the values of an experiment; empty if no row belongs to it.
    pub fn values(&self, experiment: &str) -> Result<Vec<f64>, String> {
        let wanted: Vec<String> = self.chosen.values().map(|text| text.replace(EXPERIMENT, experiment)).collect();
        let is_own = |row: &&Line| (1..).zip(&wanted).all(|(k, text)| self.table.cell(row, k) == text);
        let rows: Vec<&Line> = self.table.rows.iter().filter(is_own).collect();
        let numbers = self.table.numbers(0..1, &rows).map_err(|e| e.to_string())?;
        Ok(numbers.concat().into_iter().map(|v| v * self.factor).collect())
    }
}
