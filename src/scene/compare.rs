//! Measured curves in CSV files, to be laid over recorded ones.

use super::builder::Builder;
use super::control::in_unit_of;
use super::error::part;
use super::error::{SceneError, hint};
use crate::storage::{self, DATA_LIMIT};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A measured curve of a recorded column.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompareSpec {
    /// Recorded column that was measured
    pub column: String,
    /// Recorded column it was measured over
    #[serde(default = "time")]
    pub over: String,
    /// Relative to the scene
    pub file: PathBuf,
    pub x: MeasuredSpec,
    pub y: MeasuredSpec,
}

/// A column of the measured table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredSpec {
    pub column: String,
    pub unit: String,
}

fn time() -> String {
    "t_s".into()
}

/// A measured curve in the units of the recorded columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Recorded columns by name
    pub column: String,
    pub over: String,
    pub source: String,
    /// \[samples\]
    pub x: Vec<f64>,
    pub y: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
enum MeasuredError {
    #[error("{file}: {why}; the path is relative to the scene")]
    Unreadable { file: String, why: String },
    #[error("{file}: there is no column \"{column}\"; {hint}")]
    Column { file: String, column: String, hint: String },
    #[error("{file}: line {line}: \"{text}\" in column {column} is no finite number; correct or remove the line")]
    Number { file: String, line: u64, text: String, column: String },
    #[error("{file}: it has fewer than two rows; a curve needs two")]
    Short { file: String },
}

/// The measured curves, with what they are compared with among `columns`.
pub(super) fn read_measured(
    builder: &Builder,
    specs: &[CompareSpec],
    columns: &[String],
) -> Result<Vec<Measured>, SceneError> {
    let one = |(k, spec): (usize, &CompareSpec)| {
        let place = format!("compare {} ({})", k + 1, spec.column);
        for name in [&spec.column, &spec.over] {
            if !columns.contains(name) {
                let fact = format!("the scene records no \"{name}\"");
                return Err(builder.content(&place, fact, hint(name, columns)));
            }
        }
        let factor = |name: &str, unit: &str| {
            in_unit_of(name, &format!("1 {unit}").as_str().into())
                .map_err(|e| part(builder.file, format!("{place}: {name}"), e))
        };
        let factors = [factor(&spec.over, &spec.x.unit)?, factor(&spec.column, &spec.y.unit)?];
        let path = builder.file.parent().unwrap_or(Path::new("")).join(&spec.file);
        let (x, y) = read(&path, [&spec.x.column, &spec.y.column]).map_err(|e| part(builder.file, &place, e))?;
        let [x, y] = [(x, factors[0]), (y, factors[1])].map(|(v, f)| v.into_iter().map(|v| v * f).collect());
        let source = spec.file.display().to_string();
        Ok(Measured { column: spec.column.clone(), over: spec.over.clone(), source, x, y })
    };
    specs.iter().enumerate().map(one).collect()
}

fn read(path: &Path, names: [&String; 2]) -> Result<(Vec<f64>, Vec<f64>), MeasuredError> {
    let file = path.display().to_string();
    let bytes = storage::read(path, DATA_LIMIT);
    let bytes = bytes.map_err(|e| MeasuredError::Unreadable { file: file.clone(), why: e.to_string() })?;
    let unreadable = |e: csv::Error| MeasuredError::Unreadable { file: file.clone(), why: e.to_string() };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let known: Vec<String> = reader.headers().map_err(unreadable)?.iter().map(String::from).collect();
    let mut places = [0; 2];
    for (place, name) in places.iter_mut().zip(names) {
        let missing = || MeasuredError::Column { file: file.clone(), column: name.clone(), hint: hint(name, &known) };
        *place = known.iter().position(|k| k == name).ok_or_else(missing)?;
    }
    let mut out = [Vec::new(), Vec::new()];
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        for ((values, place), name) in out.iter_mut().zip(places).zip(names) {
            let text = record.get(place).unwrap_or_default();
            let value = text.parse().ok().filter(|v: &f64| v.is_finite());
            values.push(value.ok_or_else(|| MeasuredError::Number {
                file: file.clone(),
                line: record.position().map_or(0, csv::Position::line),
                text: text.into(),
                column: name.clone(),
            })?);
        }
    }
    let [x, y] = out;
    if x.len() < 2 { Err(MeasuredError::Short { file }) } else { Ok((x, y)) }
}
