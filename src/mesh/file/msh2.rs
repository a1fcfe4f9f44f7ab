//! Nodes and elements of gmsh's MSH 2.2, text and binary.
//!
//! An element that belongs to several physical groups occurs several times in the file; it is read once, with all its regions.

use super::assemble::RawMesh;
use super::cursor::Cursor;
use super::msh_elements::{Names, add_element, check_groups, group_name, kind};
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use rustc_hash::FxHashMap;

/// An element: its kind, tag, nodes and regions.
struct Element {
    number: i64,
    tag: u64,
    nodes: [u32; 27],
    regions: Vec<String>,
}

/// Reads nodes; `index` becomes the map from tags to positions.
pub(super) fn read_nodes(
    at: &mut Cursor,
    binary: bool,
    raw: &mut RawMesh,
    index: &mut FxHashMap<u64, u32>,
) -> Result<(), MeshError> {
    let value = at.parse("the number of nodes")?;
    begin(at, binary);
    let count = at.count(value, if binary { 28 } else { 7 }, "the nodes")?;
    for _ in 0..count {
        let tag = at.int("a node tag")? as u64;
        if index.insert(tag, raw.node_tags.len() as u32).is_some() {
            return Err(MeshError::NodeTwice { file: raw.file.clone(), node: tag });
        }
        let mut x = [0.0; 3];
        for x in &mut x {
            *x = at.double("a coordinate")?;
        }
        raw.node_tags.push(tag);
        raw.may_be_free.push(false);
        raw.points.push(Vec3::from(x));
    }
    Ok(())
}

/// Reads elements with the names of their groups.
pub(super) fn read_elements(
    at: &mut Cursor,
    binary: bool,
    names: &Names,
    index: &FxHashMap<u64, u32>,
    raw: &mut RawMesh,
) -> Result<(), MeshError> {
    let value = at.parse("the number of elements")?;
    begin(at, binary);
    let count = at.count(value, if binary { 12 } else { 4 }, "the elements")?;
    let mut elements: Vec<Element> = Vec::with_capacity(count);
    let mut known: FxHashMap<(i64, Vec<u32>), usize> = FxHashMap::default();
    let mut read = 0;
    while read < count {
        let block = if binary { Some(block(at)?) } else { None };
        for _ in 0..block.map_or(1, |b| b.count) {
            read += 1;
            let next = |at: &mut Cursor| element(at, block, names, index, raw);
            let element = if binary { next(at) } else { at.whole_line("an element on a line of its own", next) }?;
            let mut key = element.nodes[..kind(&raw.file, element.number)?.1].to_vec();
            key.sort_unstable();
            match known.get(&(element.number, key.clone())) {
                // It is the same element only if its group is different; a cell that occurs twice is an error that is detected later.
                Some(&same) if !element.regions.is_empty() && !elements[same].regions.contains(&element.regions[0]) => {
                    elements[same].regions.extend(element.regions);
                    check_groups(&raw.file, &format!("element {}", element.tag), elements[same].regions.len())?;
                }
                _ => {
                    known.insert((element.number, key), elements.len());
                    elements.push(element);
                }
            }
        }
    }
    for mut element in elements {
        let kind = kind(&raw.file, element.number)?;
        add_element(raw, kind, &mut element.nodes, element.tag, &element.regions.into());
    }
    Ok(())
}

/// Header of a block of a binary file.
#[derive(Clone, Copy)]
struct Block {
    number: i64,
    count: usize,
    tags: usize,
}

fn block(at: &mut Cursor) -> Result<Block, MeshError> {
    let number = at.int("the type of elements")?;
    let (count, tags) = (at.int("the number of elements of a block")?, at.int("the number of tags of an element")?);
    // An element has at least a number and a node: a lower bound of its bytes.
    let count = at.count(count, 8, "the elements of a block")?;
    if count == 0 {
        return Err(at.syntax("a block with elements", "0"));
    }
    Ok(Block { number, count, tags: at.count(tags, 1, "the tags of an element")? })
}

/// Reads the next element, whose kind precedes it in a text file and is given in the header of its block in a binary file.
fn element(
    at: &mut Cursor,
    block: Option<Block>,
    names: &Names,
    index: &FxHashMap<u64, u32>,
    raw: &RawMesh,
) -> Result<Element, MeshError> {
    let tag = at.int("an element tag")? as u64;
    let Block { number, tags, .. } = match block {
        Some(block) => block,
        None => {
            let number = at.int("the type of an element")?;
            let tags = at.int("the number of tags of an element")?;
            Block { number, count: 1, tags: at.count(tags, 1, "the tags of an element")? }
        }
    };
    let &(_, nodes, dim, _) = kind(&raw.file, number)?;
    let mut group = 0;
    for k in 0..tags {
        let value = at.int("a tag of an element")?;
        group = if k == 0 { value.abs() } else { group };
    }
    let mut found = [0u32; 27];
    for i in &mut found[..nodes] {
        let node = at.int("a node of an element")?;
        let unknown = || MeshError::UnknownNode { file: raw.file.clone(), owner: format!("element {tag}"), node };
        *i = *index.get(&(node as u64)).ok_or_else(unknown)?;
    }
    let regions = if group == 0 { vec![] } else { vec![group_name(names, dim, group)] };
    Ok(Element { number, tag, nodes: found, regions })
}

/// Starts the data of a section, which in a binary file follows directly after the end of the line.
fn begin(at: &mut Cursor, binary: bool) {
    if binary {
        at.line();
        at.binary = true;
    }
}
