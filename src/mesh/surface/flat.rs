//! Facets as flat triangles: a tri3 is one triangle, a tri6 the four between its six nodes.
//!
//! Limits: the distance of a curved facet from its four triangles is up to a quarter of its sagitta.

use crate::mesh::{Order, TetMesh};

/// Indices of the corners in the node list of a facet, oriented as the facet is.
pub fn pieces(order: Order) -> &'static [[usize; 3]] {
    match order {
        Order::Linear => &[[0, 1, 2]],
        Order::Quadratic => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    }
}

/// Returns the nodes of the flat triangles of facets, facet by facet.
pub fn flat_triangles(mesh: &TetMesh, facets: &[u32]) -> Vec<[u32; 3]> {
    let of_facet = |&f: &u32| {
        let nodes = mesh.facet(f as usize);
        pieces(mesh.order).iter().map(|piece| piece.map(|k| nodes[k]))
    };
    facets.iter().flat_map(of_facet).collect()
}

/// Returns the edges of triangles, each once, in ascending order, with the number of triangles to which it belongs.
pub fn edges(triangles: &[[u32; 3]]) -> Vec<([u32; 2], usize)> {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut all: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
}
