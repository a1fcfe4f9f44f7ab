//! Meshes that are available without the mesher: whether that of a scene is stored, and how one is stored for users without a mesher.

use super::mesh_file::volume_mesh;
use super::mesh_spec::MeshSpec;
use super::request::{has_source, request_from};
use crate::mesh::format::{Format, Reader};
use crate::mesh::generate::{GenerateError, MeshStore};
use crate::scene::error::{SceneError, part};
use std::path::{Path, PathBuf};

/// A mesh that the mesher makes for a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeMesh {
    /// The body that is meshed; `None` for a file
    pub body: Option<String>,
    /// Name of its file, or of the file that is converted
    pub name: String,
    /// Path of the stored mesh; `None` if it is not stored
    pub stored: Option<PathBuf>,
}

/// The meshes that the mesher makes for a `[mesh]` table of this scene file: neither grids nor files that are read as they are.
///
/// # Errors
/// A table that describes no mesh.
pub fn made_meshes(file: &Path, spec: &MeshSpec, store: &MeshStore) -> Result<Vec<MadeMesh>, SceneError> {
    let made = sources(spec).into_iter().map(|one| made_mesh(file, one, store));
    Ok(made.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Stores the meshes of a `[mesh]` table of this scene file with the committed ones, and makes those that are missing. `progress` receives the output lines of
/// the mesher.
///
/// # Errors
/// A table that describes no mesh, a mesh that cannot be made, or a store of the program itself, which takes none.
pub fn keep(file: &Path, spec: &MeshSpec, store: &MeshStore, progress: &mut dyn FnMut(&str)) -> Result<(), SceneError> {
    let fail = |e: GenerateError| part(file, "mesh", e);
    for one in sources(spec).iter().filter(|one| one.grid.is_none()) {
        match volume_mesh(file, one)? {
            Some((path, Format { reader: Reader::Mesher(name), .. })) => {
                store.commit_converted(&path, name, progress).map_err(fail)?;
            }
            Some(_) => {}
            None => {
                store.commit(&request_from(file, one, Some(store))?, progress).map_err(fail)?;
            }
        }
    }
    Ok(())
}

/// The mesh tables of a scene: the one of the whole, and those of parts with their own source.
fn sources(spec: &MeshSpec) -> Vec<MeshSpec> {
    let own = spec.parts.iter().map(|of| of.mesh(spec));
    Some(spec.clone()).into_iter().chain(own).filter(has_source).collect()
}

fn made_mesh(file: &Path, spec: MeshSpec, store: &MeshStore) -> Result<Option<MadeMesh>, SceneError> {
    if spec.grid.is_some() {
        return Ok(None);
    }
    let fail = |e: GenerateError| part(file, "mesh", e);
    let file_name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match volume_mesh(file, &spec)? {
        Some((path, Format { reader: Reader::Mesher(format), .. })) => {
            let stored = store.stored_conversion(&path, format).map_err(fail)?;
            Ok(Some(MadeMesh { body: None, name: file_name(&path), stored }))
        }
        Some(_) => Ok(None),
        None => {
            let request = request_from(file, &spec, Some(store))?;
            let stored = store.stored(&request).map_err(fail)?;
            let name = stored.as_deref().map_or_else(|| store.file_name(&request), |path| Ok(file_name(path)));
            Ok(Some(MadeMesh { body: spec.body, name: name.map_err(fail)?, stored }))
        }
    }
}
