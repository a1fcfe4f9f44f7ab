//! Recognition of mesh, surface and CAD files by their content.
//!
//! The file name decides only between formats without a signature.

use crate::mesh::error::MeshError;
use crate::storage::{self, DATA_LIMIT, is_packed};
use std::io::Read;
use std::path::Path;

/// Number of bytes at the beginning of a file that are used for recognition.
const HEAD: u64 = 4096;

/// A file format with its usual name, and the reader that it needs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Format {
    pub name: &'static str,
    pub reader: Reader,
}

/// The part of the program that reads a format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reader {
    /// A volume mesh in gmsh's MSH 2.2 or 4.1
    Msh,
    /// A volume mesh in legacy VTK
    Vtk,
    /// A volume mesh that the mesher converts: it is read by meshio under this name, or by `gmsh`
    Mesher(&'static str),
    /// A triangle surface whose interior is meshed; with its name in meshio
    Surface(&'static str),
    /// Solids with curved faces that are meshed; with its name in gmsh
    Cad(&'static str),
}

impl Reader {
    /// Returns the kind and the name under which the mesher knows a shape to be meshed; a volume mesh is represented by its surface.
    pub fn shape(self) -> (&'static str, &'static str) {
        match self {
            Self::Cad(name) => ("cad", name),
            Self::Surface(name) | Self::Mesher(name) => ("surface", name),
            Self::Msh => ("surface", "gmsh"),
            Self::Vtk => ("surface", "vtk"),
        }
    }

    /// Whether files of this format state their unit of length, from which they are converted to millimetres.
    pub fn states_its_unit(self) -> bool {
        matches!(self, Self::Cad(name) if name != "brep")
    }

    /// Whether files of this format contain volume cells, not a shape that has yet to be meshed.
    pub fn is_volume(self) -> bool {
        !matches!(self, Self::Surface(_) | Self::Cad(_))
    }
}

/// File name extensions of formats without a signature: (extension, name, reader).
const ENDINGS: &[(&str, &str, Reader)] = &[
    ("stl", "STL", Reader::Surface("stl")),
    ("obj", "OBJ", Reader::Surface("obj")),
    ("ply", "PLY", Reader::Surface("ply")),
    ("off", "OFF", Reader::Surface("off")),
    ("step", "STEP", Reader::Cad("step")),
    ("stp", "STEP", Reader::Cad("step")),
    ("iges", "IGES", Reader::Cad("iges")),
    ("igs", "IGES", Reader::Cad("iges")),
    ("brep", "BREP", Reader::Cad("brep")),
    ("inp", "Abaqus input", Reader::Mesher("abaqus")),
    ("avs", "AVS-UCD", Reader::Mesher("avsucd")),
    ("bdf", "Nastran bulk data", Reader::Mesher("nastran")),
    ("nas", "Nastran bulk data", Reader::Mesher("nastran")),
    ("fem", "Nastran bulk data", Reader::Mesher("nastran")),
    ("unv", "I-DEAS universal", Reader::Mesher("gmsh")),
    ("med", "MED", Reader::Mesher("gmsh")),
    ("mesh", "Medit", Reader::Mesher("medit")),
    ("meshb", "Medit, binary", Reader::Mesher("medit")),
    ("vol", "Netgen", Reader::Mesher("netgen")),
    ("ele", "TetGen", Reader::Mesher("tetgen")),
    ("node", "TetGen", Reader::Mesher("tetgen")),
    ("su2", "SU2", Reader::Mesher("su2")),
    ("e", "Exodus", Reader::Mesher("exodus")),
    ("exo", "Exodus", Reader::Mesher("exodus")),
    ("ex2", "Exodus", Reader::Mesher("exodus")),
    ("cgns", "CGNS", Reader::Mesher("cgns")),
    ("h5m", "MOAB", Reader::Mesher("h5m")),
    ("hmf", "HMF", Reader::Mesher("hmf")),
    ("f3grid", "FLAC3D", Reader::Mesher("flac3d")),
    ("mdpa", "Kratos", Reader::Mesher("mdpa")),
    ("post", "PERMAS", Reader::Mesher("permas")),
    ("dato", "PERMAS", Reader::Mesher("permas")),
    ("dat", "Tecplot", Reader::Mesher("tecplot")),
    ("tec", "Tecplot", Reader::Mesher("tecplot")),
    ("ugrid", "UGRID", Reader::Mesher("ugrid")),
    ("wkt", "WKT", Reader::Mesher("wkt")),
];

/// Returns the content of a file, decompressed if it is gzipped, and without a UTF-8 byte order mark.
pub fn content(file: &Path) -> Result<Vec<u8>, MeshError> {
    let data = storage::read(file, DATA_LIMIT).map_err(|e| unreadable(file, &e))?;
    let data = if is_packed(&data) { storage::unpacked(&data).map_err(|e| unreadable(file, &e))? } else { data };
    Ok(without_mark(data))
}

/// Returns the first bytes of the content of a file.
fn head(file: &Path) -> Result<Vec<u8>, MeshError> {
    let open = || storage::open(file).map_err(|e| unreadable(file, &e));
    let mut data = Vec::new();
    open()?.take(HEAD).read_to_end(&mut data).map_err(|e| unreadable(file, &e))?;
    if is_packed(&data) {
        data.clear();
        let mut unpacked = flate2::read::MultiGzDecoder::new(std::io::BufReader::new(open()?)).take(HEAD);
        unpacked.read_to_end(&mut data).map_err(|e| unreadable(file, &e))?;
    }
    Ok(without_mark(data))
}

fn unreadable(file: &Path, error: &std::io::Error) -> MeshError {
    MeshError::Unreadable { file: file.into(), reason: error.to_string() }
}

fn without_mark(mut data: Vec<u8>) -> Vec<u8> {
    if data.starts_with(b"\xef\xbb\xbf") {
        data.drain(..3);
    }
    data
}

/// Returns the format of a file; refuses unknown formats and UTF-16.
pub fn recognise(file: &Path) -> Result<Format, MeshError> {
    let data = head(file)?;
    let refuse = |fact: String, remedy: &str| Err(MeshError::Format { file: file.into(), fact, remedy: remedy.into() });
    if data.starts_with(&[0xff, 0xfe]) || data.starts_with(&[0xfe, 0xff]) {
        return refuse("this is text in UTF-16".into(), "save it as UTF-8");
    }
    if data.is_empty() {
        return refuse("the file is empty".into(), "write or copy it again");
    }
    let text = String::from_utf8_lossy(&data);
    if let Some(format) = marked(&text) {
        return Ok(format);
    }
    if data.starts_with(b"\x89HDF") && ending(file) == "h5" {
        return refuse("this holds the data of an XDMF file".into(), "name the .xdmf file that belongs to it");
    }
    match ENDINGS.iter().find(|e| e.0 == ending(file)) {
        Some(&(_, name @ "Abaqus input", reader)) if keyword(&text).is_some() => Ok(Format { name, reader }),
        // These formats have a signature; other content under their name is something else.
        Some((_, name @ ("STEP" | "Abaqus input"), _)) => {
            refuse(format!("the content is not that of a file of {name}"), "check the path, or write it again")
        }
        Some(&(_, name, reader)) => Ok(Format { name, reader }),
        None => refuse(
            "neither the content nor the name is that of a known format".into(),
            "use for example .msh, .vtk, .vtu, .inp, .mesh, .step or .stl",
        ),
    }
}

/// Whether a name is that of a mesh, surface or CAD file, whatever its content.
pub fn has_name(file: &Path) -> bool {
    let end = ending(file);
    ["msh", "vtk", "vtu", "xdmf", "xmf"].contains(&end.as_str()) || ENDINGS.iter().any(|e| e.0 == end)
}

/// Returns the extension of a name in lower case, without `.gz`.
fn ending(file: &Path) -> String {
    let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().to_lowercase());
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or_else(String::new, |(_, end)| end.into())
}

/// Returns the format whose signature is at the beginning of a file.
fn marked(text: &str) -> Option<Format> {
    let begin = text.trim_start();
    let format = |name, reader| Some(Format { name, reader });
    let tag = |name: &str| begin.split('<').any(|part| part.starts_with(name));
    let upper = begin.chars().take(200).collect::<String>().to_ascii_uppercase();
    match begin {
        _ if begin.starts_with("$MeshFormat") => match begin.split_ascii_whitespace().nth(1) {
            Some(version) if version == "4.1" || version.starts_with("2.") => format("MSH", Reader::Msh),
            // 4.0 and 3.0
            Some(_) => format("MSH, an old version", Reader::Mesher("gmsh")),
            None => format("MSH", Reader::Msh),
        },
        _ if begin.starts_with("$NOD") || begin.starts_with("$PARAMETRIC") => format("MSH 1", Reader::Mesher("gmsh")),
        _ if begin.starts_with("$Nodes") || begin.starts_with("$PhysicalNames") => format("MSH", Reader::Msh),
        _ if begin.starts_with("# vtk DataFile") => format("legacy VTK", Reader::Vtk),
        _ if begin.starts_with("(0 ") || begin.starts_with("(1 ") => format("Ansys MSH", Reader::Mesher("ansys")),
        _ if tag("VTKFile") => format("XML VTK", Reader::Mesher("vtu")),
        _ if tag("Xdmf") => format("XDMF", Reader::Mesher("xdmf")),
        _ if tag("dolfin") => format("DOLFIN XML", Reader::Mesher("dolfin-xml")),
        _ if begin.starts_with("ISO-10303-21") => format("STEP", Reader::Cad("step")),
        _ if begin.contains("CASCADE Topology") || begin.starts_with("DBRep_DrawableShape") => {
            format("BREP", Reader::Cad("brep"))
        }
        _ if text.get(72..73) == Some("S") && text.get(73..80).is_some_and(|n| n.trim().parse() == Ok(1)) => {
            format("IGES", Reader::Cad("iges"))
        }
        _ if begin.starts_with("ply") => format("PLY", Reader::Surface("ply")),
        _ if begin.starts_with("OFF") => format("OFF", Reader::Surface("off")),
        _ if begin.starts_with("solid") && text.contains("facet") => format("STL", Reader::Surface("stl")),
        _ if begin.starts_with("MeshVersionFormatted") => format("Medit", Reader::Mesher("medit")),
        _ if begin.starts_with("mesh3d") => format("Netgen", Reader::Mesher("netgen")),
        _ if begin.starts_with("NDIME") => format("SU2", Reader::Mesher("su2")),
        _ if is_abaqus(begin) => format("Abaqus input", Reader::Mesher("abaqus")),
        _ if upper.contains("BEGIN BULK") => format("Nastran bulk data", Reader::Mesher("nastran")),
        _ if text.lines().next().is_some_and(|line| line.trim_end() == "    -1") => {
            format("I-DEAS universal", Reader::Mesher("gmsh"))
        }
        _ => None,
    }
}

/// Whether the text starts with a keyword with which Abaqus input files often begin.
fn is_abaqus(text: &str) -> bool {
    let words = ["heading", "node", "part", "preprint", "parameter", "include", "assembly", "element", "system"];
    keyword(text).is_some_and(|line| words.iter().any(|w| line.to_ascii_lowercase().starts_with(w)))
}

/// Returns the first Abaqus keyword after comments and blank lines, without its star.
fn keyword(text: &str) -> Option<&str> {
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with("**"));
    lines.next()?.strip_prefix('*').filter(|line| line.starts_with(|c: char| c.is_ascii_alphabetic()))
}
