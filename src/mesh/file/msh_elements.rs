//! Elements that a gmsh file may contain, in its numbering of kinds and nodes.

use super::assemble::{RawFacet, RawMesh};
use super::solid::Solid;
use crate::mesh::error::MeshError;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A kind of element: (gmsh's number, number of nodes, dimension, name).
pub(super) type Kind = (i64, usize, usize, &'static str);

/// Kinds of elements that gmsh may write.
pub(super) const KINDS: &[Kind] = &[
    (15, 1, 0, "points"),
    (1, 2, 1, "lines"),
    (8, 3, 1, "lines"),
    (26, 4, 1, "lines"),
    (2, 3, 2, "triangles"),
    (9, 6, 2, "triangles"),
    (21, 10, 2, "10-node triangles"),
    (3, 4, 2, "quadrangles"),
    (10, 9, 2, "quadrangles"),
    (16, 8, 2, "quadrangles"),
    (4, 4, 3, "4-node tetrahedra"),
    (11, 10, 3, "10-node tetrahedra"),
    (29, 20, 3, "20-node tetrahedra"),
    (5, 8, 3, "8-node hexahedra"),
    (12, 27, 3, "27-node hexahedra"),
    (17, 20, 3, "20-node hexahedra"),
    (6, 6, 3, "6-node prisms"),
    (13, 18, 3, "18-node prisms"),
    (18, 15, 3, "15-node prisms"),
    (7, 5, 3, "5-node pyramids"),
    (14, 14, 3, "14-node pyramids"),
    (19, 13, 3, "13-node pyramids"),
];

/// Returns the kind with this number.
pub(in crate::mesh) fn kind(file: &Path, number: i64) -> Result<&'static Kind, MeshError> {
    KINDS.iter().find(|k| k.0 == number).ok_or_else(|| MeshError::Format {
        file: file.into(),
        fact: format!("element type {number} is not known"),
        remedy: "save tetrahedra of order 1 or 2, or hexahedra, wedges or pyramids of order 1, which split = true of [mesh] divides".into(),
    })
}

/// Names of physical groups by (dimension, tag).
pub(in crate::mesh) type Names = BTreeMap<(usize, i64), String>;

/// Largest number of physical groups of one element or entity. An element is listed in each of its groups, so that memory is the product of both
/// numbers.
const MOST_GROUPS: usize = 256;

/// Refuses an element or entity that is in too many groups.
pub(super) fn check_groups(file: &Path, owner: &str, groups: usize) -> Result<(), MeshError> {
    if groups <= MOST_GROUPS {
        return Ok(());
    }
    let fact = format!("{owner} belongs to {groups} physical groups, and at most {MOST_GROUPS} are read");
    Err(MeshError::Format { file: file.into(), fact, remedy: "save it in fewer".into() })
}

/// Returns the name of a physical group, made from its tag if it has none.
pub(super) fn group_name(names: &Names, dim: usize, tag: i64) -> String {
    let plain = || format!("{}_{tag}", ["point", "curve", "surface", "volume"][dim.min(3)]);
    names.get(&(dim, tag)).cloned().unwrap_or_else(plain)
}

/// Adds an element of this kind with its nodes and regions.
pub(super) fn add_element(raw: &mut RawMesh, kind: &Kind, found: &mut [u32; 27], tag: u64, regions: &Arc<[String]>) {
    let &(number, nodes, dim, name) = kind;
    let solid = match number {
        4 => Solid::Tet4,
        11 => Solid::Tet10,
        7 => Solid::Pyramid,
        6 => Solid::Wedge,
        5 => Solid::Hexahedron,
        2 | 9 | 3 => {
            let corners = found[..if number == 3 { 4 } else { 3 }].to_vec();
            return raw.facets.push(RawFacet { corners, tag, regions: Arc::clone(regions) });
        }
        15 | 1 | 8 | 26 => {
            for region in regions.iter() {
                raw.node_regions.entry(region.clone()).or_default().extend(&found[..nodes]);
            }
            return *raw.other.entry(name).or_default() += 1;
        }
        _ => {
            let kinds = if dim == 3 { &mut raw.other_volumes } else { &mut raw.other };
            return *kinds.entry(name).or_default() += 1;
        }
    };
    if solid == Solid::Tet10 {
        found.swap(8, 9);
    }
    let cell = raw.push(solid, &found[..], tag);
    for name in regions.iter() {
        match raw.cell_regions.get_mut(name) {
            Some(cells) => cells.push(cell),
            None => drop(raw.cell_regions.insert(name.clone(), vec![cell])),
        }
    }
}
