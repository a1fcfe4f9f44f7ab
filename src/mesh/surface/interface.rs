//! Interfaces: the facets between cells of different solids.

use super::boundary::{push_facet, sorted};
use crate::mesh::TetMesh;
use crate::mesh::element::{CELL_FACES, FACET_NODES};
use rustc_hash::FxHashMap;

/// A facet between two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Index of the facet in the mesh
    pub facet: u32,
    /// Whether its normal points into the solid with the smaller index
    pub is_reversed: bool,
}

/// Returns the facets between cells of different solids, whose indices are given in `solids` \[cells\]. Facets that the mesh lacks are appended.
pub fn interfaces(mesh: &mut TetMesh, solids: &[u32]) -> Vec<Interface> {
    let corners = |nodes: &[u32]| sorted([nodes[0], nodes[1], nodes[2]]);
    let known: FxHashMap<[u32; 3], u32> = (0..mesh.facet_count()).map(|f| (corners(mesh.facet(f)), f as u32)).collect();
    let mut open: FxHashMap<[u32; 3], (u32, u8)> = FxHashMap::default();
    let mut found = Vec::new();
    for c in 0..mesh.cell_count() {
        for (k, face) in CELL_FACES.iter().enumerate() {
            let key = sorted([0, 1, 2].map(|i| mesh.cell(c)[face[i]]));
            match open.remove(&key) {
                None => {
                    open.insert(key, (c as u32, k as u8));
                }
                Some((other, place)) if solids[other as usize] != solids[c] => {
                    found.push((key, other, place, solids[other as usize] < solids[c]));
                }
                Some(_) => {}
            }
        }
    }
    let of_face = |(key, cell, place, is_smaller): ([u32; 3], u32, u8, bool)| {
        let facet = known.get(&key).copied().unwrap_or_else(|| push_facet(mesh, cell, place));
        let opposite = mesh.cell(cell as usize)[..4].iter().find(|node| !key.contains(node)).expect("four corners");
        let away = mesh.points[key[0] as usize] - mesh.points[*opposite as usize];
        let leaves_cell = mesh.facet_normal(facet as usize, FACET_NODES[0]).dot(&away) > 0.0;
        Interface { facet, is_reversed: leaves_cell != is_smaller }
    };
    found.into_iter().map(of_face).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::made::structured::block;

    /// The plane between two halves has each facet once, whether or not the mesh had it and however it was oriented, all with one orientation.
    #[test]
    fn a_plane_between_two_halves_is_found() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(4, 2, 3, 4.0, 2.0, 3.0, order);
            let facets = mesh.facet_count();
            let solids: Vec<u32> =
                (0..mesh.cell_count()).map(|c| u32::from(mesh.position(c, [0.25; 3]).x < 2.0)).collect();
            let area = |mesh: &TetMesh, found: &[Interface]| -> f64 {
                let of = |one: &Interface| {
                    let normal = 0.5 * mesh.facet_normal(one.facet as usize, [1.0 / 3.0; 2]);
                    if one.is_reversed { -normal.x } else { normal.x }
                };
                found.iter().map(of).sum()
            };
            let found = interfaces(&mut mesh, &solids);
            assert_eq!((found.len(), mesh.facet_count()), (12, facets + 12));
            // From x > 2, which has the smaller index, to x < 2
            assert!((area(&mesh, &found) + 6.0).abs() < 1e-12);
            let turned: Vec<u32> =
                [1, 0, 2, 3, 5, 4][..order.facet_nodes()].iter().map(|&k| mesh.facet(facets)[k]).collect();
            mesh.facets[facets * turned.len()..][..turned.len()].copy_from_slice(&turned);
            let again = interfaces(&mut mesh, &solids);
            assert_eq!(mesh.facet_count(), facets + 12);
            assert_ne!(again[0], found[0]);
            assert!((area(&mesh, &again) + 6.0).abs() < 1e-12);
            assert!(interfaces(&mut mesh, &vec![0; solids.len()]).is_empty());
        }
    }
}
