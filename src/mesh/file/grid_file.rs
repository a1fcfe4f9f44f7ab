//! Reads VTU files (XML unstructured grids of VTK) with their data, and PVD collections of them.
//!
//! Arrays may be text, base64 or appended (raw or base64), and may be compressed by zlib. Tetrahedra with 4 or 10 nodes and triangles are read.

use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use crate::mesh::surface::boundary::{Faces, push_boundary};
use crate::mesh::{Order, Region, TetMesh};
use crate::storage::{self, DATA_LIMIT};
use base64::Engine;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Values at the points or in the cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridData {
    pub name: String,
    pub components: usize,
    pub at_points: bool,
    /// \[entities × components\]
    pub values: Vec<f64>,
}

/// Cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub enum GridCells {
    Tetrahedra(TetMesh),
    Triangles(Vec<[u32; 3]>),
}

/// A grid read from a file.
#[derive(Clone, Debug)]
pub struct Grid {
    pub points: Vec<Vec3>,
    pub cells: GridCells,
    pub data: Vec<GridData>,
    /// Sentences on arrays that are left out of the data
    pub left_out: Vec<String>,
}

/// Returns the times of a collection \[s\] with their files, in the order of the collection: with the arc-length method the time may decrease.
/// Several parts at one time are refused.
pub fn read_collection(path: &Path) -> Result<Vec<(f64, PathBuf)>, MeshError> {
    let text = text(path)?;
    let document = parsed(path, &text)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let sets = document.descendants().filter(|n| n.has_tag_name("DataSet"));
    let mut parts: BTreeMap<u64, &str> = BTreeMap::new();
    let mut found: Vec<(f64, PathBuf)> = vec![];
    for set in sets {
        let time = set.attribute("timestep").and_then(|t| t.parse::<f64>().ok());
        let (Some(t), Some(file)) = (time, set.attribute("file")) else { continue };
        let part = set.attribute("part").unwrap_or("0");
        if *parts.entry(t.to_bits()).or_insert(part) != part {
            let fact = format!("the time {t} has several parts, {file} is one of them");
            return Err(refuse(
                path,
                &fact,
                "merge the parts of each time into one file, or show the files of one part",
            ));
        }
        found.push((t, folder.join(file)));
    }
    if found.is_empty() {
        Err(refuse(path, "this collection names no file", "check the program that wrote it"))
    } else {
        Ok(found)
    }
}

/// Reads a grid with its data; `unit_m` is the length of one unit of its points in metres.
pub fn read_grid(path: &Path, unit_m: f64) -> Result<Grid, MeshError> {
    let bytes = storage::read(path, DATA_LIMIT)
        .map_err(|e| MeshError::Unreadable { file: path.into(), reason: e.to_string() })?;
    let (head, raw) = without_raw(&bytes);
    let text =
        std::str::from_utf8(&head).map_err(|_| refuse(path, "this is no text in UTF-8", "write it again as VTU"))?;
    let document = parsed(path, text)?;
    let file = File::new(path, &document, raw)?;
    let pieces: Vec<Node> = document.descendants().filter(|n| n.has_tag_name("Piece")).collect();
    let [piece] = pieces[..] else {
        return Err(refuse(path, &format!("it has {} pieces", pieces.len()), "save the grid as one piece"));
    };
    let part = |name: &str| piece.children().find(move |n| n.has_tag_name(name));
    let arrays = |part: Option<Node>| Vec::from_iter(part.iter().flat_map(|p| file.arrays(p)));
    let places = arrays(part("Points")).into_iter().next().and_then(|array| array.values).unwrap_or_default();
    let points: Vec<Vec3> = places.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2]) * unit_m).collect();
    if let Some(k) = points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return Err(MeshError::NotFinite { file: path.into(), node: k as u64 });
    }
    let cells = arrays(part("Cells"));
    let of = |name: &str| cells.iter().find(|a| a.name == name).and_then(|a| a.values.as_deref()).unwrap_or_default();
    let cells = cells_of(path, &points, [of("connectivity"), of("offsets"), of("types")])?;
    let count = of("types").len();
    let (mut data, mut left_out) = (vec![], vec![]);
    for (part_name, at_points, entities) in [("PointData", true, points.len()), ("CellData", false, count)] {
        for Array { name, components, values } in arrays(part(part_name)) {
            match values {
                Some(values) if components.checked_mul(entities) == Some(values.len()) => {
                    data.push(GridData { name, components, at_points, values });
                }
                Some(values) => left_out.push(format!(
                    "{name} of {part_name} is left out: it has {} values, not {components} for each of {entities}.",
                    values.len()
                )),
                None => left_out.push(format!("{name} of {part_name} is left out: its values cannot be read.")),
            }
        }
    }
    Ok(Grid { points, cells, data, left_out })
}

