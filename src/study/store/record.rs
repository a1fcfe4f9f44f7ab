//! Record of a finished case, which all reports read: `cases/<id>.json` next to `cases/<id>.csv`.

use crate::material::Law;
use crate::math::units::Dimension;
use crate::scene::control::{ControllerRecord, Fired};
use crate::scene::parts::constraints::CableEvent;
use crate::scene::{ExtremeKind, FileDigest, Measured, column};
use crate::solve::{Integrator, Status, integrator_order};
use crate::study::overlay::distance::{Distance, MarkerDistance};
use crate::study::run::one_run::OneRunRecord;
use crate::study::run::refinement::RefinementRecord;
use crate::study::run::uncertain_constants::UncertainConstantRecord;
use crate::study::run::work::{RepeatRecord, WorkRecord};
use crate::study::store::asked::{Asked, Asks};
use crate::study::store::contact_record::ContactRecord;
use crate::study::store::identity::{Build, Identity};
use crate::study::store::solver_record::SolverRecord;
use crate::wording::distinct;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use crate::study::store::series::{Place, Series, StoredCase};
pub use crate::study::store::status::{
    CRASHED, INPUTS_CHANGED, NOT_DETERMINED, NOT_RUN, NOT_SETTLED, OUT_OF_MEMORY, OUT_OF_TIME, PANICKED, REFUSED,
};
pub use crate::study::store::study_record::{FamilyRecord, Member, Role, StudyQuantity, StudyRecord, VariantMember};

/// Format version of `cases/<id>.json` and `study.json`. It is increased when present programs could no longer read them; files of a later version are
/// refused.
pub const SCHEMA: u32 = 1;

/// Record of a finished case, including one that stopped early: its mesh, its status, its cost, and the extremes of its columns.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct CaseRecord {
    /// Id `<family>-<variant>-<member>`, also the file stem
    pub id: String,
    /// Family of meshes or steps in which it was first run: `sizes`, `nested`, …
    pub family: String,
    /// Variant of the scene in which it was first run: `length` or `tension`
    pub variant: String,
    /// Value that distinguishes it from the rest of its family: a size, a law
    #[serde(default)]
    pub member: String,
    pub mesh: MeshRecord,
    /// Short name of element and formulation: `tet4`, `tet10_up`, `mass_spring`
    pub formulation: String,
    /// Name of the law, with its constants in SI; absent if springs are the only elastic part
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<LawRecord>,
    /// Name of the integrator of the stages in time; of several, the last of those with the lowest order. If all stages are static, that of the last
    pub integrator: String,
    /// Order of convergence of that integrator in the time step; `None` in statics, and in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_in_time: Option<u8>,
    /// Longest time step \[s\]
    pub dt_s: f64,
    /// Time step of each stage \[s\]; empty in records of earlier versions
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stage_dt_s: Vec<f64>,
    /// Permitted error that determines the time steps \[m\]; `None` if they have a fixed length
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_error_m: Option<f64>,
    /// Mean length of the time steps in stages that are not static \[s\]; `None` without such stages
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_dt_s: Option<f64>,
    /// Whether the states depend on the time steps, through dynamics or through the path of loading; `None` in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps_matter: Option<bool>,
    /// Largest excess of a prescribed signal over its values at the time-grid points of stages in which no masses move, relative to its range \[–\];
    /// `None` if there is none, and in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_share: Option<f64>,
    /// Largest excess of a prescribed signal over its values at the time-grid points of all stages, relative to its range \[–\], for quantities such as
    /// forces whose motion is not checked; `None` if no masses move, and in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen_force_share: Option<f64>,
    /// `Converged`, `StepTooSmall`, …
    pub status: String,
    /// Fact, place and remedy, if the status is not `Converged`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status_detail: Option<String>,
    /// Work of the solver, and where it stopped
    #[serde(default)]
    pub solver: SolverRecord,
    /// Wall time of the solution, without mesh and report \[s\]
    pub wall_s: f64,
    /// CPU time of the threads that computed the solution \[s\], the cost that studies compare
    pub cpu_s: f64,
    /// Whether another case ran at the same time: `wall_s` is then not a measure of its cost
    pub shared: bool,
    pub steps: usize,
    pub newton_iterations: usize,
    /// Steps that did not converge and were halved
    pub cuts: usize,
    /// Free degrees of freedom
    pub dofs: usize,
    /// Number of entries of the Cholesky factor
    pub factor_nnz: usize,
    /// Name and cost of every assembled effect and constraint
    pub effects: Vec<EffectRecord>,
    pub phases: PhaseRecord,
    /// Counted work; zeros in records of earlier versions
    #[serde(default)]
    pub work: WorkRecord,
    /// Times of every run, if the case was run several times; `wall_s` and `cpu_s` are those of the median one
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repeats: Vec<RepeatRecord>,
    /// Signs of volumetric locking at the state farthest from rest; `None` for a body that does not move
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub locking: Option<LockingRecord>,
    /// Extremes and last values of the recorded columns, by column of the CSV
    pub probes: BTreeMap<String, ProbeRecord>,
    /// Cables that went slack, taut, or to the limit of their drive
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cable_events: Vec<CableEventRecord>,
    /// Pairs and points examined by each contact
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<ContactRecord>,
    /// Notes for the reader: regions that depend on the mesh, patches smaller than the cells, …
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Distances from measured curves
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub distances: Vec<Distance>,
    /// The measured curves themselves, for figures
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<Measured>,
    /// Distances from measured markers
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<MarkerDistance>,
    /// Errors estimated from this run alone, if the study requests them
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_run: Option<OneRunRecord>,
    /// Derivatives with respect to constants whose law file gives an interval
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<UncertainConstantRecord>,
    /// The `[[event]]`s that happened
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Fired>,
    /// The controllers that set signals, each with the time from which it does so
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub controllers: Vec<ControllerRecord>,
    /// Regions of constraints and effects, defined by position, whose border runs through cells
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cut_regions: Vec<String>,
    /// Column → regions of its probe, defined by position, whose border runs through cells
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub cut_columns: BTreeMap<String, Vec<String>>,
    /// Whether a held face ends at a re-entrant edge, where quantities converge with an order of about 1 or less
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub glued_edge: bool,
    /// Why the answer has no limit as h → 0; a convergence study then refuses its verdict
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_limit: Option<String>,
    /// Adaptive meshes; the last one is that of the run
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinement: Vec<RefinementRecord>,
    pub provenance: Provenance,
}

