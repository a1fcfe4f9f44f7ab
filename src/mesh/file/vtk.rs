//! Legacy VTK unstructured grids, text and binary (big endian), versions 2.0 to 5.1.
//!
//! Cells read: VTK_TETRA (10), VTK_QUADRATIC_TETRA (24), VTK_HEXAHEDRON (12), VTK_VOXEL (11), VTK_WEDGE (13) and VTK_PYRAMID (14); vertices, lines
//! and surface cells are skipped, but their nodes need not belong to a tetrahedron. Every integer array of CELL_DATA with 2 to 64 different values on
//! the cells (gmsh's `CellEntityIds`, `gmsh:physical`) becomes regions `<name>_<value>`; other data are skipped.

use super::assemble::RawMesh;
use super::cursor::Cursor;
use super::solid::Solid;
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use std::collections::BTreeMap;
use std::path::Path;

/// Kinds of cells by VTK's number: (number, dimension, name).
const KINDS: &[(i64, usize, &str)] = &[
    (0, 0, "empty cells"),
    (1, 0, "vertices"),
    (2, 0, "vertices"),
    (3, 1, "lines"),
    (4, 1, "lines"),
    (21, 1, "lines"),
    (5, 2, "triangles"),
    (6, 2, "triangle strips"),
    (7, 2, "polygons"),
    (8, 2, "pixels"),
    (9, 2, "quadrangles"),
    (22, 2, "6-node triangles"),
    (23, 2, "8-node quadrangles"),
    (28, 2, "9-node quadrangles"),
    (10, 3, "4-node tetrahedra"),
    (24, 3, "10-node tetrahedra"),
    (11, 3, "voxels"),
    (12, 3, "8-node hexahedra"),
    (25, 3, "20-node hexahedra"),
    (29, 3, "27-node hexahedra"),
    (13, 3, "6-node prisms"),
    (26, 3, "15-node prisms"),
    (14, 3, "5-node pyramids"),
    (27, 3, "13-node pyramids"),
];

/// Largest number of different values of a data array for which each value becomes a region.
const MOST_VALUES: usize = 64;

/// Parses the bytes of a legacy VTK file (`file` is for messages).
pub(in crate::mesh) fn parse(file: &Path, data: &[u8]) -> Result<RawMesh, MeshError> {
    let mut at = Cursor::new(file, data);
    let format =
        |fact: &str, remedy: &str| MeshError::Format { file: file.into(), fact: fact.into(), remedy: remedy.into() };
    let head = at.line().unwrap_or_default();
    if !head.starts_with("# vtk DataFile") {
        return Err(at.syntax("# vtk DataFile Version", head));
    }
    at.line();
    let binary = match at.word() {
        Some("ASCII") => false,
        Some("BINARY") => true,
        Some(other) => return Err(at.syntax("ASCII or BINARY", other)),
        None => return Err(at.truncated("ASCII or BINARY")),
    };
    at.big_endian = true;
    let mut grid = Grid { binary, ..Grid::default() };
    while let Some(keyword) = at.word() {
        match keyword {
            "DATASET" => match at.word() {
                Some("UNSTRUCTURED_GRID") => {}
                other => {
                    let fact = format!("a dataset of type {} holds no tetrahedra", other.unwrap_or("(none)"));
                    return Err(format(&fact, "write the mesh as UNSTRUCTURED_GRID"));
                }
            },
            "METADATA" => skip_metadata(&mut at),
            "FIELD" => {
                at.word();
                grid.arrays(&mut at, None)?;
            }
            "POINTS" => grid.points(&mut at)?,
            "CELLS" => grid.cells(&mut at)?,
            "CELL_TYPES" => grid.types = grid.numbers(&mut at, "the cell types")?,
            // Point data and anything that follows are not needed; cell data only for regions.
            "CELL_DATA" => {
                grid.data(&mut at)?;
                break;
            }
            "POINT_DATA" => {
                if !at.skip_past("CELL_DATA") {
                    break;
                }
                grid.data(&mut at)?;
                break;
            }
            other => return Err(at.syntax("POINTS, CELLS or CELL_TYPES", other)),
        }
    }
    at.binary = binary;
    for (missing, wanted) in [(grid.positions.is_empty(), "POINTS"), (grid.types.is_empty(), "CELL_TYPES")] {
        if missing {
            return Err(at.truncated(wanted));
        }
    }
    grid.into_raw(file)
}

