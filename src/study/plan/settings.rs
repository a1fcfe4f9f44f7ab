//! A plan: the settings that were weighed, the chosen one, and how the prediction compares with the run.

use crate::study::plan::limit::References;
use crate::study::plan::mesh_limits::Contradiction;
use crate::study::plan::model::Counted;
use crate::study::plan::sizes::Meshes;
use crate::study::plan::steps::Steps;
use serde::Serialize;
use std::collections::BTreeMap;

/// The plan: references from the pilots, settings by time, and the choice.
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
    /// Time by the clock, until the choice was made: pilots, meshes, factorisations
    pub planning_s: f64,
    pub steps: Steps,
    /// Every setting that was weighed, by time
    pub weighed: Vec<Setting>,
    pub chosen: Option<Setting>,
    /// The chosen one is expected within tolerance and budget
    pub meets: bool,
    /// Pilots that speak against the limit, where nothing is expected within tolerance and budget: no setting is advised then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradicted: Option<Contradiction>,
    /// Pilots that could not be used, elements that could not be weighed, and meshes that could not be made: (what, why)
    pub lost: Vec<(String, String)>,
    pub promises: Vec<String>,
    /// A signal ended it, or the run, before all was done
    pub stopped: bool,
    /// How good the prediction was, once the run was made
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

/// A mesh and element with what is expected of it.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Setting {
    /// Short name of element and formulation: `tet10_up`
    #[serde(rename = "element")]
    pub formulation: String,
    /// Number of the element among the choices
    #[serde(skip)]
    pub choice: usize,
    /// Number of cells that is to be asked for
    pub cells: u64,
    /// Changes to the scene, `key=value`
    pub set: Vec<String>,
    pub counted: Counted,
    /// Counted on its mesh; otherwise extrapolated from the pilots
    pub on_its_mesh: bool,
    /// Largest over the quantities \[–\]
    pub error: f64,
    pub limited_by: String,
    /// Known only this well \[–\]: U(f*) of that quantity
    pub uncertainty: f64,
    pub cpu_s: f64,
    /// The same by the clock, on a machine as busy as during the pilots
    pub wall_s: f64,
}

/// Expected and found.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Outcome {
    pub status: String,
    pub cpu_s: f64,
    pub wall_s: f64,
    /// Expected over found
    pub time_ratio: f64,
    /// Error of the quantity that limits, against f* \[–\]
    pub error: f64,
    /// The run is a further mesh of that f*; otherwise it is the one of the pilots
    pub further_mesh: bool,
    /// The error of the steps is known, and in the error
    pub with_steps: bool,
    /// Known this well \[–\]
    pub uncertainty: f64,
    pub error_ratio: f64,
    /// Column → peak of the run
    pub peaks: BTreeMap<String, f64>,
}