fn refuse(file: &Path, fact: &str, remedy: &str) -> MeshError {
    MeshError::Format { file: file.into(), fact: fact.into(), remedy: remedy.into() }
}

fn text(path: &Path) -> Result<String, MeshError> {
    storage::read_text(path, DATA_LIMIT).map_err(|e| MeshError::Unreadable { file: path.into(), reason: e.to_string() })
}

fn parsed<'a>(path: &Path, text: &'a str) -> Result<Document<'a>, MeshError> {
    let options = roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: 1 << 20 };
    Document::parse_with_options(text, options)
        .map_err(|e| refuse(path, &format!("it is not well-formed XML: {e}"), "write it again"))
}

/// Returns the text of a file without the appended raw bytes, which are not XML, and those bytes.
fn without_raw(bytes: &[u8]) -> (Vec<u8>, Option<&[u8]>) {
    let find = |what: &[u8], from: usize| bytes[from..].windows(what.len()).position(|w| w == what).map(|k| k + from);
    let Some(tag) = find(b"<AppendedData", 0) else { return (bytes.to_vec(), None) };
    let open = find(b">", tag).unwrap_or(bytes.len() - 1);
    let is_raw = bytes[tag..open].windows(3).any(|w| w == b"raw");
    let (Some(start), Some(end)) = (find(b"_", open), bytes.windows(15).rposition(|w| w == b"</AppendedData>")) else {
        return (bytes.to_vec(), None);
    };
    if !is_raw || start >= end {
        return (bytes.to_vec(), None);
    }
    ([&bytes[..=start], &bytes[end..]].concat(), Some(&bytes[start + 1..end]))
}

/// An array of a part; it has no values if it cannot be read.
struct Array {
    name: String,
    components: usize,
    values: Option<Vec<f64>>,
}

/// Encoding of the arrays of a file.
struct File<'a> {
    wide: bool,
    packed: bool,
    raw: Option<&'a [u8]>,
    /// Appended base64 text
    appended: Option<&'a str>,
}

impl<'a> File<'a> {
    fn new(path: &Path, document: &'a Document, raw: Option<&'a [u8]>) -> Result<Self, MeshError> {
        let root = document.root_element();
        if root.attribute("type") != Some("UnstructuredGrid") {
            let fact = format!("a file of type {} has no cells to show", root.attribute("type").unwrap_or("(none)"));
            return Err(refuse(path, &fact, "save it as an unstructured grid (.vtu)"));
        }
        let mut arrays = root.descendants().filter(|node| node.has_tag_name("DataArray"));
        // Text has no byte order
        let is_binary = arrays.any(|array| array.attribute("format") != Some("ascii"));
        if is_binary && root.attribute("byte_order") == Some("BigEndian") {
            return Err(refuse(path, "its numbers are big endian", "write it on a little-endian machine, or as text"));
        }
        let compressor = root.attribute("compressor");
        if compressor.is_some_and(|c| c != "vtkZLibDataCompressor") {
            return Err(refuse(
                path,
                "it is compressed by another method than zlib",
                "save it with zlib or uncompressed",
            ));
        }
        let appended = document.descendants().find(|n| n.has_tag_name("AppendedData")).and_then(|n| n.text());
        let appended = appended.and_then(|t| t.trim().strip_prefix('_'));
        Ok(Self { wide: root.attribute("header_type") == Some("UInt64"), packed: compressor.is_some(), raw, appended })
    }

    /// Returns the arrays of a part.
    fn arrays(&self, part: &Node) -> Vec<Array> {
        let arrays = part.children().filter(|n| n.has_tag_name("DataArray"));
        let of = |n: Node| Array {
            name: n.attribute("Name").unwrap_or_default().into(),
            components: n.attribute("NumberOfComponents").and_then(|c| c.parse().ok()).unwrap_or(1),
            values: self.values(&n),
        };
        arrays.map(of).collect()
    }

    fn values(&self, array: &Node) -> Option<Vec<f64>> {
        let kind = array.attribute("type")?;
        let bytes = match array.attribute("format")? {
            "ascii" => return array.text()?.split_ascii_whitespace().map(|w| w.parse().ok()).collect(),
            "binary" => self.content(&decoded(array.text()?.trim())?)?,
            _ => {
                let offset: usize = array.attribute("offset")?.parse().ok()?;
                match self.raw {
                    Some(raw) => self.content(raw.get(offset..)?)?,
                    None => self.content(&decoded(self.appended?.get(offset..)?)?)?,
                }
            }
        };
        numbers(kind, &bytes)
    }

