//! Signals in files: a constant `"15 mm"`, or a table with a `kind`.

pub(super) mod instant;
pub mod protocol;
pub(super) mod table;

use super::control::{Input, Source};
use super::text::kind::ByKind;
use super::text::quantity::Quantity;
use crate::math::formula::Formula;
use crate::math::signal::Signal;
use crate::math::units::{self, Dimension, UnitError};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;
use std::path::{Path, PathBuf};
use table::read_signal;

/// A signal before its dimension is known: a constant, or a function, which in files is a table with a `kind`.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub enum SignalSpec {
    /// A value that does not change over time
    Constant(Quantity),
    /// A function of time
    Function(Box<FunctionSpec>),
}

impl SignalSpec {
    /// A function of time.
    fn function(function: FunctionSpec) -> Self {
        Self::Function(Box::new(function))
    }

    /// A straight line between two values and times, constant before and after; all values in SI.
    pub fn ramp(from: f64, to: f64, start: f64, end: f64) -> Self {
        let start = Some(start.into());
        Self::function(FunctionSpec::Ramp { from: from.into(), to: to.into(), start, end: end.into() })
    }

    /// A signal from 0 to the amplitude and back, with `frequency` cycles per second; all values in SI.
    pub fn raised_cosine(amplitude: f64, frequency: f64) -> Self {
        Self::function(FunctionSpec::RaisedCosine { amplitude: amplitude.into(), frequency: frequency.into() })
    }

    /// A sine that starts at 0; all values in SI.
    pub fn sine(amplitude: f64, frequency: f64) -> Self {
        Self::function(FunctionSpec::Sine { amplitude: amplitude.into(), frequency: frequency.into(), phase: None })
    }

    /// A signal that a controller sets, with its value before the first decision in SI.
    pub fn controlled(initial: f64) -> Self {
        Self::function(FunctionSpec::Controlled { initial: initial.into(), range: None })
    }
}

impl From<f64> for SignalSpec {
    /// Converts a constant in SI.
    fn from(value: f64) -> Self {
        Self::Constant(value.into())
    }
}

impl From<&str> for SignalSpec {
    /// Converts a constant with its unit, such as `"15 mm"`.
    fn from(text: &str) -> Self {
        Self::Constant(text.into())
    }
}

impl<'de> Deserialize<'de> for SignalSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextOrTable)
    }
}

/// Chooses by the type of the value, so that errors inside a table keep their place.
struct TextOrTable;

