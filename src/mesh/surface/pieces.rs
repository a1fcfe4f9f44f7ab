//! The separate pieces of the surface of a body.

use super::boundary::boundary_facets;
use crate::mesh::TetMesh;
use crate::mesh::element::FACET_EDGES;
use std::collections::BTreeMap;

/// One piece of the surface of a body, whose facets are connected by edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Facets, in ascending order
    pub facets: Vec<u32>,
    /// \[m²\]
    pub area: f64,
    /// Enclosed volume, computed with the flat triangles of the corners; negative around a hollow \[m³\]
    pub volume: f64,
}

impl Piece {
    /// Whether the piece is the wall of a hollow.
    pub fn is_inner(&self) -> bool {
        self.volume <= 0.0
    }
}

/// Returns the pieces of the boundary, the piece with the largest area first. Where more than two facets share an edge, the surface is in contact
/// with itself and is not joined.
pub fn pieces(mesh: &TetMesh) -> Vec<Piece> {
    let facets = boundary_facets(mesh);
    let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &f in &facets {
        let nodes = mesh.facet(f as usize);
        for [i, j] in FACET_EDGES {
            let ends = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            edges.entry(ends).or_default().push(f);
        }
    }
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for pair in edges.values().filter(|pair| pair.len() == 2) {
        neighbours.entry(pair[0]).or_default().push(pair[1]);
        neighbours.entry(pair[1]).or_default().push(pair[0]);
    }
    let (mut seen, mut found) = (vec![false; mesh.facet_count()], Vec::new());
    for &first in &facets {
        let mut front = vec![first];
        let mut members = Vec::new();
        while let Some(f) = front.pop() {
            if !std::mem::replace(&mut seen[f as usize], true) {
                members.push(f);
                front.extend(neighbours.get(&f).into_iter().flatten());
            }
        }
        if !members.is_empty() {
            members.sort_unstable();
            found.push(piece(mesh, members));
        }
    }
    // Pieces of equal area keep the order of their first facets
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

fn piece(mesh: &TetMesh, facets: Vec<u32>) -> Piece {
    // Relative to one of its corners, to avoid rounding far from the origin
    let origin = mesh.points[mesh.facet(facets[0] as usize)[0] as usize];
    let cone = |&f: &u32| {
        let nodes = mesh.facet(f as usize);
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points[nodes[k] as usize] - origin);
        a.dot(&b.cross(&c)) / 6.0
    };
    let volume = facets.iter().map(cone).sum();
    Piece { area: mesh.region_area(&facets), facets, volume }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::Vec3;
    use crate::mesh::Order;
    use crate::mesh::made::structured::block;
    use crate::mesh::surface::boundary::add_boundary;

    /// A block of 5³ boxes from which two are missing: one outer piece, and two hollows of one box each.
    #[test]
    fn a_hollow_is_a_piece_with_negative_volume() {
        let mut mesh = block(5, 5, 5, 0.5, 0.5, 0.5, Order::Linear);
        let hollow = [Vec3::new(0.15, 0.15, 0.15), Vec3::new(0.35, 0.35, 0.35)];
        let is_solid = |c: &usize| hollow.iter().all(|h| (mesh.position(*c, [0.25; 3]) - h).amax() > 0.05);
        let kept: Vec<u32> = (0..mesh.cell_count()).filter(is_solid).flat_map(|c| mesh.cell(c).to_vec()).collect();
        mesh.cells = kept;
        add_boundary(&mut mesh);
        let found = pieces(&mesh);
        assert_eq!(found.iter().map(|p| p.facets.len()).collect::<Vec<_>>(), [300, 12, 12]);
        assert!((found[0].volume - 0.125).abs() < 1e-12 && (found[0].area - 1.5).abs() < 1e-12);
        for hollow in &found[1..] {
            assert!((hollow.volume + 1e-3).abs() < 1e-12 && (hollow.area - 0.06).abs() < 1e-12);
        }
    }
}
