//! Picks nodes, facets or cells by where they are, and finds the separate pieces of a surface.

use super::boundary::boundary_facets;
use super::element::FACET_EDGES;
use super::{Region, TetMesh};
use crate::math::tensor::Vec3;
use std::collections::BTreeMap;

/// Entities of a mesh that can be picked.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pick {
    Nodes,
    /// Of the boundary
    Facets,
    Cells,
}

/// Which facets or cells at the border of a place belong to it. Corners count, not nodes in the middle of edges.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rule {
    /// At least one corner is inside
    Any,
    /// The mean of the corners is inside
    Centroid,
    /// All corners are inside
    All,
}

impl Rule {
    /// Every rule, from the largest region to the smallest.
    pub const EVERY: [Self; 3] = [Self::Any, Self::Centroid, Self::All];

    fn takes(self, mesh: &TetMesh, corners: &[u32], holds: &dyn Fn(&Vec3) -> bool) -> bool {
        let inside = |&k: &u32| holds(&mesh.points[k as usize]);
        match self {
            Self::Any => corners.iter().any(inside),
            Self::All => corners.iter().all(inside),
            Self::Centroid => {
                let sum: Vec3 = corners.iter().map(|&k| mesh.points[k as usize]).sum();
                holds(&(sum / corners.len() as f64))
            }
        }
    }
}

impl Pick {
    /// Every entity of this kind that there is, ascending; facets are those of the boundary.
    pub fn every(self, mesh: &TetMesh) -> Vec<u32> {
        match self {
            Self::Nodes => (0..mesh.points.len() as u32).collect(),
            Self::Facets => boundary_facets(mesh),
            Self::Cells => (0..mesh.cell_count() as u32).collect(),
        }
    }

    /// The entities of this kind at a place, ascending; nodes need no rule.
    pub fn at(self, mesh: &TetMesh, rule: Rule, holds: &dyn Fn(&Vec3) -> bool) -> Vec<u32> {
        let inside = |&k: &u32| match self {
            Self::Nodes => holds(&mesh.points[k as usize]),
            Self::Facets => rule.takes(mesh, &mesh.facet(k as usize)[..3], holds),
            Self::Cells => rule.takes(mesh, &mesh.cell(k as usize)[..4], holds),
        };
        self.every(mesh).into_iter().filter(inside).collect()
    }

    /// The region of these entities.
    pub fn region(self, entities: Vec<u32>, depends_on_mesh: bool) -> Region {
        let region = Region { depends_on_mesh, ..Region::default() };
        match self {
            Self::Nodes => Region { nodes: entities, ..region },
            Self::Facets => Region { facets: entities, ..region },
            Self::Cells => Region { cells: entities, ..region },
        }
    }

    /// Their name in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Facets => "facets",
            Self::Cells => "cells",
        }
    }
}

/// Boundary facets whose outward normal is within `angle` \[rad\] of `direction`.
pub fn facing(mesh: &TetMesh, direction: &Vec3, angle: f64) -> Vec<u32> {
    let least = angle.cos() - 1e-12;
    let facing =
        |f: &u32| mesh.facet_normal(*f as usize, [1.0 / 3.0; 2]).normalize().dot(&direction.normalize()) >= least;
    boundary_facets(mesh).into_iter().filter(facing).collect()
}

/// One piece of the surface of a body, whose facets hang together by edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Ascending
    pub facets: Vec<u32>,
    /// \[m²\]
    pub area: f64,
    /// Volume within, by the flat triangles of the corners; negative around a hollow \[m³\]
    pub volume: f64,
}

/// The pieces of the boundary, the one with the largest area first. Where more than two facets share an edge, the surface is in contact with itself
/// and is not joined there.
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
    // Equal areas keep the order of their first facets
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

fn piece(mesh: &TetMesh, facets: Vec<u32>) -> Piece {
    // From a corner of its own, against rounding far from the origin
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
    use crate::mesh::boundary::add_boundary;
    use crate::mesh::{Order, structured::block};

    /// Two boxes of cells along x: the border of the place cuts the second one.
    #[test]
    fn rules_are_nested_and_count_corners() {
        for order in [Order::Linear, Order::Quadratic] {
            let mesh = block(4, 2, 2, 0.4, 0.2, 0.2, order);
            let holds = |x: &Vec3| x.x <= 0.16;
            let count = |pick: Pick, rule| pick.at(&mesh, rule, &holds).len();
            // Behind x = 0.1 only corners at 0.1 are inside: four boxes of six cells lie before it, four are in contact with it
            assert_eq!(count(Pick::Cells, Rule::All), 24);
            assert_eq!(count(Pick::Cells, Rule::Any), 48);
            let middle = count(Pick::Cells, Rule::Centroid);
            assert!((25..48).contains(&middle), "{middle}");
            let by_hand = (0..mesh.cell_count()).filter(|&c| mesh.position(c, [0.25; 3]).x <= 0.16).count();
            assert_eq!(middle, by_hand);
            let nodes = Pick::Nodes.at(&mesh, Rule::All, &holds).len();
            assert_eq!(nodes, mesh.points.iter().filter(|p| p.x <= 0.16).count());
        }
    }

    #[test]
    fn facets_are_found_by_place_and_by_normal() {
        let mesh = block(4, 2, 2, 0.4, 0.2, 0.2, Order::Quadratic);
        let xmin = &mesh.regions["xmin"].facets;
        assert_eq!(Pick::Facets.at(&mesh, Rule::All, &|x| x.x <= 1e-12), *xmin);
        assert_eq!(Pick::Facets.at(&mesh, Rule::Centroid, &|x| x.x <= 1e-12), *xmin);
        assert!(Pick::Facets.at(&mesh, Rule::Any, &|x| x.x <= 1e-12).len() > xmin.len());
        assert_eq!(facing(&mesh, &Vec3::new(-3.0, 0.0, 0.0), 0.1), *xmin);
    }

    /// A block of 5³ boxes without two of them: one outer piece and two hollows, each of a box.
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
