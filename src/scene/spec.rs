//! A scene as it is given in a TOML file. Unknown keys are refused; there is no default physics.

pub use super::compare::{CompareSpec, MeasuredSpec};
pub use super::control::spec::{EventSpec, ThenSpec, WhenSpec};
use super::kind::by_kind;
pub use super::mesh_spec::{
    CopySpec, DisturbSpec, ElementSpec, GeneratorSpec, GradingSpec, GridSpec, MeshSpec, PickSpec, SelectorSpec,
};
pub use super::numerics::NumericsSpec;
pub use super::output::{FieldSpec, FieldsSpec, OutputSpec, ScheduleSpec};
pub use super::parts::cable::{CableSpec, RingSpec};
pub use super::parts::contact::spec::{ContactSpec, MotionSpec, ResponseSpec, TurningSpec};
pub use super::parts::probes::{BendingAngle, Energy, Markers, Position, ProbeSpec, Reaction, Stretch};
pub use super::parts::rigid::{RigidSpec, WeightSpec};
pub use super::quantity::{
    Angle, Damping, Density, Force, GuideRadius, Length, Modulus, PerSecond, Quantity, Speed, Spin, SpringStiffness,
    Time, Viscosity,
};
pub use super::shape::{ShapeSpec, TurnSpec};
pub use super::signal::{FunctionSpec, SignalSpec};
pub use super::skin::SkinSpec;
pub use super::start::StartSpec;
use serde::Deserialize;
use std::collections::BTreeMap;

by_kind!(EffectSpec, ConstraintSpec, DriveSpec, CavityDriveSpec, IntegratorSpec);

/// Body, mesh, laws, effects, constraints, protocol, probes and numerics of one simulation.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSpec {
    /// Subject of the scene, for the report
    #[serde(default)]
    pub title: String,
    pub mesh: MeshSpec,
    /// Laws by name: `law` and its constants, or `include` of a law file with keys added or replaced
    #[serde(default)]
    pub laws: BTreeMap<String, toml::Table>,
    #[serde(rename = "effect", default)]
    pub effects: Vec<EffectSpec>,
    #[serde(rename = "constraint", default)]
    pub constraints: Vec<ConstraintSpec>,
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactSpec>,
    #[serde(rename = "rigid", default)]
    pub rigids: Vec<RigidSpec>,
    /// Where the run starts, if not at rest
    pub start: Option<StartSpec>,
    #[serde(rename = "stage")]
    pub stages: Vec<StageSpec>,
    #[serde(rename = "probe", default)]
    pub probes: Vec<ProbeSpec>,
    #[serde(rename = "skin", default)]
    pub skins: Vec<SkinSpec>,
    #[serde(rename = "event", default)]
    pub events: Vec<EventSpec>,
    #[serde(rename = "compare", default)]
    pub comparisons: Vec<CompareSpec>,
    #[serde(default)]
    pub output: OutputSpec,
    #[serde(default)]
    pub numerics: NumericsSpec,
}

/// One effect; the kinds are the registry.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum EffectSpec {
    Elastic {
        region: String,
        law: String,
        #[serde(default)]
        formulation: FormulationSpec,
    },
    Inertia {
        region: String,
        density: Density,
        mass: LumpingSpec,
    },
    Gravity {
        region: String,
        density: Density,
        direction: [f64; 3],
        acceleration: SignalSpec,
    },
    MassDamping {
        region: String,
        density: Density,
        mass: LumpingSpec,
        alpha: PerSecond,
    },
    ViscousDamping {
        region: String,
        eta: Viscosity,
    },
    Viscoelastic {
        region: String,
        /// The law of the elastic effect there
        law: String,
        moduli: ModuliSpec,
        prony: Vec<ArmSpec>,
    },
    /// Damping of the elastic effects and springs of the region of this name
    StiffnessDamping {
        region: String,
        beta: Time,
        stiffness: StiffnessSpec,
    },
    /// Exactly one of `stiffness` and `E`
    EdgeSprings {
        region: String,
        /// The same on every edge
        stiffness: Option<SpringStiffness>,
        /// Young's modulus that the springs are to imitate
        #[serde(rename = "E")]
        modulus: Option<Modulus>,
    },
    EdgeDampers {
        region: String,
        damping: Damping,
    },
    /// A force of fixed direction on an embedded point
    PointForce {
        #[serde(default = "point_force")]
        name: String,
        point: [Length; 3],
        /// Of the patch that takes the force
        radius: GuideRadius,
        direction: [f64; 3],
        force: SignalSpec,
    },
    /// A load of fixed direction per reference area; exactly one of `region` and `skin`
    Traction {
        #[serde(default = "traction")]
        name: String,
        region: Option<String>,
        skin: Option<String>,
        direction: [f64; 3],
        traction: SignalSpec,
    },
}

