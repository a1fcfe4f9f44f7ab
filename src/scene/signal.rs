//! Signals as they stand in files: a constant `"15 mm"`, or a table with a `kind`.

use super::quantity::QuantityText;
use crate::math::signal::Signal;
use crate::math::units::{self, Dimension, UnitError};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;
use std::path::{Path, PathBuf};

/// A signal before its dimension is known; quantities are text. In files a function is a table with a `kind`.
#[derive(Clone, Debug)]
pub enum SignalSpec {
    Constant(QuantityText),
    Function(Box<FunctionSpec>),
}

impl<'de> Deserialize<'de> for SignalSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextOrTable)
    }
}

/// Decides by what stands there, so that errors inside a table keep their place.
struct TextOrTable;

impl<'de> Visitor<'de> for TextOrTable {
    type Value = SignalSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a signal: a quantity in quotes such as \"15 mm\", or a table with a `kind`")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<SignalSpec, E> {
        Ok(SignalSpec::Constant(QuantityText(text.into())))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<SignalSpec, E> {
        self.visit_str(&value.to_string())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<SignalSpec, E> {
        self.visit_str(&value.to_string())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SignalSpec, A::Error> {
        let function = FunctionSpec::deserialize(MapAccessDeserializer::new(map))?;
        Ok(SignalSpec::Function(Box::new(function)))
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FunctionSpec {
    RaisedCosine {
        amplitude: QuantityText,
        frequency: QuantityText,
    },
    Sine {
        amplitude: QuantityText,
        frequency: QuantityText,
        #[serde(default)]
        phase: Option<QuantityText>,
    },
    Ramp {
        from: QuantityText,
        to: QuantityText,
        #[serde(default)]
        start: Option<QuantityText>,
        end: QuantityText,
    },
    Hold {
        signal: SignalSpec,
        at: QuantityText,
    },
    Delay {
        signal: SignalSpec,
        by: QuantityText,
    },
    /// Two columns with a header line: time [s], then the value in `unit`
    Table {
        file: PathBuf,
        unit: String,
    },
    /// The first factor carries the unit, the others are plain numbers
    Product {
        of: Vec<SignalSpec>,
    },
    Sum {
        of: Vec<SignalSpec>,
    },
}

/// Why a signal cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SignalError {
    #[error(transparent)]
    Unit(#[from] UnitError),
    #[error("a ramp must end after it starts")]
    EmptyRamp,
    #[error("{file}: {why}")]
    Table { file: String, why: String },
    #[error("a {0} needs at least one entry in `of`")]
    Empty(&'static str),
}

impl SignalSpec {
    /// The signal of this dimension; files are relative to `base`.
    pub fn build(&self, dimension: Dimension, base: &Path) -> Result<Signal, SignalError> {
        let parse = |q: &QuantityText, d| units::parse(&q.0, d);
        let time = |q: &QuantityText| parse(q, Dimension::TIME);
        let function = match self {
            Self::Constant(text) => return Ok(Signal::Constant(parse(text, dimension)?)),
            Self::Function(function) => function.as_ref(),
        };
        Ok(match function {
            FunctionSpec::RaisedCosine { amplitude, frequency } => Signal::RaisedCosine {
                amplitude: parse(amplitude, dimension)?,
                frequency: parse(frequency, Dimension::FREQUENCY)?,
            },
            FunctionSpec::Sine { amplitude, frequency, phase } => Signal::Sine {
                amplitude: parse(amplitude, dimension)?,
                frequency: parse(frequency, Dimension::FREQUENCY)?,
                phase: phase.as_ref().map_or(Ok(0.0), |p| parse(p, Dimension::ANGLE))?,
            },
            FunctionSpec::Ramp { from, to, start, end } => {
                let start = start.as_ref().map_or(Ok(0.0), time)?;
                let end = time(end)?;
                if end <= start {
                    return Err(SignalError::EmptyRamp);
                }
                Signal::Ramp { from: parse(from, dimension)?, to: parse(to, dimension)?, start, end }
            }
            FunctionSpec::Hold { signal, at } => {
                Signal::Hold { signal: Box::new(signal.build(dimension, base)?), at: time(at)? }
            }
            FunctionSpec::Delay { signal, by } => {
                Signal::Delay { signal: Box::new(signal.build(dimension, base)?), by: time(by)? }
            }
            FunctionSpec::Table { file, unit } => Signal::Table(read_table(&base.join(file), unit, dimension)?),
            FunctionSpec::Product { of } => {
                let dimensions = std::iter::once(dimension).chain(std::iter::repeat(Dimension::NONE));
                Signal::Product(build_all(of, dimensions, base, "product")?)
            }
            FunctionSpec::Sum { of } => Signal::Sum(build_all(of, std::iter::repeat(dimension), base, "sum")?),
        })
    }
}

fn build_all(
    of: &[SignalSpec],
    dimensions: impl Iterator<Item = Dimension>,
    base: &Path,
    kind: &'static str,
) -> Result<Vec<Signal>, SignalError> {
    if of.is_empty() {
        return Err(SignalError::Empty(kind));
    }
    of.iter().zip(dimensions).map(|(s, d)| s.build(d, base)).collect()
}

fn read_table(path: &Path, unit: &str, dimension: Dimension) -> Result<Vec<(f64, f64)>, SignalError> {
    let error = |why: String| SignalError::Table { file: path.display().to_string(), why };
    let factor = units::parse(&format!("1 {unit}"), dimension)?;
    let mut reader =
        csv::Reader::from_path(path).map_err(|e| error(format!("{e}; the path is relative to the scene")))?;
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for (k, record) in reader.deserialize::<(f64, f64)>().enumerate() {
        let (t, value) = record.map_err(|_| {
            error(format!("line {}: two numbers are needed (time in s, value in {unit}), separated by a comma", k + 2))
        })?;
        if rows.last().is_some_and(|last| last.0 >= t) {
            return Err(error(format!("line {}: time must increase from row to row", k + 2)));
        }
        rows.push((t, value * factor));
    }
    if rows.is_empty() { Err(error("the table has no row".into())) } else { Ok(rows) }
}