impl CaseRecord {
    /// Regions on which a column depends, defined by position, whose border runs through cells.
    pub fn cut_regions_of(&self, column: &str) -> Vec<String> {
        distinct(self.cut_regions.iter().chain(self.cut_columns.get(column).into_iter().flatten()).cloned())
    }

    /// Whether the computation itself crashed: by a panic, a process that died, insufficient memory, or a file that was edited in the meantime.
    pub fn broke(&self) -> bool {
        [PANICKED, CRASHED, OUT_OF_MEMORY, INPUTS_CHANGED].contains(&self.status.as_str())
    }

    /// Whether the result has everything requested of the case. A record of an earlier version does not say what was requested; its contents are
    /// checked.
    pub fn has(&self, asked: &Asked) -> bool {
        self.provenance.asked.as_ref().map_or_else(
            || {
                let estimated = self.one_run.is_some() || asked.estimates.is_empty();
                !self.converged() || estimated && self.repeats.len().max(1) >= asked.repeats
            },
            |was| was.has(asked),
        )
    }

    /// Removes everything that the study does not request.
    pub fn restrict(&mut self, asks: Asks, is_reference: bool) {
        if !asks.error_estimates || is_reference {
            self.one_run = None;
        }
        if !asks.input_uncertainty {
            self.inputs.clear();
        }
    }

    /// Whether the search of a calibration found constants, even if its status says why they are not an answer.
    pub fn has_constants(&self) -> bool {
        self.converged() || [NOT_SETTLED, OUT_OF_TIME, NOT_DETERMINED].contains(&self.status.as_str())
    }

    /// Whether the run reached its end. The numbers of a case that did not are not used in any analysis.
    pub fn converged(&self) -> bool {
        self.status == Status::Converged.name()
    }

    /// The case, its status, and the reason if known: `tet4-9300: Diverged: …`.
    pub fn end(&self) -> String {
        format!("{}: {}: {}", self.id, self.status, self.status_detail.as_deref().unwrap_or("see the report"))
    }

    /// Number of Newton iterations included in the CPU time, also those of steps that were rejected and cut.
    pub fn all_iterations(&self) -> usize {
        self.newton_iterations + self.solver.lost_iterations
    }