#[derive(Default)]
struct Grid {
    binary: bool,
    positions: Vec<Vec3>,
    /// \[cells + 1\] start of every cell in `nodes`
    offsets: Vec<usize>,
    nodes: Vec<i64>,
    types: Vec<i64>,
    /// Integer arrays of CELL_DATA by name
    tags: BTreeMap<String, Vec<i64>>,
    /// Sentences on parts that are not read
    notes: Vec<String>,
}

impl Grid {
    /// Reads `count` values of VTK's `kind`, which start on the next line, each by `one`.
    fn block<T>(
        &self,
        at: &mut Cursor,
        kind: &str,
        count: usize,
        wanted: &str,
        one: impl Fn(&mut Cursor, Number) -> Result<T, MeshError>,
    ) -> Result<Vec<T>, MeshError> {
        at.line();
        at.binary = self.binary;
        let number = Number::of(kind).ok_or_else(|| at.syntax("a data type", kind))?;
        at.count(count as i64, if self.binary { number.width() } else { 1 }, wanted)?;
        let values = (0..count).map(|_| one(at, number)).collect();
        at.binary = false;
        values
    }

    /// Reads numbers of any kind.
    fn values(&self, at: &mut Cursor, kind: &str, count: usize, wanted: &str) -> Result<Vec<f64>, MeshError> {
        self.block(at, kind, count, wanted, |at, number| match number {
            Number::Float(4) if at.binary => at.float(wanted),
            Number::Unsigned(8) if at.binary => at.long(wanted).map(|v| v as u64 as f64),
            Number::Signed(_) | Number::Unsigned(_) if at.binary => integer(at, number, wanted).map(|v| v as f64),
            _ => at.double(wanted),
        })
    }

    /// Reads integers; a float is an error.
    fn integers(&self, at: &mut Cursor, kind: &str, count: usize, wanted: &str) -> Result<Vec<i64>, MeshError> {
        if let Some(Number::Float(_)) = Number::of(kind) {
            return Err(at.syntax("a data type of integers", kind));
        }
        self.block(at, kind, count, wanted, |at, number| integer(at, number, wanted))
    }

    /// Reads a count on this line, then this number of 4-byte integers.
    fn numbers(&self, at: &mut Cursor, wanted: &str) -> Result<Vec<i64>, MeshError> {
        let count = at.parse(wanted)?;
        self.integers(at, "int", count, wanted)
    }

    fn points(&mut self, at: &mut Cursor) -> Result<(), MeshError> {
        let count: usize = at.parse("the number of points")?;
        let kind = at.word().unwrap_or_default();
        let x = self.values(at, kind, count.saturating_mul(3), "the points")?;
        self.positions = x.chunks_exact(3).map(Vec3::from_column_slice).collect();
        Ok(())
    }

