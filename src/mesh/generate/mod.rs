//! Meshes on demand: found by the hash of their request, or made by the mesher and stored.
//!
//! The mesher is a Python package, `meshes/meshgen`; it is never linked: it receives one JSON request on stdin, and returns one JSON manifest on
//! stdout and progress lines on stderr. Committed meshes `meshes/<body>/<hash>.msh.gz` need no Python.

pub mod body;
mod error;
mod geometry_digest;
pub mod interpreter;
pub mod manifest;
mod python;
pub mod referred;
pub mod request;
mod running;
mod size_field;
mod store;
#[cfg(all(test, unix))]
mod tests;

pub use body::ParametricBody;
pub use error::GenerateError;
pub use geometry_digest::geometry_files;
pub use manifest::{CablePath, Manifest};
pub use python::{Check, Mesher};
pub use request::{Generator, GradedPlace, Grading, MeshRequest, Size, Source, TIME_LIMIT_S};
pub use running::{MesherOwner, MesherTurn, end_meshers};
pub use size_field::SizeField;
pub use store::{Generated, MeshStore, manifest_path, read_manifest};