fn point_force() -> String {
    "point_force".into()
}

fn traction() -> String {
    "traction".into()
}

/// Which modulus the constants of a law give.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ModuliSpec {
    LongTerm,
    Instantaneous,
}

/// One term of a Prony series.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmSpec {
    /// Share of the instantaneous modulus
    pub g: f64,
    /// Relaxation time
    pub tau: Time,
}

/// Tangent that a stiffness-proportional damping takes.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessSpec {
    /// At rest
    Initial,
    /// At the start of the step
    Last,
}

/// Formulation of a law in the elements.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Default)]
#[serde(rename_all = "snake_case")]
pub enum FormulationSpec {
    /// Displacements only; locks as ν → ½, on tet4 first
    #[default]
    Displacement,
    /// Displacement and continuous pressure: stabilised on tet4, Taylor–Hood on tet10
    Mixed,
    /// tet10 with one pressure a cell, condensed
    MeanDilatation,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum LumpingSpec {
    Consistent,
    Lumped,
    Uniform,
}

/// One constraint or cable; the kinds are the registry.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum ConstraintSpec {
    Fixed {
        region: String,
        /// Components held, all if absent: "x", "yz", …
        #[serde(default = "all_components")]
        components: String,
    },
    Prescribed {
        region: String,
        components: String,
        displacement: SignalSpec,
    },
    Cable(CableSpec),
    /// Air or liquid behind the facets of a region
    Cavity {
        #[serde(default = "cavity")]
        name: String,
        region: String,
        drive: CavityDriveSpec,
        /// The surface is open and its rim free
        #[serde(default)]
        open: bool,
    },
}

fn all_components() -> String {
    "xyz".into()
}

fn cavity() -> String {
    "cavity".into()
}

#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum DriveSpec {
    /// Shortening of the cable at the pull point
    Length {
        signal: SignalSpec,
    },
    Tension {
        signal: SignalSpec,
    },
}

#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum CavityDriveSpec {
    Pressure {
        signal: SignalSpec,
    },
    /// Growth of the volume
    Volume {
        signal: SignalSpec,
    },
}

/// A stretch of time with one integrator.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageSpec {
    pub integrator: IntegratorSpec,
    pub duration: Time,
    pub dt: Time,
    pub continuation: Option<ContinuationSpec>,
    /// Of a continuation
    pub max_steps: Option<usize>,
    /// In each `dt` of the loop that looks for contact once a step
    pub integration_steps: Option<usize>,
}

impl StageSpec {
    /// A stage with steps of `dt`.
    pub fn new(integrator: IntegratorSpec, duration: Time, dt: Time) -> Self {
        Self { integrator, duration, dt, continuation: None, max_steps: None, integration_steps: None }
    }
}

/// How a static stage goes on where the loads are no longer enough to tell the states apart.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum ContinuationSpec {
    ArcLength,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum IntegratorSpec {
    Static,
    ImplicitEuler,
    ImplicitEulerLinearised,
    ImplicitEulerCorrected,
    Bdf2,
    GeneralisedAlpha {
        rho: f64,
    },
    /// `force = true` allows the undamped rule together with constraints
    Newmark {
        beta: f64,
        gamma: f64,
        #[serde(default)]
        force: bool,
    },
}
