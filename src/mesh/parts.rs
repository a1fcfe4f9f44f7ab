//! Meshes of several bodies: images of one mesh, several meshes side by side, and which cells hang together.

use super::{Region, TetMesh};
use crate::math::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;

/// The image under X ↦ A X + b, A orthogonal. A mirror image gets the other order of nodes, so that volumes stay positive.
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

/// Meshes of one order as one mesh. A region R of the mesh named N becomes `N.R`; R itself holds those of all.
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
                depends_on_mesh: list.depends_on_mesh,
            };
            let all = whole.regions.entry(region.clone()).or_default();
            all.cells.extend(&moved.cells);
            all.facets.extend(&moved.facets);
            all.nodes.extend(&moved.nodes);
            all.depends_on_mesh |= moved.depends_on_mesh;
            whole.regions.insert(format!("{name}.{region}"), moved);
        }
        whole.points.extend(&part.points);
        whole.cells.extend(part.cells.iter().map(|n| n + nodes));
        whole.facets.extend(part.facets.iter().map(|n| n + nodes));
    }
    Some(whole)
}

/// \[cells\] the part that each belongs to, as a node of it: cells of one part are joined by common nodes.
pub fn parts(mesh: &TetMesh) -> Vec<u32> {
    fn root(parent: &mut [u32], mut k: u32) -> u32 {
        while parent[k as usize] != k {
            parent[k as usize] = parent[parent[k as usize] as usize];
            k = parent[k as usize];
        }
        k
    }
    let mut parent: Vec<u32> = (0..mesh.points.len() as u32).collect();
    for cell in mesh.cells.chunks_exact(mesh.order.cell_nodes()) {
        for &node in &cell[1..] {
            let (a, b) = (root(&mut parent, cell[0]), root(&mut parent, node));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    mesh.cells.chunks_exact(mesh.order.cell_nodes()).map(|cell| root(&mut parent, cell[0])).collect()
}

/// Exchanges the pairs of places that the list has.
fn swap(list: &mut [u32], pairs: &[(usize, usize)]) {
    let n = list.len();
    pairs.iter().filter(|(_, b)| *b < n).for_each(|&(a, b)| list.swap(a, b));
}
