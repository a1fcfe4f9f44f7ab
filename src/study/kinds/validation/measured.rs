//! Measured values in a table.

use crate::math::units;
use crate::scene::hint;
use crate::storage::{self, DATA_LIMIT};
use crate::study::kinds::validation::spec::TableSpec;
use std::collections::BTreeMap;
use std::path::Path;

/// Rows of a table that match everything but the experiment, with a factor to the unit of the quantity.
pub struct MeasuredTable {
    file: String,
    /// \[rows\] text of every column that chooses rows, and the value
    rows: Vec<(BTreeMap<String, String>, String, u64)>,
    column: String,
    chosen: BTreeMap<String, String>,
    factor: f64,
}

/// Replaced by the experiment of a record.
const EXPERIMENT: &str = "{experiment}";

/// Reads a table; the error says what is wrong in words.
pub fn table(base: &Path, spec: &TableSpec, unit: &str) -> Result<MeasuredTable, String> {
    let file = spec.file.display().to_string();
    let factor = units::in_unit(&format!("1 {}", spec.unit), unit).map_err(|e| format!("table: unit: {e}"))?;
    let bytes = storage::read(&base.join(&spec.file), DATA_LIMIT)
        .map_err(|e| format!("{file}: {e}; the path is relative to the study"))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let known: Vec<String> = reader.headers().map_err(|e| format!("{file}: {e}"))?.iter().map(String::from).collect();
    let place = |name: &String| {
        known
            .iter()
            .position(|k| k == name)
            .ok_or_else(|| format!("{file}: there is no column \"{name}\"; {}", hint(name, &known)))
    };
    let value = place(&spec.column)?;
    let choosing = spec.rows.keys().map(|k| Ok((k.clone(), place(k)?))).collect::<Result<Vec<_>, String>>()?;
    let mut rows = vec![];
    for record in reader.records() {
        let record = record.map_err(|e| format!("{file}: {e}"))?;
        let text = |k: usize| record.get(k).unwrap_or_default().to_string();
        let own = choosing.iter().map(|(name, k)| (name.clone(), text(*k))).collect();
        rows.push((own, text(value), record.position().map_or(0, csv::Position::line)));
    }
    Ok(MeasuredTable { file, rows, column: spec.column.clone(), chosen: spec.rows.clone(), factor })
}

impl MeasuredTable {
    /// The values of an experiment; none where no row is of it.
    pub fn values(&self, experiment: &str) -> Result<Vec<f64>, String> {
        let wanted = |(name, text): (&String, &String)| (name.clone(), text.replace(EXPERIMENT, experiment));
        let wanted: BTreeMap<String, String> = self.chosen.iter().map(wanted).collect();
        let own = self.rows.iter().filter(|(row, _, _)| *row == wanted);
        let value = |(_, text, line): &(_, String, u64)| match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v * self.factor),
            _ => Err(format!("{}: line {line}: \"{text}\" in column {} is no finite number", self.file, self.column)),
        };
        own.map(value).collect()
    }
}
