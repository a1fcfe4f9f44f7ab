//! Content of a mesh file as it is: counts, bounds, and the defects that reading would refuse or repair.

use super::format::Reader;
use super::read::raw;
use super::solid::Solid;
use super::validate;
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use crate::mesh::geometry;
use std::collections::BTreeMap;
use std::path::Path;

/// Counts and defects of a mesh file. Lengths are in the unit of the file.
#[derive(Clone, PartialEq, Debug)]
pub struct Census {
    pub nodes: usize,
    /// Number of volume cells of each kind
    pub cells: BTreeMap<&'static str, usize>,
    /// Number of elements without volume of each kind
    pub others: BTreeMap<&'static str, usize>,
    /// Corners of the bounding box of the nodes that belong to cells
    pub bounds: (Vec3, Vec3),
    /// Number of nodes that belong to no cell
    pub unused_nodes: usize,
    /// Number of nodes at the position of another node
    pub doubled_nodes: usize,
    /// Number of cells whose volume has the rarer sign among their kind
    pub inverted_cells: usize,
    /// Whether some cells are hexahedra, wedges or pyramids
    pub divisible: bool,
    /// Whether the tetrahedra have ten nodes
    pub quadratic: bool,
}

/// Examines a file; `name` is used in messages, `path` contains the data.
pub fn census(name: &Path, path: &Path, reader: Reader) -> Result<Census, MeshError> {
    let raw = raw(name, path, reader)?;
    let mut used = vec![false; raw.points.len()];
    raw.cell_nodes.iter().for_each(|&i| used[i as usize] = true);
    if raw.cells.is_empty() {
        // A surface, from which the body is to be meshed
        used.fill(true);
    }
    let finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
    let places: Vec<Vec3> =
        raw.points.iter().zip(&used).filter(|(p, used)| **used && finite(p)).map(|(p, _)| *p).collect();
    let mut others = raw.other.clone();
    for facet in &raw.facets {
        *others.entry(if facet.corners.len() == 3 { "triangles" } else { "quadrangles" }).or_default() += 1;
    }
    let solids: Vec<Solid> = (0..raw.cells.len()).map(|c| raw.solid(c)).collect();
    let mut signs: BTreeMap<Solid, [usize; 2]> = BTreeMap::new();
    for (c, solid) in solids.iter().enumerate() {
        let tets = match solid {
            Solid::Tet4 | Solid::Tet10 => vec![[0, 1, 2, 3].map(|i| raw.nodes(c)[i])],
            _ => solid.divide(raw.nodes(c)),
        };
        let negative = tets.iter().any(|t| raw.volume(t) < 0.0);
        signs.entry(*solid).or_default()[usize::from(negative)] += 1;
    }
    Ok(Census {
        nodes: raw.points.len(),
        cells: raw.kinds(),
        others,
        bounds: if places.is_empty() { Default::default() } else { geometry::bounds(places.iter().copied()) },
        unused_nodes: used.iter().zip(&raw.may_be_free).filter(|(used, free)| !**used && !**free).count(),
        doubled_nodes: if places.is_empty() { 0 } else { validate::doubled(&places).len() },
        inverted_cells: signs.values().map(|[a, b]| *a.min(b)).sum(),
        divisible: solids.iter().any(|s| !matches!(s, Solid::Tet4 | Solid::Tet10)),
        quadratic: solids.contains(&Solid::Tet10),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A surface has bounds, and none of its nodes counts as unused.
    #[test]
    fn a_surface_has_bounds() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("surface.vtk");
        let text = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0  80 0 0  0 20 0  0 0 15\n\
                    CELLS 4 16\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\nCELL_TYPES 4\n5 5 5 5\n";
        std::fs::write(&path, text).expect("writable");
        let found = census(&path, &path, Reader::Vtk).expect("a surface");
        assert_eq!((found.bounds, found.unused_nodes), ((Vec3::zeros(), Vec3::new(80.0, 20.0, 15.0)), 0));
        assert_eq!(found.others, BTreeMap::from([("triangles", 4)]));
    }
}
