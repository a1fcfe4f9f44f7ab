//! The rim of a part of the surface.

use crate::mesh::element::FACET_EDGES;
use crate::mesh::{Order, TetMesh};
use std::collections::BTreeMap;

/// Returns the edges that belong to only one of the facets: two nodes in the orientation of the facet, then the mid-node.
pub fn rim(mesh: &TetMesh, facets: &[u32]) -> Vec<Vec<u32>> {
    let mut edges: BTreeMap<[u32; 2], (usize, Vec<u32>)> = BTreeMap::new();
    for &f in facets {
        let nodes = mesh.facet(f as usize);
        for (e, [i, j]) in FACET_EDGES.into_iter().enumerate() {
            let (a, b) = (nodes[i], nodes[j]);
            let mut own = vec![a, b];
            if mesh.order == Order::Quadratic {
                own.push(nodes[3 + e]);
            }
            edges.entry([a.min(b), a.max(b)]).or_insert((0, own)).0 += 1;
        }
    }
    edges.into_values().filter(|(count, _)| *count == 1).map(|(_, nodes)| nodes).collect()
}
