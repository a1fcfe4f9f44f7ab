//! A measured curve in a table: the columns that a scene names, in the units of the recorded columns.
//!
//! Encoding, delimiter, decimal mark, lines above the names and a line of units below them are recognised as in the table of a tensile test.

use super::column::in_unit_of;
use crate::math::units::{self, UnitError};
use crate::storage::columns::{Named, TableError};
use crate::storage::table::Line;
use crate::storage::{self, DATA_LIMIT};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// A column of the measured table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredColumnSpec {
    /// Name of the column in the file, with or without the unit after it
    pub column: String,
    /// Unit of the numbers; if absent, the one in the name of the column, or in a line below the names
    pub unit: Option<String>,
}

/// Reason why a measured curve cannot be read.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub(in crate::scene) enum MeasuredError {
    #[error("{file}: {why}; the path is relative to the scene")]
    Unreadable { file: String, why: String },
    #[error("{table}{}", if matches!(table, TableError::TwoUnits { .. }) { ", or leave out `unit`" } else { "" })]
    Table {
        #[from]
        table: TableError,
    },
    #[error(
        "{file}: column \"{column}\" has no unit in the table; give it, such as {{ column = \"{column}\", unit = \"{example}\" }}"
    )]
    NoUnit { file: String, column: String, example: &'static str },
    #[error("{file}: column \"{column}\": the unit \"{unit}\" of the table {why}; give another one in the scene")]
    Unit { file: String, column: String, unit: String, why: String },
    #[error("{file}: line {line}: the uncertainty {value} in column {column} is negative; it is a half-width")]
    Negative { file: String, line: u64, value: f64, column: String },
    #[error("{file}: it has fewer than two rows; a curve needs two")]
    Short { file: String },
}

/// A column to be read.
pub(in crate::scene) struct Wanted<'a> {
    pub spec: &'a MeasuredColumnSpec,
    /// Recorded column in whose unit the numbers are returned
    pub recorded: &'a str,
    /// Factor of the unit that the scene states, if it states one
    pub factor: Option<f64>,
    /// Whether the numbers are half-widths, which are not negative
    pub is_width: bool,
}

impl<'a> Wanted<'a> {
    /// Refuses a stated unit that is not a unit of the recorded column.
    pub(in crate::scene) fn new(
        spec: &'a MeasuredColumnSpec,
        recorded: &'a str,
        is_width: bool,
    ) -> Result<Self, UnitError> {
        let factor = |unit: &String| in_unit_of(recorded, &format!("1 {unit}").as_str().into());
        let factor = spec.unit.as_ref().map(factor).transpose()?;
        Ok(Self { spec, recorded, factor, is_width })
    }
}

/// The numbers of the wanted columns, in the units of the recorded columns.
pub(in crate::scene) fn read(path: &Path, wanted: &[Wanted]) -> Result<Vec<Vec<f64>>, MeasuredError> {
    let file = path.display().to_string();
    let bytes = storage::read(path, DATA_LIMIT);
    let bytes = bytes.map_err(|e| MeasuredError::Unreadable { file: file.clone(), why: e.to_string() })?;
    let names: Vec<&str> = wanted.iter().map(|w| w.spec.column.as_str()).collect();
    let table = Named::read(&file, &bytes, &names, &[], units::is_unit)?;
    if table.rows.len() < 2 {
        return Err(MeasuredError::Short { file });
    }
    let stated: Vec<Option<&str>> = wanted.iter().map(|w| w.spec.unit.as_deref()).collect();
    table.check_units(&stated, "scene", units::ratio)?;
    let factors = wanted.iter().enumerate().map(|(k, w)| factor(&file, &table, k, w)).collect::<Result<Vec<_>, _>>()?;
    let rows: Vec<&Line> = table.rows.iter().collect();
    let mut columns = table.numbers(0..wanted.len(), &rows)?;
    for ((w, column), factor) in wanted.iter().zip(&mut columns).zip(factors) {
        if let Some(k) = column.iter().position(|v| w.is_width && *v < 0.0) {
            let (line, value, column) = (rows[k].number, column[k], w.spec.column.clone());
            return Err(MeasuredError::Negative { file, line, value, column });
        }
        column.iter_mut().for_each(|v| *v *= factor);
    }
    Ok(columns)
}

/// The factor from the numbers of a column to the unit of the recorded column, as stated by the scene, or otherwise by the table.
fn factor(file: &str, table: &Named, k: usize, w: &Wanted) -> Result<f64, MeasuredError> {
    let (file, column) = (file.to_string(), table.name(k).to_string());
    match (w.factor, table.unit(k)) {
        (Some(stated), _) => Ok(stated),
        (None, Some(unit)) => in_unit_of(w.recorded, &format!("1 {}", units::spelled(&unit)).as_str().into())
            .map_err(|e| MeasuredError::Unit { file, column, unit, why: format!("cannot be taken: {e}") }),
        (None, None) => Err(MeasuredError::NoUnit { file, column: w.spec.column.clone(), example: "mm" }),
    }
}