    /// Returns the bytes of an array without their header, which is one length, or the lengths of compressed blocks.
    fn content(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let width = if self.wide { 8 } else { 4 };
        let length = |k: usize| -> Option<usize> {
            let word = bytes.get(k * width..(k + 1) * width)?;
            let value = word.iter().rev().fold(0u64, |v, b| (v << 8) | u64::from(*b));
            usize::try_from(value).ok()
        };
        if !self.packed {
            return Some(bytes.get(width..width.checked_add(length(0)?)?)?.to_vec());
        }
        let (blocks, size) = (length(0)?, length(1)?);
        let mut at = width.checked_mul(blocks.checked_add(3)?)?;
        let mut out = Vec::new();
        for k in 0..blocks {
            let end = at.checked_add(length(3 + k)?)?;
            let block = flate2::read::ZlibDecoder::new(bytes.get(at..end)?);
            block.take(size as u64).read_to_end(&mut out).ok()?;
            at = end;
        }
        Some(out)
    }
}

/// Decodes consecutive pieces of base64, each with its padding; `None` if there are invalid characters.
fn decoded(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut rest = text.as_bytes();
    while !rest.is_empty() {
        let padding = rest.iter().position(|b| *b == b'=').unwrap_or(rest.len());
        let end = rest.len().min((padding + 1).next_multiple_of(4));
        base64::engine::general_purpose::STANDARD.decode_vec(&rest[..end], &mut out).ok()?;
        rest = &rest[end..];
    }
    Some(out)
}

fn numbers(kind: &str, bytes: &[u8]) -> Option<Vec<f64>> {
    macro_rules! read {
        ($t:ty) => {{
            const N: usize = std::mem::size_of::<$t>();
            bytes.chunks_exact(N).map(|b| Some(<$t>::from_le_bytes(b.try_into().ok()?) as f64)).collect()
        }};
    }
    match kind {
        "Float64" => read!(f64),
        "Float32" => read!(f32),
        "Int64" => read!(i64),
        "UInt64" => read!(u64),
        "Int32" => read!(i32),
        "UInt32" => read!(u32),
        "Int16" => read!(i16),
        "UInt16" => read!(u16),
        "Int8" => read!(i8),
        "UInt8" => read!(u8),
        _ => None,
    }
}

