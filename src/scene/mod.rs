//! Scenes: what stands in a TOML file becomes a system, runs, and is recorded.

mod body;
mod build;
mod error;
pub mod overrides;
pub mod probe;
mod quantity;
mod run;
mod signal;
pub mod spec;

pub use body::request;
pub use build::{Body, Scene, read_scene, read_table};
pub use error::{SceneError, explain};
pub use quantity::{Length, Time};
pub use run::{Progress, Run, Snapshot};
pub use spec::SceneSpec;
