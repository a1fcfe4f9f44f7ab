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

mod additions;
mod before_meshing;
mod bodies;
mod body;
mod build;
mod builder;
mod checkpoint;
mod collapse;
pub mod column;
mod compare;
pub mod control;
mod cover;
mod cut_edges;
mod cut_regions;
mod deform;
mod describe;
mod energy_balance;
mod energy_growth;
mod error;
pub mod error_estimate;
mod extreme;
mod extreme_rows;
mod features;
mod feedback;
mod fields;
mod fixture;
mod grid;
mod held;
mod held_rim;
mod identity;
mod import;
mod instant;
mod jump;
mod kind;
mod law_terms;
mod linear;
mod measured_curve;
mod mesh_file;
mod mesh_limits;
mod mesh_spec;
pub(crate) mod name;
mod numerics;
mod open;
pub mod output;
pub mod overrides;
mod parameter_key;
pub mod parts;
mod patches;
pub mod protocol;
mod quantity;
mod read;
mod reader;
mod recorded;
mod recorder;
mod refine;
mod regions;
mod rules;
mod run;
mod run_options;
mod run_recorder;
mod scalar_sensitivity;
mod scene_difference;
mod sensitivities;
pub mod sensitivity;
mod sensitivity_error;
mod shape;
mod signal;
mod signal_table;
mod skin;
mod source_volume;
pub mod spec;
mod stable;
mod stages;
mod start;
mod starter;
mod stored;
mod stress_recovery;
pub mod stretch;
mod surface_unit;
mod turning;
mod winding;
mod wrinkles;

pub use before_meshing::mistakes_before_meshing;
pub use body::{Body, request};
pub use build::{Scene, SceneBuilder};
pub use builder::LawSource;
pub use checkpoint::{Checkpoint, CheckpointError, Snapshot};
pub use collapse::CollapsedCavity;
pub(crate) use column::in_unit_of;
pub use column::unit as unit_of_column;
pub use compare::{Measured, MeasuredData, MeasuredTracks};
pub(crate) use cut_regions::cut_regions;
pub use energy_growth::EnergyFromNothing;
pub use error::{Line, Mistake, SceneError, hint};
pub use error_estimate::{
    CellErrors, Enrichment, ErrorBounds, ErrorEstimate, ErrorEstimator, EstimateError, GeometryError, QuantityError,
    path_dependence,
};
pub use extreme::{Extreme, ExtremeKind, extreme};
pub use features::{Features, Reading};
pub use feedback::growing_feedback;
pub use fixture::Fixture;
pub use grid::{
    cells as cells_of_grid, common_divisor, divisions as divisions_of_grid, divisions_value, grid as mesh_of_grid,
    scaled as scaled_grid, similar as similar_grids, with_divisions as grid_with_divisions,
};
pub use identity::{FileDigest, named_files};
pub(crate) use import::nearest_cells;
pub use import::{Import, Imported};
pub use linear::{LinearSpec, LinearWork, MemorySpec};
pub(crate) use mesh_limits::wall;
pub use mesh_limits::{limits_of_mesh, limits_of_scene};
pub use mesh_spec::{ElementSpec, GeneratorSpec, MeshSpec};
pub use open::{open_scene, parse_scene};
pub use overrides::find;
pub use parameter_key::{KeyError, KeyValue, LawConstant, ParameterKey};
pub use patches::Patches;
pub use quantity::{Length, Time};
pub(crate) use read::from_text;
pub use read::{changed_scene, is_study, read_scene, read_table, value_in};
pub use recorder::{Energies, Headline, Moment, Recorder};
pub use refine::{RefineError, Refinement, RefinementStep, RefinementWatch, refine};
pub use run::Run;
pub use run_options::{OnProgress, OnRow, OnSave, OnSized, OnState, PARTIAL, Progress, RunOptions, Saved};
pub use scalar_sensitivity::{ScalarSensitivity, check_scalar, scalar_sensitivity};
pub use sensitivities::{Sensitivities, SensitivityRecorder};
pub use sensitivity_error::SensitivityError;
pub use skin::NamedSkin;
pub use source_volume::SourceVolume;
pub use spec::SceneSpec;
pub use start::StartSpec;
pub use starter::starter;
pub use stored::{is_stored, keep};
pub use turning::half_turns;
pub use winding::Winding;
pub use wrinkles::{no_limit_at, wrinkle_notes};
