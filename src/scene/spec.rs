//! A scene as given in a TOML file. Unknown keys are refused; there is no default physics.

pub use super::body::mesh_spec::{
    CornersSpec, DeformSpec, DisturbSpec, ElementSpec, GeneratorSpec, GradingSpec, GridSpec, MeshSpec, PartSpec,
};
pub use super::build::shape::{ShapeSpec, TurnSpec};
pub use super::control::spec::{EventSpec, ThenSpec, WhenSpec};
pub use super::numerics::NumericsSpec;
pub use super::parts::constraints::{
    CableDriveSpec, CableSpec, CavityDriveSpec, CavitySpec, ConstraintSpec, FixedSpec, PrescribedSpec, RigidInsertSpec,
    RingSpec,
};
pub use super::parts::contact::spec::{ContactSpec, MotionSpec, ResponseSpec};
pub use super::parts::effects::{
    ArmSpec, DirectionSpec, EdgeDampersSpec, EdgeSpringsSpec, EffectSpec, ElasticSpec, FibreAlong, FibreFamilySpec,
    FibreSpec, FormulationSpec, GravitySpec, Hand, HelixSpec, InertiaSpec, LumpingSpec, MassDampingSpec, MembraneSpec,
    ModuliSpec, MullinsSpec, PointForceSpec, SeriesSpec, SofteningSpec, StiffnessDampingSpec, StiffnessSpec,
    TractionSpec, ViscoelasticSpec, ViscousDampingSpec,
};
pub use super::parts::probes::{
    BendingAngle, CentreLine, Energy, Markers, Pose, Position, ProbeSpec, Reaction, ReactionMoment, Stretch,
};
pub use super::parts::rigid::{RigidSpec, WeightSpec};
pub use super::parts::selectors::{
    BoxSelector, ComplementSelector, ComponentSelector, DifferenceSelector, IntersectionSelector, NearSelector,
    NormalSelector, PickSpec, PlaneSelector, RuleSpec, SelectorSpec, SphereSelector, UnionSelector, Which,
};
pub use super::parts::skin::SkinSpec;
pub use super::record::compare::{CompareSpec, Comparisons, MarkersSpec};
pub use super::record::measured_curve::MeasuredColumnSpec;
pub use super::record::output::{FieldSpec, FieldsSpec, OutputSpec, ScheduleSpec};
pub use super::rotation::RotationSpec;
pub use super::run::start::StartSpec;
pub use super::signal::{FunctionSpec, SignalSpec};
pub use super::stages::{ContinuationSpec, IntegratorSpec, StageSpec};
pub use super::text::quantity::{
    Angle, Damping, Density, Force, GuideRadius, Length, Modulus, PerSecond, Quantity, Speed, Spin, SpringStiffness,
    Time, Viscosity,
};
use crate::material::{KnownLaws, LawTable};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Body, mesh, laws, effects, constraints, protocol, probes and numerics of one simulation.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneSpec {
    /// Subject of the scene, for the report
    #[serde(default)]
    pub title: String,
    /// Mesh of the body or bodies, and regions
    pub mesh: MeshSpec,
    /// Laws by name: `law` with its constants, or `include` of a law file with keys added or replaced
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, LawTable>")]
    pub laws: BTreeMap<String, toml::Table>,
    /// Effects, which contribute forces and stiffness
    #[serde(rename = "effect", default)]
    pub effects: Vec<EffectSpec>,
    /// Constraints of the motion
    #[serde(rename = "constraint", default)]
    pub constraints: Vec<ConstraintSpec>,
    /// Contacts of the surface with obstacles, bodies and itself
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactSpec>,
    /// Rigid bodies that move freely
    #[serde(rename = "rigid", default)]
    pub rigids: Vec<RigidSpec>,
    /// Initial state of the run, if not at rest
    pub start: Option<StartSpec>,
    /// Stages of the protocol, consecutive in time
    #[serde(rename = "stage")]
    pub stages: Vec<StageSpec>,
    /// Quantities that are recorded
    #[serde(rename = "probe", default)]
    pub probes: Vec<ProbeSpec>,
    /// Surfaces that follow the body
    #[serde(rename = "skin", default)]
    pub skins: Vec<SkinSpec>,
    /// Events: conditions with the resulting actions
    #[serde(rename = "event", default)]
    pub events: Vec<EventSpec>,
    /// Measured curves and tracks of markers to be compared with recorded ones
    #[serde(rename = "compare", default)]
    pub comparisons: Comparisons,
    /// Fields and rows that are written, and their times
    #[serde(default)]
    pub output: OutputSpec,
    /// Tolerances and methods of the solution
    #[serde(default)]
    pub numerics: NumericsSpec,
    /// Laws that the tables of `laws` may name: those registered when the scene was read or written
    #[serde(skip)]
    pub known_laws: KnownLaws,
}
