//! Selects nodes, facets or cells by their position.

use super::surface::boundary::boundary_facets;
use super::{Region, TetMesh};
use crate::math::tensor::Vec3;

/// Kinds of mesh entities that can be selected.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pick {
    Nodes,
    /// Facets of the boundary
    Facets,
    Cells,
}

/// Rule for facets or cells at the border of a region of space. Only corners count, not mid-edge nodes.
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
    /// All rules, from the largest region to the smallest.
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
    /// Returns all entities of this kind in ascending order; facets are those of the boundary.
    pub fn every(self, mesh: &TetMesh) -> Vec<u32> {
        match self {
            Self::Nodes => (0..mesh.points.len() as u32).collect(),
            Self::Facets => boundary_facets(mesh),
            Self::Cells => (0..mesh.cell_count() as u32).collect(),
        }
    }

    /// Returns the entities of this kind whose positions satisfy `holds`, in ascending order; nodes need no rule.
    pub fn at(self, mesh: &TetMesh, rule: Rule, holds: &dyn Fn(&Vec3) -> bool) -> Vec<u32> {
        let inside = |&k: &u32| match self {
            Self::Nodes => holds(&mesh.points[k as usize]),
            Self::Facets => rule.takes(mesh, &mesh.facet(k as usize)[..3], holds),
            Self::Cells => rule.takes(mesh, &mesh.cell(k as usize)[..4], holds),
        };
        self.every(mesh).into_iter().filter(inside).collect()
    }

    /// Builds the region of these entities.
    pub fn region(self, entities: Vec<u32>, depends_on_mesh: bool) -> Region {
        let region = Region { depends_on_mesh, ..Region::default() };
        match self {
            Self::Nodes => Region { nodes: entities, ..region },
            Self::Facets => Region { facets: entities, ..region },
            Self::Cells => Region { cells: entities, ..region },
        }
    }

    /// Name of the kind in messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Facets => "facets",
            Self::Cells => "cells",
        }
    }
}

/// Returns the boundary facets whose outward normal is within `angle` \[rad\] of `direction`.
pub fn facing(mesh: &TetMesh, direction: &Vec3, angle: f64) -> Vec<u32> {
    let least = angle.cos() - 1e-12;
    let facing =
        |f: &u32| mesh.facet_normal(*f as usize, [1.0 / 3.0; 2]).normalize().dot(&direction.normalize()) >= least;
    boundary_facets(mesh).into_iter().filter(facing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::made::structured::block;

    /// Two boxes of cells along x: the border of the selection cuts the second one.
    #[test]
    fn rules_are_nested_and_count_corners() {
        for order in [Order::Linear, Order::Quadratic] {
            let mesh = block(4, 2, 2, 0.4, 0.2, 0.2, order);
            let holds = |x: &Vec3| x.x <= 0.16;
            let count = |pick: Pick, rule| pick.at(&mesh, rule, &holds).len();
            // Beyond x = 0.1 only corners at 0.1 are inside: four boxes of six cells lie before it, four adjoin it
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
}