    /// Reads cells. Up to version 4: `CELLS n size`, then n times (count, nodes…). From 5.0: `CELLS n+1 size`, OFFSETS, CONNECTIVITY.
    fn cells(&mut self, at: &mut Cursor) -> Result<(), MeshError> {
        let count: usize = at.parse("the number of cells")?;
        let size: usize = at.parse("the size of the cell list")?;
        if at.peek() == Some("OFFSETS") {
            at.word();
            let kind = at.word().unwrap_or_default();
            let offsets = self.integers(at, kind, count, "the cell offsets")?;
            self.offsets = offsets.into_iter().map(|v| v as usize).collect();
            match at.word() {
                Some("CONNECTIVITY") => {}
                other => return Err(at.syntax("CONNECTIVITY", other.unwrap_or_default())),
            }
            let kind = at.word().unwrap_or_default();
            self.nodes = self.integers(at, kind, size, "the nodes of the cells")?;
            let rising = self.offsets.windows(2).all(|w| w[0] <= w[1]);
            if !rising || self.offsets.last().is_some_and(|&end| end > size) {
                return Err(at.syntax("rising cell offsets", "offsets that do not fit the connectivity"));
            }
            return Ok(());
        }
        let list = self.integers(at, "int", size, "the nodes of the cells")?;
        self.offsets = vec![0];
        let mut rest = &list[..];
        for _ in 0..count {
            let Some((&n, tail)) = rest.split_first() else { return Err(at.truncated("a cell")) };
            let nodes = tail.get(..n as usize).ok_or_else(|| at.truncated("the nodes of a cell"))?;
            self.nodes.extend(nodes);
            self.offsets.push(self.nodes.len());
            rest = &tail[nodes.len()..];
        }
        Ok(())
    }

    /// Reads cell data as far as they are understood. They only name regions, so that reading stops with a note at anything unknown. A file that ends
    /// within them is refused.
    fn data(&mut self, at: &mut Cursor) -> Result<(), MeshError> {
        match self.attributes(at) {
            Err(MeshError::Syntax { found, .. }) if at.peek().is_some() => {
                self.notes.push(format!("data of the cells from \"{found}\" on are not read, and make no regions"));
                Ok(())
            }
            Err(MeshError::Syntax { .. }) => Err(at.truncated("the data of the cells")),
            read => read,
        }
    }

    fn attributes(&mut self, at: &mut Cursor) -> Result<(), MeshError> {
        let count: usize = at.parse("the number of cells with data")?;
        while let Some(keyword) = at.word() {
            match keyword {
                "SCALARS" => self.scalars(at, count)?,
                "FIELD" => {
                    at.word();
                    self.arrays(at, Some(count))?;
                }
                "VECTORS" | "NORMALS" => self.pass_over(at, 3, count)?,
                "TENSORS" => self.pass_over(at, 9, count)?,
                "TENSORS6" => self.pass_over(at, 6, count)?,
                "GLOBAL_IDS" | "PEDIGREE_IDS" => self.pass_over(at, 1, count)?,
                "TEXTURE_COORDINATES" => {
                    at.word();
                    let components = at.parse("the components of texture coordinates")?;
                    let kind = at.word().unwrap_or_default();
                    self.skip(at, kind, [components, count])?;
                }
                "COLOR_SCALARS" => {
                    at.word();
                    let components = at.parse("the components of colours")?;
                    self.skip(at, self.kind_of_colours(), [components, count])?;
                }
                "LOOKUP_TABLE" => {
                    at.word();
                    let colours = at.parse("the size of a table of colours")?;
                    self.skip(at, self.kind_of_colours(), [4, colours])?;
                }
                "METADATA" => skip_metadata(at),
                "POINT_DATA" => break,
                other => return Err(at.syntax("data of cells", other)),
            }
        }
        Ok(())
    }

    /// Skips data that define no region: a name, a type, and `components` values for each of the cells.
    fn pass_over(&self, at: &mut Cursor, components: usize, cells: usize) -> Result<(), MeshError> {
        at.word();
        let kind = at.word().unwrap_or_default();
        self.skip(at, kind, [components, cells])
    }

    /// Skips an array with this number of components and tuples, of numbers, bits or strings.
    fn skip(&self, at: &mut Cursor, kind: &str, [components, tuples]: [usize; 2]) -> Result<(), MeshError> {
        let (count, wanted) = (components.saturating_mul(tuples), "an array");
        match kind {
            "string" => self.skip_strings(at, count, wanted),
            // Eight per byte
            "bit" if self.binary => self.values(at, "unsigned_char", count.div_ceil(8), wanted).map(drop),
            "bit" => self.values(at, "unsigned_char", count, wanted).map(drop),
            _ => self.values(at, kind, count, wanted).map(drop),
        }
    }

