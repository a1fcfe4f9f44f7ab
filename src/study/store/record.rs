//! Record of a finished case on disk, which every report reads: `cases/<id>.json` next to `cases/<id>.csv`.

use crate::material::Law;
use crate::report::names::title;
use crate::scene::control::Fired;
use crate::scene::parts::constraints::CableEvent;
use crate::scene::{ExtremeKind, FileDigest, Measured};
use crate::solve::{Integrator, Status};
use crate::study::estimate::tolerance::Tolerance;
use crate::study::overlay::distance::{Distance, MarkerDistance};
use crate::study::run::inputs::InputRecord;
use crate::study::run::one_run::OneRunRecord;
use crate::study::run::refinement::RefinementRecord;
use crate::study::run::work::{RepeatRecord, WorkRecord};
use crate::study::store::contact::ContactRecord;
use crate::study::store::identity::{Build, Identity};
use crate::study::store::solver::SolverRecord;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A finished case (also one that stopped early: `status` says so).
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct CaseRecord {
    /// `<family>-<variant>-<member>`, also the file stem
    pub id: String,
    /// Family of meshes or steps it belongs to: `sizes`, `nested`, …
    pub family: String,
    /// Variant of the scene: `length` or `tension`
    pub variant: String,
    /// Value that distinguishes it from the rest of its family: a size, a law
    #[serde(default)]
    pub member: String,
    pub mesh: MeshRecord,
    /// `tet4`, `tet10`, `mass_spring`
    pub formulation: String,
    /// Name of the law, with its constants in SI; absent where springs are all that is elastic
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<LawRecord>,
    pub integrator: String,
    /// Largest time step \[s\]
    pub dt_s: f64,
    /// The states depend on the time steps: by dynamics, or by the path of loading; none in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps_matter: Option<bool>,
    /// `Converged`, `StepTooSmall`, …
    pub status: String,
    /// What, where and the remedy, if the status is not `Converged`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status_detail: Option<String>,
    /// Work of the solver, and where it stopped
    #[serde(default)]
    pub solver: SolverRecord,
    /// Wall time of the solution, mesh and report apart \[s\]
    pub wall_s: f64,
    /// CPU time of the thread that solved it \[s\]
    pub cpu_s: f64,
    /// Another case ran at the same time: `wall_s` is then no measure of its cost
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
    /// Counted work; zeros in records without it
    #[serde(default)]
    pub work: WorkRecord,
    /// Times of every run, where the case was run several times; `wall_s` and `cpu_s` are those of the median one
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repeats: Vec<RepeatRecord>,
    /// Signs of volumetric locking at the state farthest from rest; none for a body that nothing moved
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub locking: Option<LockingRecord>,
    /// Per recorded column of the CSV
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
    /// Errors estimated from this run alone, where the study asks for them
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_run: Option<OneRunRecord>,
    /// Derivatives by the constants that a law file gives intervals of
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<InputRecord>,
    /// The `[[event]]`s that happened
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Fired>,
    /// Why the answer has no limit as h → 0; a convergence study then refuses its verdict
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_limit: Option<String>,
    /// Adaptive meshes, the last of which is that of the run
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refinement: Vec<RefinementRecord>,
    pub provenance: Provenance,
}

/// Form of the stored files. It grows when a program of today could not read them any more; such files are refused.
pub const SCHEMA: u32 = 1;

/// The search for the constants of a case found no further step before it had settled.
pub const NOT_SETTLED: &str = "SearchNotSettled";
/// The search for the constants of a case had no time left; the next run goes on from its answer.
pub const OUT_OF_TIME: &str = "SearchOutOfTime";
/// The curves of a case do not determine every constant.
pub const NOT_DETERMINED: &str = "ConstantsNotDetermined";
/// Status of a scene that was refused before the run.
pub const REFUSED: &str = "Refused";
/// Status of a run that ended in a panic: a bug of this program.
pub const PANICKED: &str = "Panicked";
/// Status of a case whose process died: of memory, of a signal, or of a bug.
pub const CRASHED: &str = "Crashed";

/// Status of a case that needs more memory than all cases together may take.
pub const OUT_OF_MEMORY: &str = "OutOfMemory";

impl CaseRecord {
    /// The computation itself broke, whatever the scene is.
    pub fn broke(&self) -> bool {
        [PANICKED, CRASHED, OUT_OF_MEMORY].contains(&self.status.as_str())
    }

    /// There are constants, whatever is said against them.
    pub fn has_constants(&self) -> bool {
        self.converged() || [NOT_SETTLED, OUT_OF_TIME, NOT_DETERMINED].contains(&self.status.as_str())
    }

    /// Only then its results count.
    pub fn converged(&self) -> bool {
        self.status == Status::Converged.name()
    }

    /// Iterations of Newton's method that the CPU time pays for: those of steps that were refused and cut, too.
    pub fn all_iterations(&self) -> usize {
        self.newton_iterations + self.solver.lost_iterations
    }

