//! Records of a reduction study in `study.json` and `derived.json`.

use crate::study::store::origin;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An input of the scene with its range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionInputRecord {
    pub name: String,
    /// Path into the scene of the signal or constant that it replaces
    pub key: String,
    pub unit: String,
    /// Smallest and largest value, in the unit
    pub range: [f64; 2],
    /// Value at the start of the scene, in the unit; `None` if it depends on recorded columns
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Whether it is held rather than driven: a constant of a law, or the acceleration of a weight
    #[serde(default)]
    pub held: bool,
}

impl ReductionInputRecord {
    /// Whether the input is a constant of a law; otherwise it is a signal.
    pub fn is_constant(&self) -> bool {
        self.key.starts_with("laws.")
    }

    /// Returns a value in the form used by scenes.
    pub fn text(&self, value: f64) -> toml::Value {
        if self.unit.is_empty() { value.into() } else { format!("{value} {}", self.unit).into() }
    }

    /// Returns the value of the range that is zero, or nearest to it.
    pub fn at_rest(&self) -> f64 {
        0.0_f64.clamp(self.range[0], self.range[1])
    }
}

/// Time parameters of runs in time.
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
    /// Largest number of states
    pub states: usize,
    /// Number of states that are added at once
    pub batch: usize,
    /// Number of points at which errors are estimated
    pub candidates: usize,
    /// Largest estimated error at which the search ends, relative to the largest change
    pub tolerance: f64,
}

/// Details of a reduction study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionRecord {
    /// Scene file, relative to the folder of the study file
    pub scene: PathBuf,
    pub inputs: Vec<ReductionInputRecord>,
    /// Points of each member \[points × inputs\], in the units of the inputs
    pub training: BTreeMap<String, Vec<Vec<f64>>>,
    pub held_back: BTreeMap<String, Vec<Vec<f64>>>,
    /// Parameters of runs in time, whose points are the corners of the inputs
    #[serde(default)]
    pub motion: Option<ReductionMotionRecord>,
    /// Plan by which training states are added to these
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greedy: Option<GreedyRecord>,
    /// Meshes that the models are compared with
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meshes: Option<MeshesRecord>,
    /// Numbers of modes, one model for each
    pub modes: Vec<usize>,
    /// Largest error of the forces that the choice of points may cause \[–\]
    pub sampling: f64,
}

impl ReductionRecord {
    /// Returns the scene file of the study with results in `dir`. Records of earlier versions store its path relative to the folder where the study
    /// was run.
    pub fn scene_file(&self, dir: &Path) -> PathBuf {
        let of_study = origin::file(dir).map(|study| study.with_file_name("").join(&self.scene));
        of_study.filter(|scene| scene.is_file()).unwrap_or_else(|| self.scene.clone())
    }
}

/// Meshes that are run through held-back points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshesRecord {
    /// The finer mesh that errors are measured from
    pub reference: String,
    /// Run of held-back states whose first points they pass through
    pub member: String,
    pub points: usize,
}

/// The models of a study as stored in `derived.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DerivedRecord {
    /// Digest of the states, the choices and the program that the models are made of
    pub sources_sha256: String,
    /// Digest without the program; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub states_sha256: String,
    /// Length of a step \[s\], for models that move
    #[serde(default)]
    pub dt: Option<f64>,
    /// Number of training states, or of runs in time; the singular values of the states are relative to the first
    pub training: usize,
    pub held_back: usize,
    pub singular_values: Vec<f64>,
    pub pressure_values: Vec<f64>,
    /// CPU time of the full model from one held-back state to the next, or of a step in time \[s\]; median over the runs
    pub full_step_s: f64,
    /// Whether that time is from rest to a state, because each held-back state is a separate run
    #[serde(default)]
    pub full_from_rest: bool,
    /// Time of the work shared by all models, including adjoint solutions \[s\]
    pub offline_s: f64,
    pub models: Vec<ModelRecord>,
    /// Models that could not be made, in sentences
    pub left_out: Vec<String>,
    /// Steps of the greedy search
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub search: Vec<SearchStep>,
    /// Distances from a finer mesh
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
}

impl DerivedRecord {
    /// Returns the full model in words that match its time per step.
    pub fn full(&self) -> &'static str {
        if self.full_from_rest { "the full model from rest" } else { "the full model" }
    }
}

/// Distances of meshes and models from a finer mesh, at the same points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    pub points: usize,
    /// Number of cells of the finer mesh, and its time per step \[s\]
    pub reference_cells: usize,
    pub reference_step_s: f64,
    /// Largest changes from rest on the finer mesh \[quantities\]
    pub sizes: Vec<f64>,
    /// Compared meshes; the mesh of the models comes first
    pub meshes: Vec<ReductionMeshRecord>,
    /// Largest distance of the changes from rest \[models × quantities\]; `None` if a step failed
    pub models: Vec<Option<Vec<f64>>>,
}

/// A mesh of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionMeshRecord {
    pub name: String,
    pub cells: usize,
    /// CPU time of a step \[s\]
    pub step_s: f64,
    /// Largest distance of the changes from rest \[quantities\]
    pub errors: Vec<f64>,
}

/// One model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// Number of modes asked for
    pub modes: usize,
    /// File, relative to the folder of the results
    pub file: String,
    pub bytes: usize,
    /// Digest of the file; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub sha256: String,
    /// Number of coordinates of the displacements, including supremisers, and of the pressures
    pub displacements: usize,
    pub pressures: usize,
    /// Number of points over which forces are summed, and of those for the error estimate
    pub points: usize,
    pub estimate_points: usize,
    /// Time to make it \[s\]
    pub offline_s: f64,
    /// CPU times of steps of a fiftieth of the path between two points \[s\]: median and 99th percentile
    pub step_s: [f64; 2],
    /// CPU times of steps from point to point \[s\]: median and 99th percentile
    pub leap_s: [f64; 2],
    /// Mean number of iterations of these two kinds of steps
    pub iterations: [f64; 2],
    pub quantities: Vec<QuantityRecord>,
}

impl ModelRecord {
    /// Returns the ratio of the CPU time per step of the full model, `full` \[s\], to that of this model from state to state.
    pub fn gain(&self, full: f64) -> f64 {
        full / self.leap_s[0]
    }
}

/// A quantity of a model over the held-back states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QuantityRecord {
    pub name: String,
    /// Largest change from rest over the training states
    pub size: f64,
    /// Largest and median absolute error; NaN if no step succeeded
    #[serde(deserialize_with = "number")]
    pub largest: f64,
    #[serde(deserialize_with = "number")]
    pub median: f64,
    /// Factor and floor of the error bar
    pub factor: f64,
    pub floor: f64,
    /// Median ratio of bar to error over the errors that count; NaN if none counts
    #[serde(deserialize_with = "number")]
    pub bar_over_error: f64,
    /// Error and its estimate at each state; `None` if a step failed
    pub errors: Vec<Option<[f64; 2]>>,
}

/// Reads a number; JSON has null for NaN.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// A step of a search as stored in `growth.json` and shown in the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchStep {
    /// Number of states of the model whose errors were estimated
    pub states: usize,
    /// Largest and median estimated error at the candidates, relative to the largest change; `None` if no model could be made from so few states
    pub largest: Option<f64>,
    pub median: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quantity that is exact at all states has no ratio of bar to error; its record can be read back.
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
