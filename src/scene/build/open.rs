//! A scene ready to run in one call: from its file, or from its text.

use super::{Scene, SceneBuilder};
use crate::scene::error::SceneError;
use std::path::Path;

/// Reads a scene file, makes or reads its mesh, and assembles the scene.
///
/// # Errors
///
/// Fails as [`SceneBuilder::open`] and [`SceneBuilder::build`] do.
pub fn open_scene(file: &Path) -> Result<Scene, SceneError> {
    SceneBuilder::open(file)?.build()
}

/// Assembles a scene from its text in TOML, see [`SceneBuilder::parse`].
///
/// # Errors
///
/// Fails as [`SceneBuilder::parse`] and [`SceneBuilder::build`] do.
pub fn parse_scene(text: &str) -> Result<Scene, SceneError> {
    SceneBuilder::parse(text)?.build()
}