    /// Whether both ran on the same mesh: by its digest, or by its sizes if an earlier version recorded no digest.
    pub fn has_mesh_of(&self, other: &Self) -> bool {
        let key = |r: &Self| {
            let m = &r.mesh;
            (m.cells, m.nodes, m.h_m.to_bits(), m.min_quality.to_bits(), m.mean_quality.to_bits())
        };
        let [own, found] = [self, other].map(|r| &r.provenance.identity.mesh_sha256);
        let may_be = own.is_empty() || found.is_empty() || own == found;
        may_be && self.mesh.source == other.mesh.source && key(self) == key(other)
    }

    /// Whether both ran on the same cells, with or without mid-edge nodes, which do not change edges and quality.
    pub fn has_cells_of(&self, other: &Self) -> bool {
        let key = |r: &Self| {
            let m = &r.mesh;
            (m.cells, m.edge_m.unwrap_or(m.h_m).to_bits(), m.min_quality.to_bits(), m.mean_quality.to_bits())
        };
        key(self) == key(other) && (self.mesh.nodes != other.mesh.nodes || self.has_mesh_of(other))
    }

    /// Time steps of the stages \[s\]; for a record of an earlier version, only the longest one.
    pub fn steps_s(&self) -> &[f64] {
        if self.stage_dt_s.is_empty() { std::slice::from_ref(&self.dt_s) } else { &self.stage_dt_s }
    }

    /// Share of the range of a length or an angle that one time step covers, if masses move and the steps do not resolve the motion \[–\]. Changes up
    /// to `allowed`, in the unit of the column, do not count; nor do forces, which may jump, and gaps, which end at contact.
    pub fn unresolved(&self, column: &str, allowed: f64) -> Option<f64> {
        let motion = self.probes.get(column)?.motion.filter(|m| is_place(column) && m.largest_step > allowed)?;
        Some(motion.largest_step / motion.range).filter(|share| *share > RESOLVED)
    }

    /// Excess of a prescribed signal over its values at the points of the time grid, relative to its range, if the motion of this column would not
    /// reveal it \[–\].
    pub fn unseen(&self, column: &str) -> f64 {
        let of_all = self.unseen_force_share.filter(|_| !is_place(column));
        of_all.or(self.unseen_share).unwrap_or(0.0)
    }

    /// Formal order of convergence in the time step; 2 in statics.
    pub fn order_in_time(&self) -> f64 {
        self.order_in_time.or_else(|| integrator_order(&self.integrator)).map_or(2.0, f64::from)
    }

    /// Whether another time step would give another result; if the record does not say so, this holds for all runs in time.
    pub fn depends_on_steps(&self) -> bool {
        self.steps_matter.unwrap_or_else(|| self.integrator != Integrator::Static.name())
    }
}

/// Whether a column is a position or an angle, whose motion is checked. Gaps are excluded, since they end at contact.
fn is_place(column: &str) -> bool {
    matches!(column::dimension(column).0, Dimension::LENGTH | Dimension::ANGLE) && !column.ends_with(GAP)
}

/// A mesh: its counts, sizes and quality.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
pub struct MeshRecord {
    /// Number of cells
    pub cells: usize,
    /// Number of nodes
    pub nodes: usize,
    /// Size h = (V/N)^{1/3} \[m\]
    pub h_m: f64,
    /// Mean edge length \[m\], the second definition of h; `None` in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_m: Option<f64>,
    /// Mean extents of the cells along x, y and z, and their mean longest edge \[m\], without axes along which the whole body is held; `None` in
    /// records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extents_m: Option<[f64; 4]>,
    /// Cells across the thinnest wall; `None` if there is no wall, and in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_cells: Option<f64>,
    /// Thickness of that wall \[m\]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_m: Option<f64>,
    /// Smallest radius ratio 3 r_in/r_circ of a cell \[–\]
    pub min_quality: f64,
    /// Mean radius ratio of the cells \[–\]
    pub mean_quality: f64,
    /// Volume \[m³\]
    pub volume_m3: f64,
    /// File name, or hash of the request from which it was made
    pub source: String,
}

/// The law of a case, with the values of its constants.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct LawRecord {
    /// Name in scene files: `neo_hookean`
    pub name: String,
    /// Parameter name → value \[SI\]
    pub parameters: BTreeMap<String, f64>,
    /// Further choices: volumetric part, convention
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub choices: BTreeMap<String, String>,
}

impl LawRecord {
    /// The record of a law at its present constants.
    pub fn new(law: &dyn Law) -> Self {
        let info = law.info();
        let names = info.parameters.iter().map(|p| p.name.to_string());
        let choices = info.choices.iter().zip(law.choices());
        let choices = choices.map(|(c, chosen)| (c.name.to_string(), chosen.to_string()));
        Self { name: info.name.into(), parameters: names.zip(law.values()).collect(), choices: choices.collect() }
    }
}