    /// Whether another time step has another result; where no record says so, runs in time have.
    pub fn depends_on_steps(&self) -> bool {
        self.steps_matter.unwrap_or_else(|| self.integrator != Integrator::Static.name())
    }
}

/// A mesh: its counts, sizes and quality
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
pub struct MeshRecord {
    /// Number of cells
    pub cells: usize,
    /// Number of nodes
    pub nodes: usize,
    /// (V/N)^{1/3} \[m\]
    pub h_m: f64,
    /// Mean length of the edges \[m\], the second definition of h; none in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_m: Option<f64>,
    /// Cells across the thinnest wall; none where there is no wall, and in records of earlier versions
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
    /// File name or hash of the request that produced it
    pub source: String,
}

impl MeshRecord {
    /// Whether both are of the same mesh. The source alone does not tell: it is "grid" for every grid.
    pub fn is_same(&self, other: &Self) -> bool {
        let key = |m: &Self| (m.cells, m.nodes, m.h_m.to_bits(), m.min_quality.to_bits(), m.mean_quality.to_bits());
        self.source == other.source && key(self) == key(other)
    }
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct LawRecord {
    pub name: String,
    /// Parameter name → value \[SI\]
    pub parameters: BTreeMap<String, f64>,
    /// Further choices: volumetric part, convention
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub choices: BTreeMap<String, String>,
}

impl LawRecord {
    pub fn new(law: &dyn Law) -> Self {
        let info = law.info();
        let names = info.parameters.iter().map(|p| p.name.to_string());
        let choices = info.choices.iter().zip(law.choices());
        let choices = choices.map(|(c, chosen)| (c.name.to_string(), chosen.to_string()));
        Self { name: info.name.into(), parameters: names.zip(law.values()).collect(), choices: choices.collect() }
    }
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct EffectRecord {
    pub name: String,
    /// Role of an effect in the energy balance; none of a constraint
    pub role: Option<String>,
    /// Time of its evaluations \[s\]
    pub wall_s: f64,
}

/// A cable that became `slack`, `taut` or `yielding`, at the first accepted state after it.
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

/// Where the time went \[s\].
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct PhaseRecord {
    pub assembly_s: f64,
    pub factorisation_s: f64,
    pub solve_s: f64,
    pub output_s: f64,
    /// Before the first step, outside of `wall_s`: blocks, ordering, pattern
    #[serde(default)]
    pub build_s: f64,
}

/// Of the elastic effect whose pressures scatter most, one with an alarm first; definitions in `docs/explanation/elements.md`.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
pub struct LockingRecord {
    /// ‖p − p*‖/‖dev τ‖ \[–\]
    pub pressure_scatter: f64,
    /// Volumetric share of the energy \[–\]
    pub volumetric_share: f64,
    /// The formulation is in displacements alone, the law nearly incompressible, and the scatter above its threshold
    pub alarm: bool,
}

/// A recorded column; the unit is in its name (`bending_angle_deg`).
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct ProbeRecord {
    /// The value farthest from the first one
    pub peak: f64,
    /// Whether it is a minimum or a maximum
    pub peak_is: ExtremeKind,
    /// Time of the peak \[s\]
    pub peak_t_s: f64,
    /// The value at the end of the run
    #[serde(rename = "final")]
    pub last: f64,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct Provenance {
    /// [`SCHEMA`] of the program that wrote the record; 0 before they were counted
    #[serde(default)]
    pub schema: u32,
    /// The resolved scene, as TOML
    pub scene: String,
    #[serde(default)]
    pub identity: Identity,
    #[serde(default)]
    pub build: Build,
    /// Start of the run, in seconds since 1970 UTC
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
    /// Whether the result is that of these inputs, and of this build of the program or any.
    pub fn counts_for(&self, identity: &Identity, accept_build: bool) -> bool {
        self.identity == *identity && (accept_build || self.build == Build::this())
    }
}

/// Description of a study and the cases that belong to it: `study.json`, next to the folder `cases/`.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct StudyRecord {
    /// [`SCHEMA`] of the program that wrote it; 0 before they were counted
    #[serde(default)]
    pub schema: u32,
    /// Name of the study, as its folder is called
    pub study: String,
    /// `convergence`, `materials`, …
    pub kind: String,
    pub question: String,
    /// The expectation before the run
    pub expectation: String,
    /// Largest error bar that is accepted, as a fraction of the value \[–\]
    pub tolerance: f64,
    /// Variant → the quantities judged there; an imposed quantity is not listed
    pub quantities: BTreeMap<String, Vec<Quantity>>,
    /// Variants in the order of the report: `length`, `tension`
    pub variants: Vec<String>,
    /// Variant → what it is in words, where it was said
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// Variant → heading of its group, where it was said
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, String>,
    /// Member → what it is in words, where it was said
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub members: BTreeMap<String, String>,
    pub families: Vec<FamilyRecord>,
    /// Further details that its kind keeps
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub details: serde_json::Value,
    pub version: String,
}

/// The defect of a case that was not run.
pub const NOT_RUN: &str = "has no result";

impl StudyRecord {
    /// A variant in words: its label, or its name.
    pub fn label(&self, variant: &str) -> String {
        self.labels.get(variant).cloned().unwrap_or_else(|| variant.to_string())
    }

