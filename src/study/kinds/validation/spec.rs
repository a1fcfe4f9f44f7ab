//! Keys of a validation as the study file gives them.

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
    /// Constants that are found from the calibration records
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
    /// Origin of the values under `measured`, in words, where they are not measured: `COMSOL`
    pub reference: Option<String>,
    /// Runs per record at random places, which show how far the response surfaces are off
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
    /// Path into the scenes; records whose scene does not have it do not depend on it
    pub key: String,
    /// The constant in words
    pub label: String,
    /// Letter in formulae and on axes
    pub symbol: String,
    /// Within which it is looked for
    #[schemars(with = "[serde_json::Value; 2]")]
    pub range: [toml::Value; 2],
}

/// A number of the scenes that is known with an uncertainty.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainInputSpec {
    /// Name of the input
    pub name: String,
    /// Paths into the scenes that change together; a record has those of its scene
    pub keys: Vec<String>,
    /// Standard deviation: a quantity, or a share of the value in the scene in %
    pub deviation: String,
    /// Where the deviation is from
    pub source: String,
    /// Under which it counts in the budget; the name if absent
    pub group: Option<String>,
    /// Records that it acts on; all whose scene has one of the keys if absent
    pub records: Option<Vec<String>>,
}

/// Purpose of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// The record determines the constants
    Calibration,
    /// The record is predicted with them
    Prediction,
}

/// One experiment, and its scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordSpec {
    /// Part of the case ids
    pub name: String,
    /// In words; the name if absent
    pub label: Option<String>,
    /// Name of the experiment, where several records are of one; the name of the record if absent
    pub experiment: Option<String>,
    /// Purpose of the record
    pub purpose: Purpose,
    /// Relative to the study; its scene if absent
    pub scene: Option<PathBuf>,
    /// Changes by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Measured tracks of markers
    pub tracks: Option<TracksSpec>,
}

impl RecordSpec {
    /// Name of its experiment.
    pub fn experiment(&self) -> &str {
        self.experiment.as_ref().unwrap_or(&self.name)
    }
}

/// Files of marker tracks of one experiment, with statements on how they are read.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracksSpec {
    /// C3D, TRC or tables relative to the study; several are repeats
    pub files: Vec<PathBuf>,
    /// Unit of the coordinates; the one that the file states if absent
    pub unit: Option<String>,
    /// Unit of the times of a table
    pub time_unit: Option<String>,
    /// Frames per second, `100 Hz`
    pub rate: Option<String>,
    /// Record of a table that holds several
    pub record: Option<String>,
    /// Markers that move as a rigid body
    pub body: Option<Vec<String>>,
    /// Point of the body that is followed, in the held state
    pub at: Option<[String; 3]>,
    /// Table of marker positions in the frame of the scene, onto which the held state is registered
    pub reference: Option<PathBuf>,
    /// Windows of the states; found if absent
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
    /// Its last value
    #[default]
    Final,
    /// Its last value minus its first
    Change,
    /// Frequency of its ring-down \[Hz\]
    Frequency,
    /// Rate at which its ring-down decays \[1/s\]
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
    /// Factor, −1 for a drop that the column counts upwards
    #[serde(default = "one")]
    pub times: f64,
    /// Times between which a ring-down is evaluated
    pub window: Option<[String; 2]>,
    /// Records that it is taken from; all if absent
    pub records: Option<Vec<String>>,
    /// Record → measured value, or its repeats \[unit\]
    #[serde(default)]
    pub measured: BTreeMap<String, Repeats>,
    /// Measured values in a file
    pub table: Option<TableSpec>,
    /// Curve of the tracks of its records that is measured, `tip_z_m`
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
    /// One measured value
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
    /// Relative to the study
    pub file: PathBuf,
    /// Column of the measured values
    pub column: String,
    /// Unit of the numbers in the file
    pub unit: String,
    /// Column → text of the rows that count; `{experiment}` is replaced by the experiment of the record. Several rows are repeats.
    #[serde(rename = "where")]
    pub rows: BTreeMap<String, String>,
}

/// Displacements of many points, by image correlation or markers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredFieldSpec {
    /// Part of the names of its columns and quantities
    pub name: String,
    /// CSV relative to the study; `{experiment}` is replaced by the experiment of the record
    pub file: String,
    /// Unit of its lengths
    pub unit: String,
    /// Columns of the place of a point at rest, in the frame of the body
    pub position: [String; 3],
    /// Columns of its displacement at the end of the run
    pub displacement: [String; 3],
    /// Records that it is taken from; all if absent
    pub records: Option<Vec<String>>,
    /// Standard deviation of a component of a point
    pub deviation: String,
    /// Standard deviation of each shift that registration leaves
    pub shift: Option<String>,
    /// Standard deviation of each rotation that registration leaves
    pub rotation: Option<String>,
    /// Where the deviations are from
    pub source: String,
}

/// An error of the measurement of a quantity.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorSpec {
    /// Under which it counts in the budget
    pub group: String,
    /// Standard deviation
    pub deviation: String,
    /// Where the deviation is from
    pub source: String,
    /// One error for all records, instead of one for each
    #[serde(default)]
    pub shared: bool,
}