/// An assembled effect or constraint, and the time that it took.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct EffectRecord {
    pub name: String,
    /// Role of an effect in the energy balance; `None` for a constraint
    pub role: Option<String>,
    /// Time of its evaluations \[s\]
    pub wall_s: f64,
}

/// A change of a cable to `slack`, `taut` or `yielding`, recorded at the first accepted state after it.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct CableEventRecord {
    pub t_s: f64,
    pub cable: String,
    pub became: String,
}

impl From<&CableEvent> for CableEventRecord {
    fn from(event: &CableEvent) -> Self {
        Self { t_s: event.t, cable: event.cable.clone(), became: event.what.name().into() }
    }
}

/// Wall time of a case by phases of the computation \[s\].
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct PhaseRecord {
    pub assembly_s: f64,
    pub factorisation_s: f64,
    pub solve_s: f64,
    /// Time for the forces on contact points in contact corrections
    #[serde(default)]
    pub contact_forces_s: f64,
    pub output_s: f64,
    /// Time before the first step, not included in `wall_s`: blocks, ordering, pattern
    #[serde(default)]
    pub build_s: f64,
}

/// Signs of locking of the elastic effect whose pressures scatter most, with preference for one with an alarm; definitions in
/// `docs/explanation/elements.md`.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
pub struct LockingRecord {
    /// Scatter of the pressures, ‖p − p*‖/‖dev τ‖ \[–\]
    pub pressure_scatter: f64,
    /// Volumetric part of the energy, relative to the whole \[–\]
    pub volumetric_share: f64,
    /// Whether the formulation is in displacements only, the law nearly incompressible, and the scatter above its threshold
    pub alarm: bool,
}

/// A recorded column; its unit is in its name (`bending_angle_deg`).
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct ProbeRecord {
    /// The value farthest from the first one; in a report on several cases, the farthest on the side that they have in common
    pub peak: f64,
    /// Whether it is a minimum or a maximum
    pub peak_is: ExtremeKind,
    /// Time of the peak \[s\]
    pub peak_t_s: f64,
    /// The value at the end of the run
    #[serde(rename = "final")]
    pub last: f64,
    /// The farthest value on the other side of the first one; `None` if no value lies there, and in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opposite: Option<OppositeRecord>,
    /// Changes in the stages in which masses move; `None` without such a stage, and for lengths and angles that symmetry or an equilibrium keeps
    /// constant
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionRecord>,
}

/// The farthest value of a column on the side of the first value opposite to the peak.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
pub struct OppositeRecord {
    /// The value, in the unit of the column
    pub value: f64,
    /// Its time \[s\]
    pub t_s: f64,
}

/// Changes of a recorded column while masses move.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
pub struct MotionRecord {
    /// Largest change within one time step
    pub largest_step: f64,
    /// Difference between the largest and the smallest value
    pub range: f64,
}

/// Largest share of the range of a motion that one time step may cover if the steps resolve it; for an oscillation with N steps per period it is π/N
/// \[–\]
const RESOLVED: f64 = 1.0 / 3.0;
/// End of the column names of the smallest distances of contacts
const GAP: &str = "_gap_m";

/// Origin of a result: its scene, inputs and build, and the files that were stored with it.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct Provenance {
    /// [`SCHEMA`] of the program that wrote the record; 0 in records that precede it
    #[serde(default)]
    pub schema: u32,
    /// The resolved scene, as TOML
    pub scene: String,
    #[serde(default)]
    pub identity: Identity,
    #[serde(default)]
    pub build: Build,
    /// Everything that the study requested of the case; `None` in records of earlier versions, and for a case without a run
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<Asked>,
    /// Start of the run \[s since 1970-01-01 UTC\]
    #[serde(default)]
    pub started_unix_s: u64,
    /// Files of the results that were stored with the record
    #[serde(default)]
    pub results: Vec<FileDigest>,
    /// Digest of the record itself, see [`crate::study::store::seal`]
    #[serde(default)]
    pub record_sha256: String,
}

impl Provenance {
    /// Whether a result has these inputs and comes from this build of the program; `accept_build` allows any build.
    pub fn counts_for(&self, identity: &Identity, accept_build: bool) -> bool {
        self.identity == *identity && (accept_build || self.build == Build::this())
    }
}
