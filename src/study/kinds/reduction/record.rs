//! Records of a reduction study in `study.json` and `derived.json`.

use crate::study::store::origin;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An input of the scene with its range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionInputRecord {
    pub name: String,
    /// Path into the scene of the signal that it takes the place of
    pub key: String,
    pub unit: String,
    /// Least and largest value, in the unit
    pub range: [f64; 2],
    /// Value of the scene at its start, in the unit; none where it depends on what was recorded
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Whether it does not drive: a constant of a law, or the acceleration of a weight
    #[serde(default)]
    pub held: bool,
}

impl ReductionInputRecord {
    /// Whether it is a constant of a law; others are signals.
    pub fn is_constant(&self) -> bool {
        self.key.starts_with("laws.")
    }

    /// A value as a scene has it.
    pub fn text(&self, value: f64) -> toml::Value {
        if self.unit.is_empty() { value.into() } else { format!("{value} {}", self.unit).into() }
    }

    /// The value of the range that is zero, or nearest to it.
    pub fn at_rest(&self) -> f64 {
        0.0_f64.clamp(self.range[0], self.range[1])
    }
}

/// Times of runs in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionMotionRecord {
    /// Length of a run \[s\]
    pub duration: f64,
    /// Time from one corner of an input to the next \[s\]
    pub corner: f64,
}

/// A plan that adds training states where the estimated error is large.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GreedyRecord {
    /// States at most
    pub states: usize,
    /// States that are added at once
    pub batch: usize,
    /// Points at which errors are estimated
    pub candidates: usize,
    /// Largest estimated error at which the search ends, as a share of the largest change
    pub tolerance: f64,
}

/// Details of a reduction study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionRecord {
    /// Scene file, relative to the folder of the study file
    pub scene: PathBuf,
    pub inputs: Vec<ReductionInputRecord>,
    /// Member → \[points × inputs\] in the units of the inputs
    pub training: BTreeMap<String, Vec<Vec<f64>>>,
    pub held_back: BTreeMap<String, Vec<Vec<f64>>>,
    /// Times of runs in time, whose points are the corners of the inputs
    #[serde(default)]
    pub motion: Option<ReductionMotionRecord>,
    /// Where training states are added to these
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greedy: Option<GreedyRecord>,
    /// Meshes that the models are compared with
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meshes: Option<MeshesRecord>,
    /// Numbers of modes of the models that are made
    pub modes: Vec<usize>,
    /// Error of the forces that the choice of points may make \[–\]
    pub sampling: f64,
}

impl ReductionRecord {
    /// The scene file of the study whose results are in a folder. Records of earlier versions have its path from where the study was run.
    pub fn scene_file(&self, dir: &Path) -> PathBuf {
        let of_study = origin::file(dir).map(|study| study.with_file_name("").join(&self.scene));
        of_study.filter(|scene| scene.is_file()).unwrap_or_else(|| self.scene.clone())
    }
}

/// Meshes that run through points which are held back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshesRecord {
    /// The finer mesh from which errors are counted
    pub reference: String,
    /// Run of the states that are held back through whose first points they go
    pub member: String,
    pub points: usize,
}

/// The models of a study, `derived.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DerivedRecord {
    /// Digest of the states, the choices and the program that the models are made of
    pub sources_sha256: String,
    /// The same without the program; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub states_sha256: String,
    /// Length of a step \[s\] of models that move
    #[serde(default)]
    pub dt: Option<f64>,
    /// Training states, or runs in time, and the singular values of their states, as shares of the first
    pub training: usize,
    pub held_back: usize,
    pub singular_values: Vec<f64>,
    pub pressure_values: Vec<f64>,
    /// CPU time of the full model from one state that was held back to the next, or of a step in time \[s\], median of the runs
    pub full_step_s: f64,
    /// Whether it is that from rest to a state: each state that was held back is a run of its own
    #[serde(default)]
    pub full_from_rest: bool,
    /// Time of the work that all models share, adjoint solutions among it \[s\]
    pub offline_s: f64,
    pub models: Vec<ModelRecord>,
    /// Models that could not be made, in sentences
    pub left_out: Vec<String>,
    /// How the greedy search went
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub search: Vec<SearchStep>,
    /// Distances from a finer mesh
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
}

