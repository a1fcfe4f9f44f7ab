//! What a finished case leaves on disk, and what every report reads: `cases/<id>.json` beside `cases/<id>.csv`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A finished case (also one that stopped early: `status` says so).
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct CaseRecord {
    /// `<family>-<variant>-<member>`, also the file stem
    pub id: String,
    /// Family of meshes or steps it belongs to: `sizes`, `nested`, …
    pub family: String,
    /// Variant of the scene: `length` or `tension`
    pub variant: String,
    pub mesh: MeshRecord,
    /// `tet4`, `tet10`
    pub formulation: String,
    /// Name of the law, with its constants in SI
    pub law: LawRecord,
    pub integrator: String,
    /// Largest time step [s]
    pub dt_s: f64,
    /// `Converged`, `StepTooSmall`, …
    pub status: String,
    /// What, where and the remedy, if the status is not `Converged`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status_detail: Option<String>,
    /// Wall time of the solution, mesh and report apart [s]
    pub wall_s: f64,
    /// CPU time of the thread that solved it [s]
    pub cpu_s: f64,
    /// Another case ran at the same time: `wall_s` is then no price
    pub shared: bool,
    pub steps: usize,
    pub newton_iterations: usize,
    /// Steps that did not converge and were halved
    pub cuts: usize,
    /// Free degrees of freedom
    pub dofs: usize,
    /// Entries of the Cholesky factor
    pub factor_nnz: usize,
    /// Name and cost of every effect and constraint that was assembled
    pub effects: Vec<EffectRecord>,
    pub phases: PhaseRecord,
    /// Per recorded column of the CSV
    pub probes: BTreeMap<String, ProbeRecord>,
    pub provenance: Provenance,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct MeshRecord {
    pub cells: usize,
    pub nodes: usize,
    /// (V/N)^{1/3} [m]
    pub h_m: f64,
    /// Smallest radius ratio 3 r_in/r_circ of a cell [–]
    pub min_quality: f64,
    pub mean_quality: f64,
    pub volume_m3: f64,
    /// File name or hash of the request that produced it
    pub source: String,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct LawRecord {
    pub name: String,
    /// Parameter name → value [SI]
    pub parameters: BTreeMap<String, f64>,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct EffectRecord {
    pub name: String,
    /// Time of its evaluations [s]
    pub wall_s: f64,
}

/// Where the time went [s].
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct PhaseRecord {
    pub assembly_s: f64,
    pub factorisation_s: f64,
    pub solve_s: f64,
    pub output_s: f64,
}

/// Peak is the value of largest magnitude; the unit is in the name of the probe (`bending_angle_deg`).
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct ProbeRecord {
    pub peak: f64,
    pub peak_t_s: f64,
    #[serde(rename = "final")]
    pub last: f64,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Provenance {
    /// SHA-256 of the resolved scene and of the mesh
    pub input_sha256: String,
    /// Version of this program
    pub version: String,
    /// The resolved scene, as TOML
    pub scene: String,
}

/// Boundary of the body in the reference state and at the peak of the protocol, for pictures: `cases/<id>.skin.json`.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Skin {
    /// [nodes] reference positions [m]
    pub points: Vec<[f64; 3]>,
    /// [triangles] corner nodes, outward
    pub triangles: Vec<[u32; 3]>,
    /// Time of the state below [s]
    pub t_s: f64,
    /// [nodes] displacement [m]
    pub displacement: Vec<[f64; 3]>,
    /// [nodes] largest principal stretch, volume-weighted mean over the cells at the node [–]
    pub stretch: Vec<f64>,
    /// Polyline of each cable at that time [m], pull point first
    pub cables: Vec<Vec<[f64; 3]>>,
}
