//! A measured curve in a table: the columns that a scene names, in the units of the recorded ones.
//!
//! Encoding, delimiter, decimal mark, lines above the names and a line of units below them are recognised as in the table of a tensile test.

use super::column::in_unit_of;
use crate::math::units::{self, UnitError};
use crate::scene::error::hint;
use crate::storage::table::{self, Decimal, Line, Named};
use crate::storage::{self, DATA_LIMIT};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Units of one column that differ by a smaller part than this are the same \[–\]
const SAME: f64 = 1e-9;

/// A column of the measured table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredSpec {
    /// Name of the column in the file, with or without the unit behind it
    pub column: String,
    /// Unit of its numbers; the one in the name of the column, or in a line below the names, if absent
    pub unit: Option<String>,
}

/// Why a measured curve was not read.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub(in crate::scene) enum MeasuredError {
    #[error("{file}: {why}; the path is relative to the scene")]
    Unreadable { file: String, why: String },
    #[error("{file}: {what}, not a text table; export the data as CSV or as text with delimiters")]
    NotText { file: String, what: String },
    #[error("{file}: there is no column \"{column}\"; {hint}")]
    Column { file: String, column: String, hint: String },
    #[error(
        "{file}: \"{cell}\" may be a decimal fraction or a number of thousands, and no other cell tells which; write the numbers with points and without separators"
    )]
    Decimal { file: String, cell: String },
    #[error(
        "{file}: line {line} has {cells} cells under {names} names: decimal commas in a table divided by commas cannot be told apart; export it with ; or tab between the columns, or with decimal points"
    )]
    Cells { file: String, line: u64, cells: usize, names: usize },
    #[error(
        "{file}: column \"{column}\" has no unit in the table; give it, such as {{ column = \"{column}\", unit = \"{example}\" }}"
    )]
    NoUnit { file: String, column: String, example: &'static str },
    #[error("{file}: column \"{column}\": the unit \"{unit}\" of the table {why}; give another one in the scene")]
    Unit { file: String, column: String, unit: String, why: String },
    #[error(
        "{file}: column \"{column}\" is in {own} by the table and in {stated} by the scene; correct one of them, or leave out `unit`"
    )]
    TwoUnits { file: String, column: String, own: String, stated: String },
    #[error("{file}: line {line}: \"{text}\" in column {column} is no finite number; correct or remove the line")]
    Number { file: String, line: u64, text: String, column: String },
    #[error("{file}: line {line}: the uncertainty {value} in column {column} is negative; it is a half-width")]
    Negative { file: String, line: u64, value: f64, column: String },
    #[error("{file}: it has fewer than two rows; a curve needs two")]
    Short { file: String },
}

/// A column that is wanted.
pub(in crate::scene) struct Wanted<'a> {
    pub spec: &'a MeasuredSpec,
    /// The recorded column in whose unit its numbers are wanted
    pub recorded: &'a str,
    /// Of the unit that the scene states, if it does
    pub factor: Option<f64>,
    /// Half-widths are not negative
    pub is_width: bool,
}

impl<'a> Wanted<'a> {
    /// Refuses a stated unit that is none of the recorded column.
    pub(in crate::scene) fn new(spec: &'a MeasuredSpec, recorded: &'a str, is_width: bool) -> Result<Self, UnitError> {
        let factor = |unit: &String| in_unit_of(recorded, &format!("1 {unit}").as_str().into());
        let factor = spec.unit.as_ref().map(factor).transpose()?;
        Ok(Self { spec, recorded, factor, is_width })
    }
}

/// The numbers of the wanted columns, in the units of the recorded ones.
pub(in crate::scene) fn read(path: &Path, wanted: &[Wanted]) -> Result<Vec<Vec<f64>>, MeasuredError> {
    let file = path.display().to_string();
    let bytes = storage::read(path, DATA_LIMIT);
    let bytes = bytes.map_err(|e| MeasuredError::Unreadable { file: file.clone(), why: e.to_string() })?;
    let (text, _) = table::decode(&bytes).map_err(|what| MeasuredError::NotText { file: file.clone(), what })?;
    let names: Vec<&str> = wanted.iter().map(|w| w.spec.column.as_str()).collect();
    let is_unit = |cell: &str| units::quantity(&format!("1 {cell}")).is_ok();
    let found = table::named(&text, &names, &is_unit).map_err(|(absent, known)| {
        let column = names[absent].to_string();
        MeasuredError::Column { file: file.clone(), hint: hint(&column, &known), column }
    })?;
    let rows: Vec<&Line> = found.body.iter().filter(|l| !l.is_empty()).collect();
    let cells = || rows.iter().flat_map(|l| found.places.iter().filter_map(|k| l.cells.get(*k))).map(String::as_str);
    let decimal = Decimal::of(cells()).map_err(|cell| MeasuredError::Decimal { file: file.clone(), cell })?;
    check_cells(&file, &found, &rows)?;
    if rows.len() < 2 {
        return Err(MeasuredError::Short { file });
    }
    let one = |(w, place): (&Wanted, &usize)| {
        let factor = factor(&file, &found, *place, w)?;
        rows.iter().map(|line| number(&file, line, *place, decimal, w).map(|v| factor * v)).collect()
    };
    wanted.iter().zip(&found.places).map(one).collect()
}

/// A finite number of a row.
fn number(file: &str, line: &Line, place: usize, decimal: Decimal, w: &Wanted) -> Result<f64, MeasuredError> {
    let (file, line_number, column) = (file.to_string(), line.number, w.spec.column.clone());
    let text = line.cells.get(place).map_or("", String::as_str);
    match table::number(text, decimal) {
        Ok(value) if w.is_width && value < 0.0 => {
            Err(MeasuredError::Negative { file, line: line_number, value, column })
        }
        Ok(value) => Ok(value),
        Err(_) => Err(MeasuredError::Number { file, line: line_number, text: text.into(), column }),
    }
}

/// Refuses rows with more numbers than there are names: their decimal commas were taken for delimiters.
fn check_cells(file: &str, found: &Named, rows: &[&Line]) -> Result<(), MeasuredError> {
    let names = found.names.cells.len();
    let too_many = |l: &&&Line| l.cells.iter().skip(names).any(|c| table::is_number(c));
    match rows.iter().find(too_many).filter(|_| found.delimiter == ',') {
        None => Ok(()),
        Some(l) => Err(MeasuredError::Cells { file: file.into(), line: l.number, cells: l.cells.len(), names }),
    }
}

/// From the numbers of a column to the unit of the recorded one. A unit of the table and one of the scene have to agree.
fn factor(file: &str, found: &Named, place: usize, w: &Wanted) -> Result<f64, MeasuredError> {
    let (file, column) = (file.to_string(), found.names.cells[place].clone());
    let own = found.unit(place);
    let of = |unit: &str| in_unit_of(w.recorded, &format!("1 {unit}").as_str().into());
    match (w.factor, own) {
        (Some(stated), None) => Ok(stated),
        (Some(stated), Some(own)) => match of(&own) {
            Ok(of_table) if (of_table / stated - 1.0).abs() > SAME => {
                let stated = w.spec.unit.clone().unwrap_or_default();
                Err(MeasuredError::TwoUnits { file, column, own, stated })
            }
            // Brackets may hold a note
            _ => Ok(stated),
        },
        (None, Some(unit)) => {
            of(&unit).map_err(|e| MeasuredError::Unit { file, column, unit, why: format!("cannot be taken: {e}") })
        }
        (None, None) => Err(MeasuredError::NoUnit { file, column: w.spec.column.clone(), example: "mm" }),
    }
}
