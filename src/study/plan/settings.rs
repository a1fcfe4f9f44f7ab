//! A plan: the settings that were weighed, the chosen one, and how the prediction compares with the run.

use crate::study::plan::limit::References;
use crate::study::plan::mesh_limits::Contradiction;
use crate::study::plan::model::Counted;
use crate::study::plan::sizes::Meshes;
use crate::study::plan::steps::Steps;
use serde::Serialize;
use std::collections::BTreeMap;

/// The plan: references from the pilots, settings in order of time, and the choice.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Plan {
    pub tolerance: f64,
    pub budget_s: f64,
    pub meshes: Meshes,
    pub quantities: Vec<String>,
    /// Column → limit in the mesh and in the step, from the pilots
    pub references: References,
    pub pilots: Vec<Pilot>,
    pub pilots_cpu_s: f64,
    /// Wall time until the choice was made: pilots, meshes, factorisations
    pub planning_s: f64,
    pub steps: Steps,
    /// Every setting that was weighed, in order of time
    pub weighed: Vec<Setting>,
    pub chosen: Option<Setting>,
    /// Whether the chosen setting is expected to be within tolerance and budget
    pub meets: bool,
    /// Pilots that contradict the limit, if nothing is expected to be within tolerance and budget: no setting is recommended then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradicted: Option<Contradiction>,
    /// Pilots that could not be used, elements that could not be weighed, and meshes that could not be made: (what, why)
    pub lost: Vec<(String, String)>,
    pub promises: Vec<String>,
    /// Whether a signal ended it, or the run, before everything was done
    pub stopped: bool,
    /// How good the prediction was, once the run has been made
    pub outcome: Option<Outcome>,
}

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Pilot {
    pub name: String,
    pub cells: usize,
    pub cpu_s: f64,
    /// Column → peak
    pub peaks: BTreeMap<String, f64>,
}

/// A mesh and element with their expected error and cost.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Setting {
    /// Short name of element and formulation: `tet10_up`
    #[serde(rename = "element")]
    pub formulation: String,
    /// Index of the element among the choices
    #[serde(skip)]
    pub choice: usize,
    /// Requested number of cells
    pub cells: u64,
    /// Changes to the scene, `key=value`
    pub set: Vec<String>,
    pub counted: Counted,
    /// Whether the work was counted on its mesh; otherwise it is extrapolated from the pilots
    pub on_its_mesh: bool,
    /// Largest expected error over the quantities \[–\]
    pub error: f64,
    pub limited_by: String,
    /// Uncertainty of the limit of that quantity, U(f*)/|f*| \[–\]
    pub uncertainty: f64,
    pub cpu_s: f64,
    /// Expected wall time, on a machine as busy as during the pilots \[s\]
    pub wall_s: f64,
}

/// Comparison of the run with the expectation.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Outcome {
    pub status: String,
    pub cpu_s: f64,
    pub wall_s: f64,
    /// Ratio of expected to actual time
    pub time_ratio: f64,
    /// Error of the limiting quantity relative to f* \[–\]
    pub error: f64,
    /// Whether the run contributes a further mesh to this f*; otherwise f* is that of the pilots
    pub further_mesh: bool,
    /// Whether the error of the steps is known and included in the error
    pub with_steps: bool,
    /// Uncertainty of f* \[–\]
    pub uncertainty: f64,
    pub error_ratio: f64,
    /// Column → peak of the run
    pub peaks: BTreeMap<String, f64>,
}
