//! Durometer: mesh-convergence studies, hyperelastic calibration and paper figures for soft-robot simulation.
//!
//! The command line `durometer` covers the usual work; this library is for programs that build scenes, laws, effects or
//! controllers of their own. [`prelude`] has the types that most programs need, and the folder `examples/` a complete
//! program for each section below.
//!
//! # Simulate a scene
//!
//! A scene is a mesh, laws, effects, constraints, a protocol and probes. Here it is given as text; [`open_scene`] takes
//! the file that `durometer simulate` takes, and [`SceneBuilder`] changes values of it: `SceneBuilder::open(file)?.set("laws.silicone.E", "80 kPa")?`.
//!
//! ```
//! use durometer::prelude::*;
//!
//! let scene = parse_scene(r#"
//!     [mesh]
//!     grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
//!
//!     [laws.silicone]
//!     law = "neo_hookean"
//!     E = "100 kPa"
//!     nu = 0.45
//!
//!     [[effect]]
//!     kind = "elastic"
//!     region = "body"
//!     law = "silicone"
//!
//!     [[constraint]]
//!     kind = "fixed"
//!     region = "xmin"
//!
//!     [[effect]]
//!     kind = "gravity"
//!     region = "body"
//!     density = "1070 kg/m^3"
//!     direction = [0, 0, -1]
//!     acceleration = "9.81 m/s^2"
//!
//!     [[stage]]
//!     integrator = "static"
//!     duration = "1 s"
//!     dt = "1 s"
//!
//!     [[probe]]
//!     kind = "position"
//!     region = "xmax"
//! "#)?;
//! let run = scene.run();
//! assert_eq!(run.status, Status::Converged);
//! // One row per recorded time, one column per name.
//! assert_eq!(run.columns[0], "t_s");
//! assert_eq!(run.rows.last().map(Vec::len), Some(run.columns.len()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Scene::run_with`] takes a [`Controller`], a [`Checkpoint`] to continue from, and functions that follow the run ([`RunOptions`]).
//! [`Scene::fields`] has the displacements, stresses and other fields of a state.
//!
//! # Run a study
//!
//! A study is a folder with a `study.toml`, which states the scenes that the study derives from one scene, and the question that it decides.
//! [`run_study`] stores a result for each case, and [`write_report`] analyses the stored results without solving anything.
//!
//! ```no_run
//! use durometer::prelude::*;
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//!
//! let study = Study::read(Path::new("studies/finger-convergence/study.toml"), &[])?;
//! let stop = AtomicBool::new(false);
//! let options = StudyOptions { jobs: 2, ..StudyOptions::new(&stop) };
//! run_study(&study, Path::new("reports/finger"), &options, &())?;
//! println!("{}", write_report(Path::new("reports/finger"))?.verdict);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Fit a law
//!
//! ```
//! use durometer::prelude::*;
//!
//! # std::env::set_current_dir("..").expect("the folder of the project");
//! let mut request = FitRequest::new("data/treloar-1944/treloar-1944.csv", "neo_hookean");
//! request.options.modes = vec![Mode::Uniaxial];
//! request.options.range = Some(StretchRange { from: 1.0, to: 1.5 });
//! let result = fit(&request)?;
//! let mu = &result.parameters[0];
//! assert!(mu.interval[0] < mu.value && mu.value < mu.interval[1]);
//! # Ok::<(), FitError>(())
//! ```
//!
//! # Add a law, an effect or a controller
//!
//! [`Law`], [`Effect`] and [`Controller`] are traits; implementations outside the library are used like those of the library. A law is made available
//! by [`register`] and checked by [`check_law`].
//!
//! # Conventions
//!
//! SI units everywhere inside the code; quantities carry their unit in files (`"18 kPa"`). Errors name the fact and the
//! remedy; a panic is a bug. A module may use only modules to its left (a test enforces it):
//!
//! ```text
//! wording → storage → subprocess → schema → catalogue → math → mesh → material → system → effect → solve → scene → reduction → calibrate → motion → report → live → study → prelude
//! ```
//!
//! [`open_scene`]: prelude::open_scene
//! [`SceneBuilder`]: scene::SceneBuilder
//! [`Scene::fields`]: scene::Scene::fields
//! [`Scene::run_with`]: scene::Scene::run_with
//! [`Controller`]: scene::control::Controller
//! [`Checkpoint`]: scene::Checkpoint
//! [`RunOptions`]: scene::RunOptions
//! [`run_study`]: prelude::run_study
//! [`write_report`]: prelude::write_report
//! [`Law`]: material::Law
//! [`Effect`]: system::Effect
//! [`register`]: material::register
//! [`check_law`]: material::check_law

pub mod calibrate;
pub mod catalogue;
pub mod effect;
pub mod live;
pub mod material;
pub mod math;
pub mod mesh;
pub mod motion;
pub mod prelude;
pub mod reduction;
pub mod report;
pub mod scene;
pub mod schema;
pub mod solve;
pub mod storage;
pub mod study;
pub mod subprocess;
pub mod system;
#[doc(hidden)]
pub mod wording;
