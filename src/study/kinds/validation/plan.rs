//! A validation as it is stored with the study: ranges, uncertainties and measured values in SI or in the units of the quantities.

use crate::study::kinds::validation::spec::{Evaluation, Purpose};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Details of a validation.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ValidationPlan {
    pub unknowns: Vec<UnknownPlan>,
    pub inputs: Vec<InputPlan>,
    pub records: Vec<RecordPlan>,
    pub quantities: Vec<QuantityPlan>,
    pub families: Vec<FamilyPlan>,
    /// Origin of the values that predictions are compared with, in words; they are measured if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Files of tracks that values were measured in
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TracksPlan>,
    /// Case of the design → its place ξ among the unknowns of its record
    pub points: BTreeMap<String, Vec<f64>>,
    /// Case of a check → its place ξ, and the inputs of its record in standard deviations
    pub checks: BTreeMap<String, (Vec<f64>, Vec<f64>)>,
}

/// A family of the study file.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct FamilyPlan {
    pub name: String,
    pub members: usize,
    /// Records that it runs, in the order of the study
    pub records: Vec<String>,
}

/// A constant that is found.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct UnknownPlan {
    pub name: String,
    pub key: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    /// \[unit\]
    pub range: [f64; 2],
    /// SI units per unit
    pub factor: f64,
}

impl UnknownPlan {
    /// The value at ξ \[unit\].
    pub fn at(&self, xi: f64) -> f64 {
        0.5 * (self.range[0] + self.range[1]) + xi * self.half()
    }

    /// Half of its range, one unit of ξ \[unit\].
    pub fn half(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }
}

/// A number that is known with an uncertainty.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct InputPlan {
    pub name: String,
    pub group: String,
    /// The deviation as the study gives it
    pub deviation: String,
    pub source: String,
    /// It is the interval of a law file, not stated by the study
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_law_file: bool,
}

/// One record.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct RecordPlan {
    pub name: String,
    pub label: String,
    pub experiment: String,
    pub purpose: Purpose,
    /// Unknowns that its scene has
    pub unknowns: Vec<usize>,
    /// Inputs that its scene has: index, and its keys with one standard deviation \[SI\]
    pub inputs: Vec<(usize, Vec<(String, f64)>)>,
    /// Constants of its laws whose files leave their intervals open
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<String>,
}

impl RecordPlan {
    /// Keys that its derivatives are by, each once.
    pub fn keys(&self, unknowns: &[UnknownPlan]) -> Vec<String> {
        let mut keys: Vec<String> = self.unknowns.iter().map(|k| unknowns[*k].key.clone()).collect();
        for (key, _) in self.inputs.iter().flat_map(|(_, keys)| keys) {
            if !keys.contains(key) {
                keys.push(key.clone());
            }
        }
        keys
    }
}

/// A quantity over the records it is taken from.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct QuantityPlan {
    pub name: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    pub column: String,
    pub value: Evaluation,
    /// Factor from the column to the quantity
    pub factor: f64,
    /// \[s\]
    pub window: Option<[f64; 2]>,
    /// Record → measured values; empty where it is only predicted
    pub records: BTreeMap<String, Vec<f64>>,
    pub errors: Vec<ErrorPlan>,
    /// Record → errors that it has in addition
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub by_record: BTreeMap<String, Vec<ErrorPlan>>,
}

impl QuantityPlan {
    /// The errors of a measurement of it in a record.
    pub fn errors_of<'a>(&'a self, record: &str) -> impl Iterator<Item = &'a ErrorPlan> {
        self.errors.iter().chain(self.by_record.get(record).into_iter().flatten())
    }
}

/// A file of tracks with the audit of its evaluation.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct TracksPlan {
    pub record: String,
    pub file: String,
    pub sha256: String,
    pub log: Vec<String>,
    /// Reasons to doubt its values
    pub doubts: Vec<String>,
}

/// An error of a measurement.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ErrorPlan {
    pub group: String,
    /// \[unit of the quantity\]
    pub deviation: f64,
    pub source: String,
    /// Name of the source, where several data share it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared: Option<String>,
}