impl<'de> Visitor<'de> for TextOrTable {
    type Value = SignalSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a signal: a quantity in quotes such as \"15 mm\", or a table with a `kind`")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<SignalSpec, E> {
        Ok(SignalSpec::Constant(text.into()))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<SignalSpec, E> {
        self.visit_str(&value.to_string())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<SignalSpec, E> {
        self.visit_str(&value.to_string())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SignalSpec, A::Error> {
        let function = FunctionSpec::deserialize(ByKind(map))?;
        Ok(SignalSpec::Function(Box::new(function)))
    }
}

/// A function of time
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum FunctionSpec {
    /// From 0 to the amplitude and back, a(1 − cos 2πft)/2
    RaisedCosine {
        /// Largest value, with its unit
        amplitude: Quantity,
        /// Frequency, such as `"1 Hz"`
        frequency: Quantity,
    },
    /// A sine, a sin(2πft + φ)
    Sine {
        /// Amplitude, with its unit
        amplitude: Quantity,
        /// Frequency, such as `"1 Hz"`
        frequency: Quantity,
        /// Phase φ, such as `"90 deg"`; 0 if absent
        #[serde(default)]
        phase: Option<Quantity>,
    },
    /// A straight line between two values, constant before and after
    Ramp {
        /// Value at the start, with its unit
        from: Quantity,
        /// Value at the end, with its unit
        to: Quantity,
        /// Time of the start, such as `"0.5 s"`; 0 if absent
        #[serde(default)]
        start: Option<Quantity>,
        /// Time of the end, such as `"1 s"`
        end: Quantity,
    },
    /// Another signal that keeps the value it has at a time
    Hold {
        /// The signal that is held
        signal: SignalSpec,
        /// Time from which it is held, such as `"1 s"`
        at: Quantity,
    },
    /// Another signal, delayed
    Delay {
        /// The signal that is delayed
        signal: SignalSpec,
        /// Time by which it is delayed, such as `"1 s"`
        by: Quantity,
    },
    /// A CSV file of two columns with a header line: time \[s\], then the value in `unit`. Contradictory column names are refused
    Table {
        /// Path of the CSV file, relative to the scene
        file: PathBuf,
        /// Unit of the values
        unit: String,
    },
    /// Straight lines between points, constant before the first and after the last
    Points {
        /// Points: increasing time \[s\], and value in `unit`
        of: Vec<[f64; 2]>,
        /// Unit of the values
        unit: String,
    },
    /// A product of signals; the first factor carries the unit, the others are plain numbers
    Product {
        /// Factors
        of: Vec<SignalSpec>,
    },
    /// A sum of signals
    Sum {
        /// Terms of the sum
        of: Vec<SignalSpec>,
    },
    /// A formula in t and recorded columns, whose value is in `unit`
    Expression {
        /// Formula, such as `"2 * sin(PI * t)"` with t in seconds
        formula: String,
        /// Unit of the value
        unit: String,
    },
    /// Set by a controller
    Controlled {
        /// Value before the first decision, with its unit
        initial: Quantity,
        /// Smallest and largest value to which it may be set
        #[serde(default)]
        range: Option<[Quantity; 2]>,
    },
}

/// Context in which a signal is built, and the list that collects its inputs.
pub(super) struct Site<'a> {
    /// Folder for relative paths of files
    pub base: &'a Path,
    /// Name of the whole signal
    pub name: &'a str,
    pub inputs: &'a mut Vec<Input>,
    /// Event that switches to the signal
    pub event: Option<usize>,
    /// Depth of nesting; 0 for the whole signal
    pub depth: usize,
    /// Whether it is inside a hold or delay
    pub delayed: bool,
}

impl Site<'_> {
    fn within(&mut self, delayed: bool) -> Site<'_> {
        let Site { base, name, inputs, event, depth, .. } = self;
        Site { base, name, inputs, event: *event, depth: *depth + 1, delayed: self.delayed || delayed }
    }

    fn input(&mut self, source: Source) -> Signal {
        self.inputs.push(Input { signal: self.name.into(), source });
        Signal::Input(self.inputs.len() - 1)
    }
}

/// Reason why a signal cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SignalError {
    #[error(transparent)]
    Unit(#[from] UnitError),
    #[error("a ramp must end after it starts")]
    EmptyRamp,
    #[error("the time {t} s of a hold or a delay is before the start; give zero or a later one")]
    Early { t: f64 },
    #[error("{file}: {why}")]
    Table { file: String, why: String },
    #[error(
        "the points of a signal are finite numbers at times that increase; write for example of = [[0, 0], [1, 15]]"
    )]
    Points,
    #[error("a {0} needs at least one entry in `of`")]
    Empty(&'static str),
    #[error("the formula \"{text}\" cannot be read: {why}; write for example \"2 * sin(PI * t)\"")]
    Formula { text: String, why: String },
    #[error("within hold and delay a formula takes t only, not {0}: what was recorded earlier is not kept")]
    Delayed(String),
    #[error("a `controlled` signal cannot be combined with others; add what else is to act in the controller")]
    Controlled,
    #[error("the `range` of a controlled signal rises and contains `initial`; write for example [\"0 mm\", \"15 mm\"]")]
    Range,
}

impl SignalSpec {
    /// Value at the start \[SI\]; `None` if it depends on recorded columns, or the signal does not have this dimension.
    pub(crate) fn at_start(&self, dimension: Dimension, base: &Path) -> Option<f64> {
        let mut inputs = vec![];
        let mut site = Site { base, name: "", inputs: &mut inputs, event: None, depth: 0, delayed: false };
        let signal = self.build(dimension, &mut site).ok()?;
        match &inputs[..] {
            [] => Some(signal.at(0.0)),
            [Input { source: Source::Controlled { initial, .. }, .. }] => Some(*initial),
            _ => None,
        }
    }