    /// Skips strings: one per line in a text file; in a binary file each follows its length, whose first two bits give its number of bytes.
    fn skip_strings(&self, at: &mut Cursor, count: usize, wanted: &str) -> Result<(), MeshError> {
        at.line();
        at.count(count as i64, 1, wanted)?;
        if !self.binary {
            return (0..count).try_for_each(|_| at.line().map(drop).ok_or_else(|| at.truncated(wanted)));
        }
        for _ in 0..count {
            let mut byte = || at.byte(wanted).map(|b| b as u8);
            let first = byte()?;
            let more = [7, 3, 1, 0][usize::from(first >> 6)];
            let length =
                (0..more).try_fold(u64::from(first & 63), |sum, _| byte().map(|b| (sum << 8) | u64::from(b)))?;
            for _ in 0..at.count(i64::try_from(length).unwrap_or(-1), 1, wanted)? {
                at.byte(wanted)?;
            }
        }
        Ok(())
    }

    /// Colours are bytes in a binary file, and fractions of one in a text file.
    fn kind_of_colours(&self) -> &'static str {
        if self.binary { "unsigned_char" } else { "float" }
    }

    fn scalars(&mut self, at: &mut Cursor, count: usize) -> Result<(), MeshError> {
        let line = at.line().unwrap_or_default();
        let mut words = line.split_whitespace();
        let (name, kind) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let components: usize = words.next().and_then(|w| w.parse().ok()).unwrap_or(1);
        if at.peek() == Some("LOOKUP_TABLE") {
            at.word();
            at.word();
        }
        self.tag(at, (name, kind), [components, count], Some(count))
    }

    /// Reads `FIELD name n`, then n times `name components tuples type` and values; arrays are kept if they belong to the cells.
    fn arrays(&mut self, at: &mut Cursor, cells: Option<usize>) -> Result<(), MeshError> {
        let count: usize = at.parse("the number of arrays")?;
        for _ in 0..count {
            let mut name = at.word().unwrap_or_default();
            if name == "METADATA" {
                skip_metadata(at);
                name = at.word().unwrap_or_default();
            }
            let components: usize = at.parse("the components of an array")?;
            let tuples: usize = at.parse("the tuples of an array")?;
            let kind = at.word().unwrap_or_default();
            self.tag(at, (name, kind), [components, tuples], cells)?;
        }
        Ok(())
    }

    /// Reads the values of an array with this number of components and tuples; they are kept if they are one integer per cell.
    fn tag(
        &mut self,
        at: &mut Cursor,
        (name, kind): (&str, &str),
        [components, tuples]: [usize; 2],
        cells: Option<usize>,
    ) -> Result<(), MeshError> {
        let is_integer = matches!(Number::of(kind), Some(Number::Signed(_) | Number::Unsigned(_)));
        if components == 1 && Some(tuples) == cells && is_integer {
            let values = self.integers(at, kind, tuples, "the data of the cells")?;
            self.tags.insert(name.to_string(), values);
            return Ok(());
        }
        self.skip(at, kind, [components, tuples])
    }

    fn into_raw(self, file: &Path) -> Result<RawMesh, MeshError> {
        let mut raw =
            RawMesh { file: file.to_path_buf(), points: self.positions, notes: self.notes, ..RawMesh::default() };
        raw.node_tags = (0..raw.points.len() as u64).collect();
        raw.may_be_free = vec![false; raw.points.len()];
        let cells = self.offsets.len().saturating_sub(1);
        if cells != self.types.len() {
            let fact = format!("{cells} cells but {} cell types", self.types.len());
            return Err(MeshError::Format { file: file.into(), fact, remedy: "write the file again".into() });
        }
        let mut origin = Vec::new(); // cells of the file that have a volume
        for (c, &number) in self.types.iter().enumerate() {
            let nodes = &self.nodes[self.offsets[c]..self.offsets[c + 1]];
            if let Some(&bad) = nodes.iter().find(|&&i| i < 0 || i as usize >= raw.points.len()) {
                let owner = format!("cell {c}");
                return Err(MeshError::UnknownNode { file: file.into(), owner, node: bad });
            }
            let &(_, dim, name) = KINDS.iter().find(|k| k.0 == number).unwrap_or(&(number, 3, "cells of unknown type"));
            let solid = match number {
                10 => Solid::Tet4,
                24 => Solid::Tet10,
                14 => Solid::Pyramid,
                13 => Solid::Wedge,
                11 | 12 => Solid::Hexahedron,
                _ => {
                    let kinds = if dim == 3 { &mut raw.other_volumes } else { &mut raw.other };
                    *kinds.entry(name).or_default() += 1;
                    nodes.iter().for_each(|&i| raw.may_be_free[i as usize] = true);
                    continue;
                }
            };
            if nodes.len() != solid.nodes() {
                let fact = format!("cell {c} has type {number} but {} nodes", nodes.len());
                return Err(MeshError::Format { file: file.into(), fact, remedy: "write the file again".into() });
            }
            let mut nodes: Vec<u32> = nodes.iter().map(|&i| i as u32).collect();
            if number == 11 {
                // The two rows of a voxel have the same direction, the nodes of a hexahedron run around each face
                nodes.swap(2, 3);
                nodes.swap(6, 7);
            }
            raw.push(solid, &nodes, c as u64);
            origin.push(c);
        }
        for (name, values) in self.tags.iter().filter(|(_, values)| values.len() == cells) {
            let mut regions: BTreeMap<i64, Vec<u32>> = BTreeMap::new();
            origin.iter().enumerate().for_each(|(i, &c)| regions.entry(values[c]).or_default().push(i as u32));
            if (2..=MOST_VALUES).contains(&regions.len()) {
                raw.cell_regions.extend(regions.into_iter().map(|(value, cells)| (format!("{name}_{value}"), cells)));
            }
        }
        Ok(raw)
    }
}

