//! A scene ready to run in one call: from its file, or from its text.

use super::body::Body;
use super::build::Scene;
use super::error::SceneError;
use super::read::{from_text, read_scene};
use super::spec::SceneSpec;
use std::path::Path;
use std::sync::Arc;

/// Reads a scene file, makes or reads its mesh, and assembles the scene.
pub fn open_scene(file: &Path) -> Result<Scene, SceneError> {
    let (spec, text) = read_scene(file, &[])?;
    assemble(file, spec, text)
}

/// Assembles a scene from its text in TOML. Files that it names are found from the current folder; laws are given in
/// the text itself, without `include`.
pub fn parse_scene(text: &str) -> Result<Scene, SceneError> {
    let file = Path::new("scene.toml");
    assemble(file, from_text(file, text, "")?, text.to_string())
}

fn assemble(file: &Path, spec: SceneSpec, text: String) -> Result<Scene, SceneError> {
    let body = Body::load(file, &spec.mesh, &mut |_| {})?;
    Scene::build(file, spec, text, Arc::new(body))
}
