//! Keys of a validation in the study file.

use crate::scene::changes;
use crate::schema::AnyTable;
use crate::study::spec::FamilySpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Keys of a validation.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationStudy {
    /// Constants that are determined from the calibration records
    #[serde(rename = "unknown", default)]
    pub unknowns: Vec<UnknownSpec>,
    /// Numbers that are known with an uncertainty
    #[serde(rename = "input", default)]
    pub inputs: Vec<UncertainInputSpec>,
    /// Experiments with their scenes
    #[serde(rename = "record", default)]
    pub records: Vec<RecordSpec>,
    /// Quantities that are measured or predicted
    #[serde(rename = "quantity", default)]
    pub quantities: Vec<QuantitySpec>,
    /// Fields of displacements
    #[serde(rename = "field", default)]
    pub fields: Vec<MeasuredFieldSpec>,
    /// Families of cases that differ in one respect
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// Origin of the values under `measured`, in words, if they are not measured: `COMSOL`
    pub reference: Option<String>,
    /// Runs per record at random points, which show the errors of the response surfaces
    #[serde(default = "usual_checks")]
    pub checks: usize,
}

fn usual_checks() -> usize {
    3
}

/// A constant of the scenes that the calibration records determine.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnknownSpec {
    /// Part of the case ids
    pub name: String,
    /// Path into the scenes; records whose scene lacks it do not depend on it
    pub key: String,
    /// The constant in words
    pub label: String,
    /// Letter in formulae and on axes
    pub symbol: String,
    /// Range in which it is searched for
    #[schemars(with = "[serde_json::Value; 2]")]
    pub range: [toml::Value; 2],
}

/// A number of the scenes that is known with an uncertainty.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainInputSpec {
    /// Name of the input
    pub name: String,
    /// Paths into the scenes that change together; a record uses those that its scene has
    pub keys: Vec<String>,
    /// Standard deviation: a quantity, or a percentage of the value in the scene
    pub deviation: String,
    /// Origin of the deviation
    pub source: String,
    /// Group under which it counts in the budget; the name if absent
    pub group: Option<String>,
    /// Records that it acts on; if absent, all whose scene has one of the keys
    pub records: Option<Vec<String>>,
}

/// Purpose of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// The record determines the constants
    Calibration,
    /// The record is predicted with the constants
    Prediction,
}

/// One experiment and its scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordSpec {
    /// Part of the case ids
    pub name: String,
    /// Name in words; `name` if absent
    pub label: Option<String>,
    /// Name of the experiment, if several records belong to one; the name of the record if absent
    pub experiment: Option<String>,
    /// Purpose of the record
    pub purpose: Purpose,
    /// Scene file, relative to the study; the scene of the study if absent
    pub scene: Option<PathBuf>,
    /// Changes by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Measured tracks of markers
    pub tracks: Option<TracksSpec>,
}

impl RecordSpec {
    /// Returns the name of its experiment.
    pub fn experiment(&self) -> &str {
        self.experiment.as_ref().unwrap_or(&self.name)
    }
}

/// Files of marker tracks of one experiment, and how to read them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracksSpec {
    /// C3D, TRC or tables, relative to the study; several files are repeats
    pub files: Vec<PathBuf>,
    /// Unit of the coordinates; the unit stated in the file if absent
    pub unit: Option<String>,
    /// Unit of the times of a table
    pub time_unit: Option<String>,
    /// Frames per second, `100 Hz`
    pub rate: Option<String>,
    /// Record to read from a table that holds several
    pub record: Option<String>,
    /// Markers that move as a rigid body
    pub body: Option<Vec<String>>,
    /// Point of the body that is followed, given in the held state
    pub at: Option<[String; 3]>,
    /// Table of marker positions in the frame of the scene, onto which the held state is registered
    pub reference: Option<PathBuf>,
    /// Window of the held state in the time of the tracks; found if absent
    pub held: Option<[String; 2]>,
    /// Window of the final state in the time of the tracks; found if absent
    #[serde(rename = "final")]
    pub last: Option<[String; 2]>,
    /// Departure from the held state that counts as release
    pub threshold: Option<String>,
}

/// The number that is taken from a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Evaluation {
    /// The last value of the column
    #[default]
    Final,
    /// The last value minus the first
    Change,
    /// Frequency of the ring-down \[Hz\]
    Frequency,
    /// Decay rate of the ring-down \[1/s\]
    Decay,
}

/// A quantity that is measured or predicted.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuantitySpec {
    /// Name of the quantity
    pub name: String,
    /// The quantity in words
    pub label: String,
    /// Letter in formulae and on axes
    pub symbol: String,
    /// Unit of the quantity
    pub unit: String,
    /// Recorded column of the scene
    pub column: String,
    /// The number that is taken from the column
    #[serde(default)]
    pub value: Evaluation,
    /// Factor; −1 for a drop that the column counts upwards
    #[serde(default = "one")]
    pub times: f64,
    /// Times between which a ring-down is evaluated
    pub window: Option<[String; 2]>,
    /// Records that it is taken from; all if absent
    pub records: Option<Vec<String>>,
    /// Measured value, or its repeats, by record \[unit\]
    #[serde(default)]
    pub measured: BTreeMap<String, Repeats>,
    /// Measured values in a file
    pub table: Option<TableSpec>,
    /// Measured curve of the tracks of its records: `tip_z_m`
    pub curve: Option<String>,
    /// Errors of the measurement
    #[serde(rename = "error", default)]
    pub errors: Vec<ErrorSpec>,
}

fn one() -> f64 {
    1.0
}

/// A measured value or several.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize, PartialEq)]
#[serde(untagged)]
pub enum Repeats {
    /// A single measured value
    One(f64),
    /// Values of several repeats
    Several(Vec<f64>),
}

impl Repeats {
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::One(value) => vec![*value],
            Self::Several(values) => values.clone(),
        }
    }
}

/// Rows of a CSV file that hold measured values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// File, relative to the study
    pub file: PathBuf,
    /// Column of the measured values
    pub column: String,
    /// Unit of the numbers in the file
    pub unit: String,
    /// Text that selects rows, by column; `{experiment}` is replaced by the experiment of the record. Several rows are repeats.
    #[serde(rename = "where")]
    pub rows: BTreeMap<String, String>,
}

/// Displacements of many points, from image correlation or markers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredFieldSpec {
    /// Part of the names of its columns and quantities
    pub name: String,
    /// CSV file, relative to the study; `{experiment}` is replaced by the experiment of the record
    pub file: String,
    /// Unit of its lengths
    pub unit: String,
    /// Columns of the position of a point at rest, in the frame of the body
    pub position: [String; 3],
    /// Columns of its displacement at the end of the run
    pub displacement: [String; 3],
    /// Records that it is taken from; all if absent
    pub records: Option<Vec<String>>,
    /// Standard deviation of a component of a point
    pub deviation: String,
    /// Standard deviation of each residual shift of the registration
    pub shift: Option<String>,
    /// Standard deviation of each residual rotation of the registration
    pub rotation: Option<String>,
    /// Origin of the deviations
    pub source: String,
}

/// An error of the measurement of a quantity.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorSpec {
    /// Group under which it counts in the budget
    pub group: String,
    /// Standard deviation
    pub deviation: String,
    /// Origin of the deviation
    pub source: String,
    /// Whether one error is common to all records, instead of one for each
    #[serde(default)]
    pub shared: bool,
}
