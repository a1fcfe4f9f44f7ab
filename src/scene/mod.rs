//! Scenes: the parts of a simulation, read from a TOML file or written in Rust with the same types, become a system that
//! runs and is recorded.
//!
//! ```
//! use durometer::scene::spec::*;
//! use durometer::scene::Scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mm = |x: f64| Length::metres(1e-3 * x);
//! let law = "law = 'neo_hookean'\nE = '1 MPa'\nnu = 0.3".parse()?;
//! let spec = SceneSpec {
//!     mesh: MeshSpec {
//!         grid: Some(GridSpec::Box { size: [mm(30.0), mm(10.0), mm(10.0)], divisions: [3, 1, 1] }),
//!         ..MeshSpec::default()
//!     },
//!     laws: [("rubber".to_string(), law)].into(),
//!     effects: vec![
//!         ElasticSpec {
//!             region: "body".into(),
//!             law: "rubber".into(),
//!             formulation: FormulationSpec::Displacement,
//!             overlap: None,
//!         }
//!         .into(),
//!     ],
//!     constraints: vec![
//!         FixedSpec { region: "xmin".into(), components: "xyz".into() }.into(),
//!         PrescribedSpec {
//!             region: "xmax".into(),
//!             components: "x".into(),
//!             displacement: Some(SignalSpec::ramp(0.0, 3e-3, 0.0, 1.0)),
//!             ..PrescribedSpec::default()
//!         }
//!         .into(),
//!     ],
//!     stages: vec![StageSpec::new(IntegratorSpec::Static, Time::seconds(1.0), Time::seconds(0.5))],
//!     probes: vec![Reaction { region: "xmax".into() }.into()],
//!     ..SceneSpec::default()
//! };
//! let scene = Scene::new(spec)?;
//! let run = scene.run();
//! let force = run.column("xmax_reaction_x_N").expect("the probe records it");
//! assert!(force.last().is_some_and(|last| *last > 0.0));
//! # Ok(())
//! # }
//! ```
//!
//! [`SceneBuilder`] adds what a file cannot hold: laws, effects, recorders, a mesh.
//!
//! | Step | Folder |
//! |---|---|
//! | The file: its text as typed values, changes by path, and the types of its tables | `text`, `read`, [`spec`], [`parts`] |
//! | The body: its mesh, from a file, a mesher or a grid | `body`, `import` |
//! | Signals over time, and how they are decided during a run | `signal`, [`control`] |
//! | From the specification and the mesh to a system | `build`, `stages`, `numerics` |
//! | A run, and the checkpoints from which it continues | `run` |
//! | The rows and fields of a run | `record` |
//! | Derivatives, and error bars of a single run | [`sensitivity`], [`error_estimate`] |
//! | Facts that limit the conclusions from its numbers | `notes` |

mod body;
mod build;
pub mod control;
mod describe;
mod error;
pub mod error_estimate;
mod import;
mod linear_solver;
mod notes;
mod numerics;
pub mod parts;
mod read;
mod record;
mod rotation;
mod run;
pub mod sensitivity;
mod signal;
pub mod spec;
mod stages;
mod text;

pub use body::Body;
pub use body::grid::{
    cells_of_grid, common_divisor, divisions_of_grid, divisions_value, grid_with_divisions, mesh_of_grid, scaled_grid,
    similar_grids,
};
pub use body::mesh_spec::{ElementSpec, GeneratorSpec, MeshSpec};
pub use body::refine::{RefineError, Refinement, RefinementStep, RefinementWatch, refine};
pub use body::request::request;
pub use body::source_volume::SourceVolume;
pub use body::stored::{MadeMesh, keep, made_meshes};
pub use build::before_meshing::mistakes_before_meshing;
pub use build::builder::LawSource;
pub use build::open::{open_scene, parse_scene};
pub use build::patches::Patches;
pub use build::skin::NamedSkin;
pub use build::{Scene, SceneBuilder};
pub use error::{Line, Mistake, SceneError, hint};
pub use error_estimate::{
    CellErrors, Enrichment, ErrorBounds, ErrorEstimate, ErrorEstimator, EstimateError, GeometryError, QuantityError,
    has_glued_edge, path_dependence,
};
pub use import::fixture::{Fixture, Slab};
pub(crate) use import::nearest_cells;
pub use import::starter::starter;
pub use import::{Import, Imported};
pub use linear_solver::{LinearSpec, LinearWork, MemorySpec};
pub use notes::beyond_data::beyond_data_notes;
pub use notes::collapse::CollapsedCavity;
pub(crate) use notes::cut_regions::CutRegions;
pub use notes::feedback::growing_feedback;
pub use notes::friction::friction_at_limit;
pub(crate) use notes::mesh_limits::wall;
pub use notes::mesh_limits::{limits_of_mesh, limits_of_scene};
pub use notes::sunk::SunkenFacet;
pub use notes::volumes::lost_volumes;
pub use notes::wrinkles::{no_limit_at, wrinkle_notes};
pub(crate) use read::from_text;
pub use read::{changed_scene, is_study, read_scene, read_table, value_in};
pub(crate) use record::column::in_unit_of;
pub use record::column::unit_of_column;
pub use record::compare::{Measured, MeasuredData, MeasuredTracks};
pub use record::extreme::{Extreme, ExtremeKind, extreme, extreme_on};
pub use record::features::{Features, Reading};
pub use record::recorder::{Energies, Headline, Moment, Recorder};
pub use record::winding::Winding;
pub use record::{column, output, stretch};
pub use rotation::half_turns;
pub use run::Run;
pub use run::checkpoint::{Checkpoint, CheckpointError, Snapshot};
pub use run::energy_growth::EnergyFromNothing;
pub use run::identity::{FileDigest, mesh_sha256, named_files, same_simulation, simulated_files};
pub use run::options::{OnProgress, OnRow, OnSave, OnSized, OnState, PARTIAL, Progress, RunOptions, Saved};
pub use run::start::StartSpec;
pub use sensitivity::columns::{Sensitivities, SensitivityRecorder};
pub use sensitivity::error::SensitivityError;
pub use sensitivity::parameter_key::{KeyError, KeyValue, LawConstant, ParameterKey};
pub use sensitivity::scalar::{ScalarSensitivity, check_scalar, scalar_sensitivity};
pub use signal::protocol;
pub use spec::SceneSpec;
pub(crate) use text::changes;
pub(crate) use text::name;
pub use text::overrides;
pub use text::overrides::find;
pub use text::quantity::{Length, Time};