/// Skips METADATA (names of components), which end at the next empty line.
fn skip_metadata(at: &mut Cursor) {
    at.line();
    while at.line().is_some_and(|line| !line.trim().is_empty()) {}
}

/// Kinds of numbers in a binary file, with their number of bytes.
#[derive(Clone, Copy)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    /// Returns the kind of number of VTK's data types (`vtktypeint64`: version 5). VTK writes `vtkIdType` as an `int`, whatever its size in memory.
    fn of(kind: &str) -> Option<Self> {
        match kind {
            "char" => Some(Self::Signed(1)),
            "short" => Some(Self::Signed(2)),
            "int" | "vtktypeint32" | "vtkIdType" => Some(Self::Signed(4)),
            "long" | "vtktypeint64" => Some(Self::Signed(8)),
            "unsigned_char" => Some(Self::Unsigned(1)),
            "unsigned_short" => Some(Self::Unsigned(2)),
            "unsigned_int" | "vtktypeuint32" => Some(Self::Unsigned(4)),
            "unsigned_long" | "vtktypeuint64" => Some(Self::Unsigned(8)),
            "float" => Some(Self::Float(4)),
            "double" => Some(Self::Float(8)),
            _ => None,
        }
    }

    fn width(self) -> usize {
        let (Self::Signed(width) | Self::Unsigned(width) | Self::Float(width)) = self;
        width
    }
}

/// Reads an integer of a binary file, or a word of a text file.
fn integer(at: &mut Cursor, number: Number, wanted: &str) -> Result<i64, MeshError> {
    let value = match number.width() {
        1 if at.binary => at.byte(wanted).map(i64::from),
        2 if at.binary => at.short(wanted).map(i64::from),
        4 => at.int(wanted),
        _ => at.long(wanted),
    }?;
    match number {
        Number::Unsigned(8) if at.binary && value < 0 => {
            Err(at.syntax("an integer below 2^63", &(value as u64).to_string()))
        }
        // The bits beyond its width come from sign extension
        Number::Unsigned(width @ 1..8) if at.binary => Ok(value & ((1 << (8 * width)) - 1)),
        _ => Ok(value),
    }
}
