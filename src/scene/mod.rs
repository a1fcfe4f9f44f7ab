//! Scenes: what stands in a TOML file becomes a system, runs, and is recorded.

mod body;
mod build;
mod builder;
mod cable;
pub mod cable_record;
mod cavity;
mod comparison;
mod cover;
mod describe;
mod error;
mod loads;
pub mod overrides;
pub mod probe;
pub mod protocol;
mod quantity;
mod read;
mod run;
pub mod sensitivity;
mod signal;
mod skin;
mod slopes;
pub mod spec;
mod stable;
mod stages;
mod viscoelastic;

pub use body::request;
pub use build::{Body, Scene};
pub use error::{Mistake, SceneError, hint};
pub use quantity::{Length, Time};
pub use read::{from_text, read_scene, read_table};
pub use run::{Progress, Run, Snapshot};
pub use sensitivity::{Constant, SensitivityError};
pub use skin::NamedSkin;
pub use slopes::Slopes;
pub use spec::SceneSpec;