impl DerivedRecord {
    /// The full model as its time is that of a step.
    pub fn full(&self) -> &'static str {
        if self.full_from_rest { "the full model from rest" } else { "the full model" }
    }
}

/// Distances of meshes and models from a finer mesh, at the same points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    pub points: usize,
    /// Cells of the finer mesh, and the time of its step \[s\]
    pub reference_cells: usize,
    pub reference_step_s: f64,
    /// \[quantities\] largest changes from rest on it
    pub sizes: Vec<f64>,
    /// The mesh of the models comes first
    pub meshes: Vec<ReductionMeshRecord>,
    /// \[models × quantities\] largest distance of changes from rest, none where a step did not succeed
    pub models: Vec<Option<Vec<f64>>>,
}

/// A mesh of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionMeshRecord {
    pub name: String,
    pub cells: usize,
    /// CPU time of a step \[s\]
    pub step_s: f64,
    /// \[quantities\] largest distance of changes from rest
    pub errors: Vec<f64>,
}

/// One model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// Modes asked for
    pub modes: usize,
    /// File, relative to the folder of the results
    pub file: String,
    pub bytes: usize,
    /// Digest of the file; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sha256: String,
    /// Coordinates of displacements, supremisers included, and of pressures
    pub displacements: usize,
    pub pressures: usize,
    /// Points from which forces are summed, and those of the error estimate
    pub points: usize,
    pub estimate_points: usize,
    /// Time of its making \[s\]
    pub offline_s: f64,
    /// CPU times of steps of a fiftieth of the way between two points \[s\]: median and 99th percentile
    pub step_s: [f64; 2],
    /// The same of steps from point to point
    pub leap_s: [f64; 2],
    /// Iterations of such steps, on average
    pub iterations: [f64; 2],
    pub quantities: Vec<QuantityRecord>,
}

impl ModelRecord {
    /// How many times less CPU time a step from state to state takes than one of the full model, of `full` \[s\].
    pub fn gain(&self, full: f64) -> f64 {
        full / self.leap_s[0]
    }
}

/// A quantity of a model over the states that were held back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QuantityRecord {
    pub name: String,
    /// Largest change from rest over the training states
    pub size: f64,
    /// Largest and median absolute error, not a number where no step succeeded
    #[serde(deserialize_with = "number")]
    pub largest: f64,
    #[serde(deserialize_with = "number")]
    pub median: f64,
    /// Factor and floor of the bar
    pub factor: f64,
    pub floor: f64,
    /// Median of bar over error, of the errors that count; not a number where none does
    #[serde(deserialize_with = "number")]
    pub bar_over_error: f64,
    /// \[states\] error and its estimate; none where a step did not succeed
    pub errors: Vec<Option<[f64; 2]>>,
}

/// A number, for which JSON has null where it is none.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// A step of a search, as `growth.json` and the report have it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchStep {
    /// States of the model whose errors were estimated
    pub states: usize,
    /// Largest and median estimated error at the candidates, as a share of the largest change; none where no model could be made of so few states
    pub largest: Option<f64>,
    pub median: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quantity that is exact at all states has no ratio of bar and error; its record is read as it was written.
    #[test]
    fn a_quantity_without_errors_is_read_again() {
        let record = QuantityRecord {
            name: "cable_tension_N".into(),
            size: 1.0,
            largest: 0.0,
            median: 0.0,
            factor: 1.0,
            floor: 1e-9,
            bar_over_error: f64::NAN,
            errors: vec![Some([0.0, 0.0]), None],
        };
        let text = serde_json::to_string(&record).expect("numbers and strings");
        let read: QuantityRecord = serde_json::from_str(&text).expect("what was written");
        assert!(read.bar_over_error.is_nan(), "{text}");
        assert_eq!((read.largest, read.errors), (0.0, record.errors));
    }
}
