//! Defects of a mesh as typed errors, with place, fact and remedy.

use crate::math::tensor::Vec3;
use crate::wording::hint;
use std::fmt;
use std::path::PathBuf;

/// Location in a file: text files count lines, binary ones bytes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Place {
    pub file: PathBuf,
    pub at: Option<Spot>,
}

/// A line (from 1) or a byte offset (from 0).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Spot {
    Line(usize),
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        match self.at {
            Some(Spot::Line(line)) => write!(f, ", line {line}"),
            Some(Spot::Byte(byte)) => write!(f, ", byte {byte}"),
            None => Ok(()),
        }
    }
}

/// The order of the mid-nodes of a cell in files, as a remedy.
const MID_NODES: &str = "write those of the corners 1 to 4 in the order 12 23 13 14 34 24 in MSH, 12 23 13 14 24 34 in VTK and Abaqus files";

/// Reason why a mesh was refused. Cells and nodes are given by their numbers in the file.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MeshError {
    #[error("{}: cannot be read: {reason}; check the path and its permissions", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: cannot be written: {reason}; check the folder, its permissions and the free space", file.display())]
    Unwritable { file: PathBuf, reason: String },
    #[error("{}: {fact}; {remedy}", file.display())]
    Format { file: PathBuf, fact: String, remedy: String },
    #[error("{place}: expected {wanted}, found \"{found}\"; the file is damaged, write it again")]
    Syntax { place: Place, wanted: String, found: String },
    #[error("{place}: the file ends where {wanted} should follow; it is truncated, write or copy it again")]
    Truncated { place: Place, wanted: String },
    #[error("{}: mixed-cell mesh: {kinds}; only tetrahedra of one order are read: remesh the body with tetrahedra", file.display())]
    MixedCells { file: PathBuf, kinds: String },
    #[error("{}: {kinds}; add split = true to [mesh]: hexahedra, wedges and pyramids become tetrahedra with the same nodes", file.display())]
    NotSplit { file: PathBuf, kinds: String },
    #[error("{}: merging makes node {node} a corner of cell {cell} twice; merge within a smaller distance", file.display())]
    MergedCell { file: PathBuf, cell: u64, node: u64 },
    #[error("{}: no tetrahedra ({found}); mesh the volume, or save its elements too (gmsh: Mesh.SaveAll = 1 or a physical volume)", file.display())]
    NoCells { file: PathBuf, found: String },
    #[error("{}: {owner} refers to node {node}, which the file does not define; write the file again", file.display())]
    UnknownNode { file: PathBuf, owner: String, node: i64 },
    #[error("{}: node {node} is defined twice; write the file again", file.display())]
    NodeTwice { file: PathBuf, node: u64 },
    #[error("{}: node {node} has a coordinate that is not finite; the file is damaged, write it again", file.display())]
    NotFinite { file: PathBuf, node: u64 },
    #[error("{}: nodes {first} and {second} are both at {}: a duplicate node is a crack; merge them: merge = \"1e-6 mm\" in [mesh]", file.display(), point(at))]
    DuplicateNode { file: PathBuf, first: u64, second: u64, at: Vec3 },
    #[error("{}: node {node} of cell {cell} is the mid-node of the edge {}-{} and lies at the edge {}-{}, and so in {count} of {cells} cells: the mid-nodes are in the order of another program; {MID_NODES}", file.display(), edge[0], edge[1], at[0], at[1])]
    MidNodeOrder { file: PathBuf, cell: u64, node: u64, edge: [u64; 2], at: [u64; 2], count: usize, cells: usize },
    #[error("{}: cells {} and {} have a face in common, and the mid-node of its edge {}-{} is {} in one and {} in the other: the face is a crack, or the mid-nodes are in the order of another program; merge the two nodes (merge in [mesh]), or {MID_NODES}", file.display(), cells[0], cells[1], edge[0], edge[1], nodes[0], nodes[1])]
    MidNodeTwice { file: PathBuf, edge: [u64; 2], nodes: [u64; 2], cells: [u64; 2] },
    #[error("{}: cell {cell} has zero volume ({volume:.3e} m^3); remove or remesh it", file.display())]
    ZeroVolume { file: PathBuf, cell: u64, volume: f64 },
    #[error("{}: cell {cell} is inverted (volume {volume:.3e} m^3; {count} of {cells} cells); renumber its nodes or remesh", file.display())]
    InvertedCell { file: PathBuf, cell: u64, volume: f64, count: usize, cells: usize },
    #[error("{}: curved cell {cell} folds over: its det J reaches {min_det:.3e} m^3; use a smaller size there, or order 1", file.display())]
    FoldedCell { file: PathBuf, cell: u64, min_det: f64 },
    #[error("{}: facet {facet} of region {region} is no face of any cell; save the volume next to it", file.display())]
    LooseFacet { file: PathBuf, facet: u64, region: String },
    #[error("{}: a face of cell {cell} is shared by three or more cells; remove the duplicated cells", file.display())]
    SharedFace { file: PathBuf, cell: u64 },
    #[error("{}: cells {} and {} are on the same side of a face that both have, so that they overlap; remove one of them", file.display(), cells[0], cells[1])]
    Overlap { file: PathBuf, cells: [u64; 2] },
    #[error("{}: region \"body\" holds {count} of {cells} cells; the name is kept for the whole body, rename the group", file.display())]
    PartialBody { file: PathBuf, count: usize, cells: usize },
    #[error("the mesh has no region {name}; {}", hint(name, known))]
    NoRegion { name: String, known: Vec<String> },
}

/// Formats a position for messages, in millimetres.
pub(crate) fn point(p: &Vec3) -> String {
    let mm = |x: f64| (x * 1e9).round() / 1e6 + 0.0;
    format!("({}, {}, {}) mm", mm(p.x), mm(p.y), mm(p.z))
}
