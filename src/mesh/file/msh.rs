//! Gmsh MSH 4.1, text and binary; 2.2 is read by `msh2` from the same sections.
//!
//! Regions are the physical groups; an unnamed group is called `volume_3` or `surface_3` after its tag, and an entity may belong to several groups.
//! Groups of points and curves contain nodes. Files converted by the mesher list node sets in a separate section, and notes on omitted content.
//! Elements read: triangles and quadrilaterals, tetrahedra of order 1 and 2 (gmsh's last two mid-nodes are VTK's swapped), hexahedra, prisms and
//! pyramids of order 1. A node that belongs to no cell does not count as dropped if gmsh keeps it on a point, curve or surface of the geometry
//! (centres of arcs).

use super::assemble::RawMesh;
use super::cursor::Cursor;
use super::msh_elements::{Names, add_element, check_groups, group_name, kind};
use super::msh2;
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use rustc_hash::FxHashMap;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Physical groups: names by (dimension, tag) and the tags of every entity (dimension, tag).
#[derive(Default)]
struct Groups {
    names: Names,
    of_entity: HashMap<(usize, i64), Vec<i64>>,
}

impl Groups {
    /// Names of the groups to which an entity belongs.
    fn regions(&self, dim: usize, entity: i64) -> Vec<String> {
        let name = |tag: &i64| group_name(&self.names, dim, *tag);
        self.of_entity.get(&(dim, entity)).into_iter().flatten().map(name).collect()
    }
}

/// Parses the bytes of an MSH file (`file` is for messages).
pub(in crate::mesh) fn parse(file: &Path, data: &[u8]) -> Result<RawMesh, MeshError> {
    let mut at = Cursor::new(file, data);
    let mut raw = RawMesh { file: file.to_path_buf(), ..RawMesh::default() };
    let (mut groups, mut index) = (Groups::default(), FxHashMap::default());
    let (mut format, mut nodes, mut elements) = (None::<Head>, false, false);
    loop {
        at.binary = false;
        let Some(section) = at.word() else { break };
        if !section.starts_with('$') {
            return Err(at.syntax("a section such as $Nodes", section));
        }
        if format.is_none() && section != "$MeshFormat" {
            return Err(at.syntax("$MeshFormat", section));
        }
        match section {
            "$MeshFormat" => format = Some(read_format(&mut at, file)?),
            "$PhysicalNames" => read_names(&mut at, &mut groups)?,
            "$MeshgenNodeSets" => raw.node_sets.extend(read_list(&mut at, "node sets")?),
            "$MeshgenNotes" => raw.notes = read_list(&mut at, "notes")?,
            "$Entities" | "$PartitionedEntities" => {
                begin(&mut at, format);
                read_entities(&mut at, section == "$PartitionedEntities", &mut groups)?;
            }
            "$Nodes" => {
                nodes = true;
                match format {
                    Some(Head { binary, old: true }) => msh2::read_nodes(&mut at, binary, &mut raw, &mut index)?,
                    _ => {
                        begin(&mut at, format);
                        read_nodes(&mut at, &mut raw, &mut index)?;
                    }
                }
            }
            "$Elements" if !nodes => return Err(at.syntax("$Nodes before $Elements", section)),
            "$Elements" => {
                elements = true;
                match format {
                    Some(Head { binary, old: true }) => {
                        msh2::read_elements(&mut at, binary, &groups.names, &index, &mut raw)?
                    }
                    _ => {
                        begin(&mut at, format);
                        read_elements(&mut at, &groups, &index, &mut raw)?;
                    }
                }
            }
            other => {
                if !at.skip_past(&format!("$End{}", &other[1..])) {
                    return Err(at.truncated(&format!("$End{}", &other[1..])));
                }
                continue;
            }
        }
        at.binary = false;
        let end = format!("$End{}", &section[1..]);
        match at.word() {
            Some(word) if word == end => {}
            Some(word) => return Err(at.syntax(&end, word)),
            None => return Err(at.truncated(&end)),
        }
    }
    match (format.is_some(), nodes, elements) {
        (true, true, true) => Ok(raw),
        (false, ..) => Err(at.truncated("$MeshFormat")),
        (_, false, _) => Err(at.truncated("$Nodes")),
        _ => Err(at.truncated("$Elements")),
    }
}

/// Starts the data of a section, which in a binary file follows directly after the end of the line.
fn begin(at: &mut Cursor, format: Option<Head>) {
    if format.is_some_and(|head| head.binary) {
        at.line();
        at.binary = true;
    }
}

/// Format of the sections of a file.
#[derive(Clone, Copy)]
struct Head {
    binary: bool,
    /// Whether the version is 2, without entities
    old: bool,
}

/// Returns the format of the file and sets the byte order.
fn read_format(at: &mut Cursor, file: &Path) -> Result<Head, MeshError> {
    let version = at.word().ok_or_else(|| at.truncated("the version"))?.to_string();
    let old = version.starts_with("2.");
    if version != "4.1" && !old {
        let (fact, remedy) = (format!("MSH version {version} is not read"), "write it with gmsh -format msh41".into());
        return Err(MeshError::Format { file: file.to_path_buf(), fact, remedy });
    }
    let binary = at.parse::<u8>("0 (text) or 1 (binary)")? == 1;
    let size: usize = at.parse("the data size")?;
    if binary {
        if size != 8 {
            let fact = format!("binary MSH with {size}-byte numbers");
            let remedy = "write it on a 64-bit system, or as text".to_string();
            return Err(MeshError::Format { file: file.to_path_buf(), fact, remedy });
        }
        at.line();
        at.binary = true;
        match at.int("the number one")? {
            1 => {}
            0x0100_0000 => at.big_endian = true,
            other => return Err(at.syntax("the number one", &other.to_string())),
        }
    }
    Ok(Head { binary, old })
}

