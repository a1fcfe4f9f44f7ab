//! Reads a mesh file by its name: `.msh`, `.msh.gz`, `.vtk`, `.vtk.gz`.

use super::error::MeshError;
use super::{TetMesh, msh, vtk};
use std::io::Read;
use std::path::Path;

/// Reads and checks a mesh file; `unit_m` is the length of one unit of the file in metres (0.001 for millimetres).
pub fn read(path: &Path, unit_m: f64) -> Result<TetMesh, MeshError> {
    let unreadable = |e: std::io::Error| MeshError::Unreadable { file: path.to_path_buf(), reason: e.to_string() };
    let mut data = std::fs::read(path).map_err(unreadable)?;
    let name = path.to_string_lossy().to_lowercase();
    if data.starts_with(&[0x1f, 0x8b]) {
        let mut plain = Vec::new();
        flate2::read::MultiGzDecoder::new(&data[..]).read_to_end(&mut plain).map_err(unreadable)?;
        data = plain;
    }
    match name.strip_suffix(".gz").unwrap_or(&name).rsplit('.').next() {
        Some("vtk") => vtk::parse(path, &data, unit_m),
        Some("msh") => msh::parse(path, &data, unit_m),
        _ => Err(MeshError::Format {
            file: path.to_path_buf(),
            fact: "this file type is not read directly".into(),
            remedy: "in a scene give it as [mesh] file with a size: STEP, BREP, STL, OBJ and what meshio reads go through the mesher".into(),
        }),
    }
}
