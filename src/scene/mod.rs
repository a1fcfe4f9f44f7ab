//! Scenes: what stands in a TOML file becomes a system, runs, and is recorded.

mod body;
mod build;
mod builder;
mod cavity;
mod comparison;
mod cover;
mod error;
mod formulation;
pub mod overrides;
pub mod probe;
pub mod protocol;
mod quantity;
mod read;
mod run;
pub mod sensitivity;
mod signal;
mod slopes;
pub mod spec;
mod stable;
mod stages;
mod start;
mod viscoelastic;

pub use body::request;
pub use build::{Body, Scene};
pub use error::{Mistake, SceneError, hint};
pub use quantity::{Length, Time};
pub use read::{from_text, read_scene, read_table};
pub use run::{Progress, Run, Snapshot};
pub use sensitivity::{Constant, SensitivityError};
pub use slopes::Slopes;
pub use spec::SceneSpec;
pub use start::StartSpec;