fn cells_of(path: &Path, points: &[Vec3], [nodes, offsets, types]: [&[f64]; 3]) -> Result<GridCells, MeshError> {
    let kinds: std::collections::BTreeSet<i64> = types.iter().map(|t| *t as i64).collect();
    let kinds: Vec<i64> = kinds.into_iter().collect();
    let size = match kinds[..] {
        [10] => 4,
        [24] => 10,
        [5] => 3,
        [] => return Err(refuse(path, "it has no cells", "save the grid with its cells")),
        _ => {
            let fact = format!("it has cells of VTK's types {kinds:?}");
            return Err(refuse(path, &fact, "save tetrahedra of one order (10 or 24), or triangles (5)"));
        }
    };
    let fits =
        nodes.len() == size * types.len() && offsets.iter().enumerate().all(|(k, end)| *end == ((k + 1) * size) as f64);
    let known = |n: &&f64| **n >= 0.0 && **n < points.len() as f64;
    if let Some(node) = nodes.iter().find(|n| !known(n)) {
        return Err(MeshError::UnknownNode { file: path.into(), owner: "a cell".into(), node: *node as i64 });
    }
    if !fits {
        return Err(refuse(path, "the offsets of its cells do not fit their nodes", "write it again"));
    }
    let nodes: Vec<u32> = nodes.iter().map(|n| *n as u32).collect();
    if size == 3 {
        return Ok(GridCells::Triangles(nodes.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()));
    }
    let order = if size == 4 { Order::Linear } else { Order::Quadratic };
    let mut mesh = TetMesh { order, points: points.to_vec(), cells: nodes, facets: vec![], regions: BTreeMap::new() };
    let faces = Faces::of(&mesh).map_err(|cell| {
        refuse(path, &format!("a face of cell {cell} belongs to three cells"), "mesh the body again")
    })?;
    push_boundary(&mut mesh, &faces, |_| false);
    mesh.regions.insert("body".into(), Region { cells: (0..mesh.cell_count() as u32).collect(), ..Region::default() });
    Ok(GridCells::Tetrahedra(mesh))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::file::vtu::{Data, write_pvd, write_vtu};
    use crate::mesh::made::structured::block;

    /// The values written for ParaView are read back bit for bit.
    #[test]
    fn what_was_written_is_read_back() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for order in [Order::Linear, Order::Quadratic] {
            let path = folder.path().join("a.vtu");
            let mesh = block(2, 1, 1, 0.2, 0.1, 0.3, order);
            let u: Vec<f64> = mesh.points.iter().flat_map(|p| [p.x * p.y, 1.0 / 3.0, -p.z]).collect();
            let q: Vec<f64> = (0..mesh.cell_count()).map(|c| c as f64).collect();
            let (u, q) =
                (Data { name: "u <&", components: 3, values: &u }, Data { name: "q", components: 1, values: &q });
            write_vtu(&path, &mesh, &[u], &[q]).expect("room");
            let grid = read_grid(&path, 1.0).expect("readable");
            let GridCells::Tetrahedra(found) = grid.cells else { panic!("tetrahedra") };
            assert_eq!((found.points, found.cells), (mesh.points.clone(), mesh.cells.clone()));
            assert_eq!(found.facets.len(), mesh.facets.len());
            assert_eq!((grid.data[0].name.as_str(), grid.data[0].values[4]), ("u <&", 1.0 / 3.0));
            assert_eq!((grid.data[1].at_points, grid.data[1].values.len()), (false, mesh.cell_count()));
        }
        let path = folder.path().join("a.pvd");
        write_pvd(&path, &[(0.5, "a.vtu".into())]).expect("room");
        assert_eq!(read_collection(&path).expect("readable"), [(0.5, folder.path().join("a.vtu"))]);
    }

    /// Several parts at one time are refused, because one part is not the whole body; one part at several times is accepted.
    #[test]
    fn a_time_with_several_parts_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.pvd");
        let of = |sets: &[(f64, u32)]| {
            let set =
                |(t, part): &(f64, u32)| format!("<DataSet timestep=\"{t}\" part=\"{part}\" file=\"{part}.vtu\"/>");
            let sets: String = sets.iter().map(set).collect();
            std::fs::write(&path, format!("<VTKFile><Collection>{sets}</Collection></VTKFile>")).expect("room");
            read_collection(&path)
        };
        assert_eq!(of(&[(1.0, 1), (0.5, 1), (1.0, 1)]).expect("one part").len(), 3);
        let refused = of(&[(0.0, 0), (1.0, 0), (0.0, 1)]).expect_err("two parts").to_string();
        assert!(refused.contains("the time 0 has several parts, 1.vtu is one of them"), "{refused}");
    }

    #[test]
    fn pieces_of_base64_are_one_after_the_other() {
        for (text, expected) in
            [("", Some(&b""[..])), ("QQ==QkM=REVG", Some(&b"ABCDEF"[..])), ("QUJD====", None), ("QQ ==", None)]
        {
            assert_eq!(decoded(text).as_deref(), expected, "{text}");
        }
    }

    /// One tetrahedron with its arrays in every form that VTK writes.
    #[test]
    fn text_base64_compressed_and_appended_arrays_are_read() {
        let engine = &base64::engine::general_purpose::STANDARD;
        let floats = |v: &[f32]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let points = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let packed = {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            std::io::Write::write_all(&mut encoder, &points).and_then(|()| encoder.finish()).expect("memory")
        };
        let header = |words: &[u32]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
        let plain = [header(&[48]), points.clone()].concat();
        let blocks = header(&[1, 48, 48, packed.len() as u32]);
        let cases: [(&str, &str, String, Vec<u8>); 5] = [
            ("", "format=\"ascii\"", "0 0 0 1 0 0 0 1 0 0 0 1".into(), vec![]),
            ("", "format=\"binary\"", engine.encode(&plain), vec![]),
            (
                "compressor=\"vtkZLibDataCompressor\"",
                "format=\"binary\"",
                engine.encode(&blocks) + &engine.encode(&packed),
                vec![],
            ),
            (
                "",
                "format=\"appended\" offset=\"0\"",
                String::new(),
                [b"<AppendedData encoding=\"raw\">_".to_vec(), plain.clone()].concat(),
            ),
            (
                "",
                "format=\"appended\" offset=\"0\"",
                String::new(),
                format!("<AppendedData encoding=\"base64\">_{}", engine.encode(&plain)).into(),
            ),
        ];
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (root, how, inside, appended) in cases {
            let cells = "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
                <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>";
            let mut file = format!(
                "<VTKFile type=\"UnstructuredGrid\" {root}><UnstructuredGrid><Piece><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" {how}>{inside}</DataArray></Points>{cells}</Piece></UnstructuredGrid>"
            ).into_bytes();
            if !appended.is_empty() {
                file.extend(appended);
                file.extend(b"</AppendedData>");
            }
            file.extend(b"</VTKFile>");
            let path = folder.path().join("a.vtu");
            std::fs::write(&path, file).expect("room");
            let grid = read_grid(&path, 1e-3).unwrap_or_else(|e| panic!("{how}: {e}"));
            assert_eq!(grid.points[3], Vec3::new(0.0, 0.0, 1e-3), "{how}");
        }
    }
}
