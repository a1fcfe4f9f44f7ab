//! The starter around a shape: a mesh, surface or CAD file of the user.

use super::error::StarterError;
use super::folder::write;
use crate::mesh::format::recognise;
use crate::mesh::generate::request::companions;
use crate::scene::{Import, SceneError, starter};
use std::path::Path;

/// Fills the folder of a project with a copy of the file, a scene that holds the body at one end under its weight, a study and a page.
pub(super) fn fill(
    folder: &Path,
    file: &Path,
    title: &str,
    unit: Option<&str>,
    progress: &mut dyn FnMut(&str),
) -> Result<(), StarterError> {
    let format = recognise(file).map_err(SceneError::Mesh)?;
    for part in companions(file, format.reader.shape().1) {
        let name = part.file_name().unwrap_or_default();
        std::fs::copy(&part, folder.join(name)).map_err(|e| StarterError::io(&part, &e))?;
    }
    let copy = folder.join(file.file_name().unwrap_or_default());
    // Messages name the file of the user
    let mut import = Import::of(file, unit, progress)?;
    let imported = import.load(progress)?;
    let scene = starter(&Import { file: copy.clone(), ..import.clone() }, &imported, folder);
    // Only a shape that is meshed here has finer meshes
    let (study, question) = match import.spec.cells {
        Some(cells) => (convergence(cells), "which mesh can be trusted with the elastic energy"),
        None => (include_str!("shape/sweep.toml").to_string(), "how the elastic energy depends on the stiffness"),
    };
    let name = copy.file_name().unwrap_or_default().to_string_lossy();
    let page = include_str!("shape/README.md")
        .replace("{name}", title)
        .replace("{file}", &name)
        .replace("{question}", question);
    write(folder, [("scene.toml", &scene), ("study.toml", &study), ("README.md", &page)])
}

/// The study with meshes of so many cells, and of 2.5 and 6 times as many.
fn convergence(cells: usize) -> String {
    let member = |cells: usize| format!("\n{cells} = {{ \"mesh.cells\" = {cells} }}");
    let usual = include_str!("shape/convergence.toml").to_string();
    [2000, 5000, 12000].iter().fold(usual, |text, n| text.replace(&member(*n), &member(n * cells / 2000)))
}
