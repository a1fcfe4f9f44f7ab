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
    /// Origin of the values that predictions are compared with, in words; measured if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// Files of tracks from which values were measured
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TracksPlan>,
    /// Point ξ among the unknowns of its record, by case of the design
    pub points: BTreeMap<String, Vec<f64>>,
    /// Point ξ, and the inputs of its record in standard deviations, by case of a check
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

/// A constant to be determined.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct UnknownPlan {
    pub name: String,
    pub key: String,
    pub label: String,
    pub symbol: String,
    pub unit: String,
    /// Smallest and largest value \[unit\]
    pub range: [f64; 2],
    /// SI value of one unit
    pub factor: f64,
}

impl UnknownPlan {
    /// Returns the value at ξ \[unit\].
    pub fn at(&self, xi: f64) -> f64 {
        0.5 * (self.range[0] + self.range[1]) + xi * self.half()
    }

    /// Returns half of its range, which is one unit of ξ \[unit\].
    pub fn half(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }
}

/// A number that is known with an uncertainty.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct InputPlan {
    pub name: String,
    pub group: String,
    /// The deviation as stated in the study
    pub deviation: String,
    pub source: String,
    /// Whether it comes from the interval of a law file rather than from the study
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
    /// Indices of the unknowns that its scene has
    pub unknowns: Vec<usize>,
    /// Inputs that its scene has: index, and keys with one standard deviation each \[SI\]
    pub inputs: Vec<(usize, Vec<(String, f64)>)>,
    /// Constants of its laws whose law files leave their intervals open
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<String>,
}

impl RecordPlan {
    /// Returns the keys that derivatives are taken by, each once.
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

/// A quantity over the records from which it is taken.
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
    /// Start and end of the window of a ring-down \[s\]
    pub window: Option<[f64; 2]>,
    /// Measured values by record; empty if it is only predicted
    pub records: BTreeMap<String, Vec<f64>>,
    pub errors: Vec<ErrorPlan>,
    /// Additional errors by record
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub by_record: BTreeMap<String, Vec<ErrorPlan>>,
}

impl QuantityPlan {
    /// Returns the errors of its measurement in a record.
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
    /// Standard deviation \[unit of the quantity\]
    pub deviation: f64,
    pub source: String,
    /// Name of the source, if several data share it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared: Option<String>,
}