    /// A member in words: its label, the title of the law or the integrator, or its name with blanks.
    pub fn member(&self, name: &str) -> String {
        self.members.get(name).cloned().unwrap_or_else(|| title(name))
    }

    /// Cases without a usable result: (id, what is wrong).
    pub fn incomplete(&self, stored: &[StoredCase]) -> Vec<(String, String)> {
        let mut out: Vec<(String, String)> = vec![];
        let stored: HashMap<&str, &CaseRecord> = stored.iter().map(|c| (c.record.id.as_str(), &c.record)).collect();
        let mut seen = HashSet::new();
        for id in self.families.iter().flat_map(|f| &f.cases) {
            if !seen.insert(id) {
                continue;
            }
            match stored.get(id.as_str()) {
                None => out.push((id.clone(), NOT_RUN.into())),
                Some(r) if !r.converged() => {
                    let detail = r.status_detail.as_ref().map(|d| format!(": {d}")).unwrap_or_default();
                    out.push((id.clone(), format!("{}{detail}", r.status)));
                }
                Some(_) => {}
            }
        }
        out
    }
}

/// A recorded quantity of interest: a column of `cases/<id>.csv`.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Column, with its unit as the suffix: `bending_angle_deg`
    pub name: String,
    /// In words: `bending angle`
    pub label: String,
    /// Letter in formulae and on axes: `θ`
    pub symbol: String,
    /// Unit as printed: `°`
    pub unit: String,
    /// Quantity against which it is drawn in addition to time, where the loop between the two means something: `cable_length_m`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<Box<Quantity>>,
    /// Error that is accepted whatever the value is, in the unit of the column; a quantity near zero needs one
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absolute_tolerance: Option<f64>,
    /// It decides which setting a convergence study recommends; where no quantity of a variant does, all of them decide
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub deciding: bool,
    /// A convergence study is summarised by this quantity, in its variant
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub headline: bool,
}

impl Quantity {
    /// The accepted error, where `relative` is that of the study.
    pub fn tolerance(&self, relative: f64) -> Tolerance {
        Tolerance { relative, absolute: self.absolute_tolerance.unwrap_or(0.0) }
    }
}

/// Cases that differ in one thing only.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct FamilyRecord {
    pub name: String,
    pub role: Role,
    /// `tet4`, `tet10`
    pub formulation: String,
    /// Ids of the cases, of every variant, also those that have no result yet
    pub cases: Vec<String>,
}

/// Purpose of a family of cases.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The mesh sizes the study is about, meshed one by one
    Sizes,
    /// Each cell split into eight: one size ratio, no mesh noise
    Nested,
    /// Meshed one by one with one size ratio
    Remeshed,
    /// One size, several seeds of the mesher: the scatter
    Seeds,
    /// Another element at a few sizes
    Element,
    /// Adaptive meshes, for several tolerances
    Adaptive,
    /// One mesh, several time steps
    TimeStep,
    /// One mesh, several laws, formulations or effects
    Members,
    /// The same members on a finer mesh
    Finer,
    /// The points of a sweep
    Grid,
    /// Effects added one by one
    Cumulative,
    /// A dimension that is not known exactly, over its range
    Nuisance,
    /// One mesh, several settings of the solver
    Solver,
    /// A reference run, far finer than needed
    Reference,
    /// Where a law is used with the constants that were found, from coarse to fine
    Use,
    /// Scenes that break simulators
    Suite,
    /// Points of a map of where a scene holds
    Map,
    /// Points of a response surface, with derivatives
    Design,
    /// Points that show how far a response surface is off
    Check,
    /// States that a reduced model is made of
    Training,
    /// States that its error bars are made of
    HeldBack,
}

impl Role {
    /// As a report prints it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Sizes => "sizes",
            Self::Nested => "nested",
            Self::Remeshed => "remeshed",
            Self::Seeds => "seeds",
            Self::Element => "element",
            Self::Adaptive => "adaptive",
            Self::TimeStep => "time step",
            Self::Members => "members",
            Self::Finer => "finer",
            Self::Grid => "grid",
            Self::Cumulative => "cumulative",
            Self::Nuisance => "nuisance",
            Self::Solver => "solver",
            Self::Reference => "reference",
            Self::Use => "use",
            Self::Suite => "suite",
            Self::Map => "map",
            Self::Design => "design",
            Self::Check => "check",
            Self::Training => "training",
            Self::HeldBack => "held back",
        }
    }
}

/// A case as it was read back: its record and its time series.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredCase {
    pub record: CaseRecord,
    pub series: Series,
}

/// `cases/<id>.csv`: the columns over `t_s`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Series {
    /// \[samples\] time \[s\]
    pub t_s: Vec<f64>,
    /// Column name → \[samples\], unit in the name
    pub columns: BTreeMap<String, Vec<f64>>,
}
