//! Meshes of several bodies: images of a mesh, several meshes side by side, and connected parts.

use crate::math::disjoint_sets::DisjointSets;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::element::CELL_FACES;
use crate::mesh::surface::boundary::sorted;
use crate::mesh::{Region, TetMesh};
use rustc_hash::{FxBuildHasher, FxHashMap};
use std::collections::BTreeMap;

/// Returns the image under X ↦ A X + b with A orthogonal. For a reflection the node order is changed, so that volumes stay positive.
pub fn image(mesh: &TetMesh, a: &Mat3, b: &Vec3) -> TetMesh {
    let mut image = mesh.clone();
    image.points.iter_mut().for_each(|p| *p = a * *p + b);
    if a.determinant() < 0.0 {
        let cells = image.cells.chunks_exact_mut(mesh.order.cell_nodes());
        cells.for_each(|cell| swap(cell, &[(1, 2), (4, 6), (8, 9)]));
        let facets = image.facets.chunks_exact_mut(mesh.order.facet_nodes());
        facets.for_each(|facet| swap(facet, &[(1, 2), (3, 5)]));
    }
    image
}

/// Combines meshes of one order into one. A region R of the mesh named N becomes `N.R`; R itself contains the regions of all meshes.
pub fn side_by_side(named: &[(String, TetMesh)]) -> Option<TetMesh> {
    let mut whole = TetMesh { regions: BTreeMap::new(), ..named.first()?.1.clone() };
    (whole.points, whole.cells, whole.facets) = (Vec::new(), Vec::new(), Vec::new());
    for (name, part) in named {
        let (cells, facets) = (whole.cell_count() as u32, whole.facet_count() as u32);
        let nodes = whole.points.len() as u32;
        for (region, list) in &part.regions {
            let moved = Region {
                cells: list.cells.iter().map(|c| c + cells).collect(),
                facets: list.facets.iter().map(|f| f + facets).collect(),
                nodes: list.nodes.iter().map(|n| n + nodes).collect(),
                is_node_set: list.is_node_set,
                depends_on_mesh: list.depends_on_mesh,
            };
            let all = whole.regions.entry(region.clone()).or_default();
            all.cells.extend(&moved.cells);
            all.facets.extend(&moved.facets);
            // If one part has a node set, the nodes of all are listed explicitly
            all.is_node_set = named.iter().any(|(_, part)| part.regions.get(region).is_some_and(|r| r.is_node_set));
            match all.is_node_set {
                true => all.nodes.extend(part.nodes_of(list).iter().map(|n| n + nodes)),
                false => all.nodes.extend(&moved.nodes),
            }
            all.depends_on_mesh |= moved.depends_on_mesh;
            whole.regions.insert(format!("{name}.{region}"), moved);
        }
        whole.points.extend(&part.points);
        whole.cells.extend(part.cells.iter().map(|n| n + nodes));
        whole.facets.extend(part.facets.iter().map(|n| n + nodes));
    }
    Some(whole)
}

/// Returns the connected part of each cell \[cells\], identified by one of its nodes: cells of one part are joined by common nodes.
pub fn parts(mesh: &TetMesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.points.len());
    for cell in mesh.cells.chunks_exact(mesh.order.cell_nodes()) {
        sets.join(cell);
    }
    mesh.cells.chunks_exact(mesh.order.cell_nodes()).map(|cell| sets.first(cell[0])).collect()
}

/// Returns the part of each cell that is connected by common faces \[cells\], identified by one of its cells: parts with only nodes or edges in
/// common are separate.
pub fn parts_by_faces(mesh: &TetMesh) -> Vec<u32> {
    let cells = mesh.cell_count();
    let mut sets = DisjointSets::new(cells);
    let mut first_cells = FxHashMap::with_capacity_and_hasher(cells * 5 / 2, FxBuildHasher);
    for cell in 0..cells {
        for face in CELL_FACES {
            let key = sorted([0, 1, 2].map(|k| mesh.cell(cell)[face[k]]));
            let first = *first_cells.entry(key).or_insert(cell as u32);
            sets.join(&[first, cell as u32]);
        }
    }
    (0..cells as u32).map(|cell| sets.first(cell)).collect()
}

/// Returns the parts of a mesh that no face joins as separate meshes, without facets and regions; the inverse of [`side_by_side`].
pub fn apart(mesh: &TetMesh) -> Vec<TetMesh> {
    let mut of_part: BTreeMap<u32, (TetMesh, FxHashMap<u32, u32>)> = BTreeMap::new();
    for (part, cell) in parts_by_faces(mesh).into_iter().zip(mesh.cells.chunks_exact(mesh.order.cell_nodes())) {
        let (own, numbers) = of_part.entry(part).or_insert_with(|| {
            let none = TetMesh { points: vec![], cells: vec![], facets: vec![], regions: BTreeMap::new(), ..*mesh };
            (none, FxHashMap::default())
        });
        for node in cell {
            let number = *numbers.entry(*node).or_insert_with(|| {
                own.points.push(mesh.points[*node as usize]);
                own.points.len() as u32 - 1
            });
            own.cells.push(number);
        }
    }
    of_part.into_values().map(|(own, _)| own).collect()
}

/// Exchanges the pairs of positions that exist in the list.
fn swap(list: &mut [u32], pairs: &[(usize, usize)]) {
    let n = list.len();
    pairs.iter().filter(|(_, b)| *b < n).for_each(|&(a, b)| list.swap(a, b));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::made::structured::block;
    use crate::mesh::quality::overlap::overlap_of_parts;

    /// In the region of all parts, a part without a node set contributes the nodes of its facets.
    #[test]
    fn node_sets_stay_sets_of_nodes_in_several_parts() {
        let one = block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear);
        let mut other = one.clone();
        let held = other.regions.get_mut("xmin").expect("a region of blocks");
        held.cells = vec![0];
        (held.nodes, held.is_node_set) = (vec![3], true);
        let facets = one.nodes_of(&one.regions["xmin"]);
        let count = one.points.len() as u32;
        let both = side_by_side(&[("a".into(), one), ("b".into(), other)]).expect("two parts");
        assert_eq!(both.nodes_of(&both.regions["b.xmin"]), [count + 3]);
        assert_eq!(both.nodes_of(&both.regions["xmin"]), [&facets[..], &[count + 3]].concat());
    }

    #[test]
    fn parts_are_taken_apart_and_overlaps_found() {
        let one = block(4, 2, 2, 0.04, 0.02, 0.02, Order::Quadratic);
        let with_another = |x: f64| {
            let other = image(&one, &Mat3::identity(), &Vec3::new(x, 0.0031, 0.0017));
            side_by_side(&[("a".into(), one.clone()), ("b".into(), other)]).expect("two parts")
        };
        let parts = apart(&with_another(0.07));
        assert_eq!(parts.iter().map(TetMesh::cell_count).collect::<Vec<_>>(), [one.cell_count(); 2]);
        assert!(parts.iter().all(|p| (p.volume() / one.volume() - 1.0).abs() < 1e-12));
        let found = |x: f64| overlap_of_parts(&with_another(x));
        assert!(found(0.035).is_some_and(|at| at.x > 0.035 && at.x < 0.04) && found(0.04 - 1e-4).is_some());
        assert_eq!(
            [one.clone(), with_another(0.04), with_another(0.041)].map(|mesh| overlap_of_parts(&mesh)),
            [None; 3]
        );
    }
}
