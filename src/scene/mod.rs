//! Scenes: what stands in a TOML file becomes a system, runs, and is recorded.

mod body;
mod build;
mod builder;
mod cavity;
mod compare;
mod comparison;
pub mod control;
mod course;
mod cover;
mod error;
mod ledger;
pub mod output;
pub mod overrides;
pub mod probe;
pub mod protocol;
mod quantity;
mod read;
mod run;
pub mod sensitivity;
mod signal;
pub mod spec;
mod stable;
mod stages;
mod steering;
mod viscoelastic;

pub use body::request;
pub use build::{Body, Scene};
pub use compare::Measured;
pub use course::{Course, CourseError};
pub use error::{Mistake, SceneError, hint};
pub use quantity::{Length, Time};
pub use read::{from_text, read_scene, read_table};
pub use run::{Progress, Run, Snapshot};
pub use sensitivity::{Constant, Sensitivity, SensitivityError};
pub use spec::SceneSpec;
pub use steering::Steering;
