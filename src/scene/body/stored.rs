//! Whether the mesh of a scene is there without the mesher, and how it is kept for those who have none.

use super::mesh_file::volume_mesh;
use super::mesh_spec::MeshSpec;
use super::request::{has_source, request_from};
use crate::mesh::format::{Format, Reader};
use crate::mesh::generate::{GenerateError, MeshStore};
use crate::scene::error::{SceneError, part};
use std::path::Path;

/// Whether nothing has to be meshed or converted for a `[mesh]` table of this scene file: its meshes are grids, files that are read as they are, or
/// stored.
///
/// # Errors
/// A table that describes no mesh.
pub fn is_stored(file: &Path, spec: &MeshSpec, store: &MeshStore) -> Result<bool, SceneError> {
    for one in sources(spec) {
        if !is_one_stored(file, &one, store)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Keeps the meshes of a `[mesh]` table of this scene file with the committed ones, and makes those that are not stored. `progress` gets the lines of
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

/// The tables of the meshes of a scene: that of the whole, and of the parts that have their own.
fn sources(spec: &MeshSpec) -> Vec<MeshSpec> {
    let own = spec.parts.iter().map(|of| of.mesh(spec));
    Some(spec.clone()).into_iter().chain(own).filter(has_source).collect()
}

fn is_one_stored(file: &Path, spec: &MeshSpec, store: &MeshStore) -> Result<bool, SceneError> {
    if spec.grid.is_some() {
        return Ok(true);
    }
    let fail = |e: GenerateError| part(file, "mesh", e);
    match volume_mesh(file, spec)? {
        Some((path, format)) => match format.reader {
            Reader::Mesher(name) => Ok(store.stored_conversion(&path, name).map_err(fail)?.is_some()),
            _ => Ok(true),
        },
        None => Ok(store.stored(&request_from(file, spec, Some(store))?).map_err(fail)?.is_some()),
    }
}