    /// Builds the signal with this dimension.
    pub(super) fn build(&self, dimension: Dimension, site: &mut Site) -> Result<Signal, SignalError> {
        let parse = |q: &Quantity, d| q.value(d);
        let time = |q: &Quantity| parse(q, Dimension::TIME);
        let later = |q: &Quantity| match time(q)? {
            t if t < 0.0 => Err(SignalError::Early { t }),
            t => Ok(t),
        };
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
                Signal::Hold { signal: Box::new(signal.build(dimension, &mut site.within(true))?), at: later(at)? }
            }
            FunctionSpec::Delay { signal, by } => {
                Signal::Delay { signal: Box::new(signal.build(dimension, &mut site.within(true))?), by: later(by)? }
            }
            FunctionSpec::Table { file, unit } => {
                let (path, factor) = (site.base.join(file), units::parse(&format!("1 {unit}"), dimension)?);
                let rows = read_signal(&path, (unit, factor), dimension);
                Signal::Table(rows.map_err(|why| SignalError::Table { file: path.display().to_string(), why })?)
            }
            FunctionSpec::Points { of, unit } => Signal::Table(points(of, unit, dimension)?),
            FunctionSpec::Product { of } => {
                let dimensions = std::iter::once(dimension).chain(std::iter::repeat(Dimension::NONE));
                Signal::Product(build_all(of, dimensions, site, "product")?)
            }
            FunctionSpec::Sum { of } => Signal::Sum(build_all(of, std::iter::repeat(dimension), site, "sum")?),
            FunctionSpec::Expression { formula: text, unit } => {
                let unreadable = |why| SignalError::Formula { text: text.clone(), why };
                let formula = Formula::new(text, units::parse(&format!("1 {unit}"), dimension)?).map_err(unreadable)?;
                match formula.variables().iter().find(|name| *name != "t") {
                    None => Signal::Formula(formula),
                    Some(name) if site.delayed => return Err(SignalError::Delayed(name.clone())),
                    Some(_) => site.input(Source::Formula { formula, event: site.event, variables: Vec::new() }),
                }
            }
            FunctionSpec::Controlled { .. } if site.depth > 0 || site.event.is_some() => {
                return Err(SignalError::Controlled);
            }
            FunctionSpec::Controlled { initial, range } => {
                let initial = parse(initial, dimension)?;
                let end = |q| parse(q, dimension);
                let range =
                    range.as_ref().map(|[low, high]| Ok::<_, SignalError>((end(low)?, end(high)?))).transpose()?;
                if range.is_some_and(|(low, high)| low >= high || !units::within(initial, (low, high))) {
                    return Err(SignalError::Range);
                }
                site.input(Source::Controlled { initial, range })
            }
        })
    }
}

fn points(of: &[[f64; 2]], unit: &str, dimension: Dimension) -> Result<Vec<(f64, f64)>, SignalError> {
    let factor = units::parse(&format!("1 {unit}"), dimension)?;
    let rows: Vec<(f64, f64)> = of.iter().map(|[t, value]| (*t, value * factor)).collect();
    let increases = rows.windows(2).all(|w| w[0].0 < w[1].0);
    let is_finite = rows.iter().all(|(t, value)| t.is_finite() && value.is_finite());
    if rows.is_empty() || !increases || !is_finite { Err(SignalError::Points) } else { Ok(rows) }
}

fn build_all(
    of: &[SignalSpec],
    dimensions: impl Iterator<Item = Dimension>,
    site: &mut Site,
    kind: &'static str,
) -> Result<Vec<Signal>, SignalError> {
    if of.is_empty() {
        return Err(SignalError::Empty(kind));
    }
    of.iter().zip(dimensions).map(|(s, d)| s.build(d, &mut site.within(false))).collect()
}