fn read_names(at: &mut Cursor, groups: &mut Groups) -> Result<(), MeshError> {
    let count: usize = at.parse("the number of physical names")?;
    for _ in 0..count {
        let dim: usize = at.parse("the dimension of a physical name")?;
        let tag: i64 = at.parse("the tag of a physical name")?;
        groups.names.insert((dim, tag), read_name(at)?);
    }
    Ok(())
}

/// Reads a count, then this number of quoted names or texts, each on its own line after its number.
fn read_list(at: &mut Cursor, wanted: &str) -> Result<Vec<String>, MeshError> {
    let count: usize = at.parse(wanted)?;
    let one = |_| at.parse::<usize>(wanted).and_then(|_| read_name(at));
    (0..count).map(one).collect()
}

/// Reads a quoted name, up to the end of its line.
fn read_name(at: &mut Cursor) -> Result<String, MeshError> {
    let line = at.line().ok_or_else(|| at.truncated("a name"))?.trim();
    let name = line.strip_prefix('"').and_then(|s| s.strip_suffix('"'));
    Ok(name.ok_or_else(|| at.syntax("a name in quotes", line))?.to_string())
}

/// Reads entities, or their parts in the partitions of a mesh, with the physical groups to which they belong.
fn read_entities(at: &mut Cursor, partitioned: bool, groups: &mut Groups) -> Result<(), MeshError> {
    if partitioned {
        at.long("the number of partitions")?;
        let value = at.long("the number of ghost entities")?;
        for _ in 0..at.count(value, 2, "the number of ghost entities")? {
            at.int("the tag of a ghost entity")?;
            at.int("the partition of a ghost entity")?;
        }
    }
    let mut counts = [0; 4];
    for count in &mut counts {
        let value = at.long("the number of entities")?;
        *count = at.count(value, 5, "the number of entities")?;
    }
    for (dim, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = at.int("the tag of an entity")?;
            if partitioned {
                at.int("the dimension of the parent of an entity")?;
                at.int("the parent of an entity")?;
                list(at, "the partitions of an entity")?;
            }
            for _ in 0..if dim == 0 { 3 } else { 6 } {
                at.double("the box of an entity")?;
            }
            let physical = list(at, "the physical tags of an entity")?;
            groups.of_entity.insert((dim, tag), physical.into_iter().map(i64::abs).collect());
            if dim > 0 {
                list(at, "the boundary of an entity")?;
            }
        }
    }
    Ok(())
}

/// Reads a count and this number of 4-byte integers.
fn list(at: &mut Cursor, wanted: &str) -> Result<Vec<i64>, MeshError> {
    let value = at.long(wanted)?;
    let count = at.count(value, 1, wanted)?;
    (0..count).map(|_| at.int(wanted)).collect()
}

/// Reads nodes; `index` becomes the map from tags to positions.
fn read_nodes(at: &mut Cursor, raw: &mut RawMesh, index: &mut FxHashMap<u64, u32>) -> Result<(), MeshError> {
    let value = at.long("the number of node blocks")?;
    let blocks = at.count(value, 7, "the number of node blocks")?;
    for wanted in ["the number of nodes", "the smallest node tag", "the largest node tag"] {
        at.long(wanted)?;
    }
    for _ in 0..blocks {
        let dim = at.int("the dimension of a node block")?;
        at.int("the entity of a node block")?;
        let parametric = at.int("the parametric flag of a node block")? != 0;
        let value = at.long("the number of nodes of a block")?;
        let count = at.count(value, 8, "the nodes of a block")?;
        for _ in 0..count {
            let tag = at.long("a node tag")? as u64;
            if index.insert(tag, raw.node_tags.len() as u32).is_some() {
                return Err(MeshError::NodeTwice { file: raw.file.clone(), node: tag });
            }
            raw.node_tags.push(tag);
            raw.may_be_free.push(dim < 3);
        }
        for _ in 0..count {
            let mut x = [0.0; 3];
            for x in &mut x {
                *x = at.double("a coordinate")?;
            }
            raw.points.push(Vec3::from(x));
            for _ in 0..if parametric { dim } else { 0 } {
                at.double("a parametric coordinate")?;
            }
        }
    }
    Ok(())
}

fn read_elements(
    at: &mut Cursor,
    groups: &Groups,
    index: &FxHashMap<u64, u32>,
    raw: &mut RawMesh,
) -> Result<(), MeshError> {
    let value = at.long("the number of element blocks")?;
    let blocks = at.count(value, 7, "the number of element blocks")?;
    for wanted in ["the number of elements", "the smallest element tag", "the largest element tag"] {
        at.long(wanted)?;
    }
    for _ in 0..blocks {
        at.int("the dimension of an element block")?;
        let entity = at.int("the entity of an element block")?;
        let number = at.int("the type of an element block")?;
        let kind = kind(&raw.file, number)?;
        let &(_, nodes, dim, _) = kind;
        let value = at.long("the number of elements of a block")?;
        let count = at.count(value, 2 * (nodes + 1), "the elements of a block")?;
        let regions: Arc<[String]> = groups.regions(dim, entity).into();
        check_groups(&raw.file, &format!("entity {entity}"), regions.len())?;
        for _ in 0..count {
            let tag = at.long("an element tag")? as u64;
            let mut found = [0u32; 27];
            for i in &mut found[..nodes] {
                let node = at.long("a node of an element")?;
                let unknown =
                    || MeshError::UnknownNode { file: raw.file.clone(), owner: format!("element {tag}"), node };
                *i = *index.get(&(node as u64)).ok_or_else(unknown)?;
            }
            add_element(raw, kind, &mut found, tag, &regions);
        }
    }
    Ok(())
}
