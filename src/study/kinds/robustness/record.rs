//! Details that a robustness study keeps with its record.

use crate::study::axis::AxisRecord;
use crate::study::kinds::robustness::check::Check;
use crate::study::store::record::StudyQuantity;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The suites and maps of a study.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct RobustnessRecord {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suites: Vec<SuiteRecord>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub maps: Vec<MapRecord>,
    /// Maps and suites that a study around a scene lacks, each with the reason in a sentence
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

/// A suite as it is stored with the study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SuiteRecord {
    pub family: String,
    pub setup: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<Vec<String>>,
    #[serde(default)]
    pub checks: Vec<Check>,
}

/// A map as it is stored with the study.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct MapRecord {
    pub family: String,
    pub setup: String,
    pub quantity: StudyQuantity,
    /// The axes along x and y
    pub axes: Vec<AxisRecord>,
    /// Index along x and y by member
    pub points: BTreeMap<String, Vec<usize>>,
    /// Family of the reference cases
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Member of the reference family for each value along y
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
}
