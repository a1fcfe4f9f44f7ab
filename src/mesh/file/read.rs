//! Reads a mesh file of a known format.

use super::assemble::{Changes, RawMesh, Reading};
use super::format::{Reader, content, recognise};
use super::{msh, vtk};
use crate::mesh::TetMesh;
use crate::mesh::error::MeshError;
use std::path::Path;

/// Reads and checks a mesh file, recognised by its content; `unit_m` is the length of one unit of the file in metres (0.001 for millimetres).
pub fn read(path: &Path, unit_m: f64) -> Result<TetMesh, MeshError> {
    let how = Reading { unit_m, split: false, merge: None };
    match recognise(path)?.reader {
        reader @ (Reader::Msh | Reader::Vtk) => Ok(read_as(path, path, reader, &how)?.0),
        _ => Err(MeshError::Format {
            file: path.to_path_buf(),
            fact: "this file type is not read directly".into(),
            remedy: "give it as [mesh] file in a scene: other formats go through the mesher".into(),
        }),
    }
}

/// Reads the content of one file, in gmsh's or VTK's format, under the name of the file from which it was converted.
pub fn read_as(name: &Path, path: &Path, reader: Reader, how: &Reading) -> Result<(TetMesh, Changes), MeshError> {
    raw(name, path, reader)?.finish(how)
}

/// Reads the content of a mesh file without checks.
pub(super) fn raw(name: &Path, path: &Path, reader: Reader) -> Result<RawMesh, MeshError> {
    let data = content(path)?;
    match reader {
        Reader::Vtk => vtk::parse(name, &data),
        _ => msh::parse(name, &data),
    }
}
