//! Writes VTU files (XML unstructured grid, base64) and PVD collections for ParaView.

use super::surface_file::Surface;
use crate::mesh::error::MeshError;
use crate::mesh::{Order, TetMesh};
use crate::storage;
use base64::Engine;
use std::fmt::Write;
use std::path::Path;

/// Values at the nodes or in the cells of a mesh.
pub struct Data<'a> {
    pub name: &'a str,
    /// 1 scalar, 3 vector, 9 tensor (row by row)
    pub components: usize,
    /// \[entities × components\]
    pub values: &'a [f64],
}

/// Writes the mesh in its reference configuration with data at the nodes and in the cells. Regions of cells other than `body` become cell data of 0
/// and 1. The file is written whole or not at all.
pub fn write_vtu(path: &Path, mesh: &TetMesh, nodes: &[Data], cells: &[Data]) -> Result<(), MeshError> {
    let (points, count) = (mesh.points.len(), mesh.cell_count());
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    write!(out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{count}\">\n")
        .expect("a string");
    out += "<PointData>\n";
    nodes.iter().for_each(|d| data(&mut out, d, points));
    out += "</PointData>\n<CellData>\n";
    cells.iter().for_each(|d| data(&mut out, d, count));
    for (name, region) in mesh.regions.iter().filter(|(name, r)| *name != "body" && !r.cells.is_empty()) {
        let mut flags = vec![0u8; count];
        region.cells.iter().for_each(|&c| flags[c as usize] = 1);
        array(&mut out, "UInt8", name, 1, &flags);
    }
    out += "</CellData>\n<Points>\n";
    array(&mut out, "Float64", "Points", 3, &bytes(mesh.points.iter().flat_map(|p| [p.x, p.y, p.z])));
    out += "</Points>\n<Cells>\n";
    let nodes = mesh.order.cell_nodes();
    let connectivity: Vec<u8> = mesh.cells.iter().flat_map(|&i| i64::from(i).to_le_bytes()).collect();
    let offsets: Vec<u8> = (1..=count).flat_map(|c| ((c * nodes) as i64).to_le_bytes()).collect();
    let kind = if mesh.order == Order::Linear { 10 } else { 24 };
    array(&mut out, "Int64", "connectivity", 1, &connectivity);
    array(&mut out, "Int64", "offsets", 1, &offsets);
    array(&mut out, "UInt8", "types", 1, &vec![kind; count]);
    out += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    replace(path, &out)
}

/// Writes a surface with data at its vertices.
pub fn write_surface(path: &Path, surface: &Surface, vertices: &[Data]) -> Result<(), MeshError> {
    let (points, count) = (surface.points.len(), surface.triangles.len());
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
    write!(out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{count}\">\n<PointData>\n")
        .expect("a string");
    vertices.iter().for_each(|d| data(&mut out, d, points));
    out += "</PointData>\n<Points>\n";
    array(&mut out, "Float64", "Points", 3, &bytes(surface.points.iter().flat_map(|p| [p.x, p.y, p.z])));
    out += "</Points>\n<Cells>\n";
    let connectivity: Vec<u8> = surface.triangles.iter().flatten().flat_map(|&k| i64::from(k).to_le_bytes()).collect();
    let offsets: Vec<u8> = (1..=count).flat_map(|c| (3 * c as i64).to_le_bytes()).collect();
    array(&mut out, "Int64", "connectivity", 1, &connectivity);
    array(&mut out, "Int64", "offsets", 1, &offsets);
    array(&mut out, "UInt8", "types", 1, &vec![5; count]);
    out += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    replace(path, &out)
}

/// Writes a PVD collection: one VTU file per time \[s\], with names relative to the collection.
pub fn write_pvd(path: &Path, steps: &[(f64, String)]) -> Result<(), MeshError> {
    let mut out =
        String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n");
    for (t, file) in steps {
        writeln!(out, "<DataSet timestep=\"{t}\" part=\"0\" file=\"{}\"/>", escape(file)).expect("a string");
    }
    out += "</Collection>\n</VTKFile>\n";
    replace(path, &out)
}

fn replace(path: &Path, text: &str) -> Result<(), MeshError> {
    storage::write(path, text.as_bytes())
        .map_err(|e| MeshError::Unwritable { file: path.to_path_buf(), reason: e.to_string() })
}

fn data(out: &mut String, data: &Data, entities: usize) {
    assert_eq!(data.values.len(), entities * data.components, "{}: one value per entity and component", data.name);
    array(out, "Float64", data.name, data.components, &bytes(data.values.iter().copied()));
}

fn bytes(values: impl Iterator<Item = f64>) -> Vec<u8> {
    values.flat_map(f64::to_le_bytes).collect()
}

/// Writes one inline array: the number of bytes \[u64\] and the bytes, in base64.
fn array(out: &mut String, kind: &str, name: &str, components: usize, data: &[u8]) {
    let name = escape(name);
    write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">")
        .expect("a string");
    let mut block = (data.len() as u64).to_le_bytes().to_vec();
    block.extend(data);
    base64::engine::general_purpose::STANDARD.encode_string(block, out);
    out.push_str("</DataArray>\n");
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::made::structured::block;

    #[test]
    fn what_was_written_can_be_decoded() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("block.vtu");
        let mesh = block(1, 1, 1, 1.0, 2.0, 3.0, Order::Quadratic);
        let u: Vec<f64> = mesh.points.iter().flat_map(|p| [p.x, 2.0 * p.y, 0.0]).collect();
        write_vtu(&path, &mesh, &[Data { name: "u <m>", components: 3, values: &u }], &[]).expect("writable");
        let text = std::fs::read_to_string(&path).expect("just written");
        let inside =
            text.split("Name=\"u &lt;m>\"").nth(1).and_then(|s| s.split(['>', '<']).nth(1)).expect("the array");
        let block = base64::engine::general_purpose::STANDARD.decode(inside).expect("base64");
        assert_eq!(block[..8], (u.len() as u64 * 8).to_le_bytes());
        let values: Vec<f64> =
            block[8..].chunks(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect();
        assert_eq!(values, u);
        assert!(text.contains("NumberOfPoints=\"27\" NumberOfCells=\"6\""));

        let error = write_vtu(&folder.path().join("missing/block.vtu"), &mesh, &[], &[]).expect_err("no such folder");
        assert!(error.to_string().contains("check the folder"), "{error}");
        write_pvd(&folder.path().join("run.pvd"), &[(0.5, "a.vtu".into())]).expect("writable");
        let text = std::fs::read_to_string(folder.path().join("run.pvd")).expect("just written");
        assert!(text.contains("<DataSet timestep=\"0.5\" part=\"0\" file=\"a.vtu\"/>"));
    }
}
