//! Flat sides in a row about one axis, as of a prism or of a round body approximated by few facets: the mesh alone does not distinguish the two.

use super::boundary::boundary_facets;
use super::smooth_surface::crease;
use crate::math::disjoint_sets::DisjointSets;
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::element::{FACET_EDGES, FACET_NODES};
use std::collections::{BTreeMap, HashMap};

/// Angle between facets below which they belong to one side \[rad\].
const FLAT: f64 = 1e-3;
/// Angle between sides above which they are those of a block \[rad\]. Five sides around an axis meet at 72°.
const MOST: f64 = 1.31;
/// Relative difference up to which angles and widths of the sides of a row count as equal \[–\].
const ALIKE: f64 = 0.05;
/// Norm of the difference of two unit vectors up to which they count as parallel \[–\].
const PARALLEL: f64 = 0.01;

/// A facet of the boundary, and its normal at an edge.
type FacetNormal = (usize, Vec3);

/// A bend: an edge between two sides.
#[derive(Clone, Copy)]
struct Bend {
    sides: [usize; 2],
    at: Vec3,
    along: Vec3,
    /// Positive if the body is convex there \[rad\]
    angle: f64,
}

impl Bend {
    fn is_like(&self, other: &Self) -> bool {
        is_parallel(self.along, other.along) && (self.angle - other.angle).abs() < ALIKE * self.angle.abs()
    }

    /// Distance between the two lines, which are parallel \[m\].
    fn distance(&self, other: &Self) -> f64 {
        let between = other.at - self.at;
        (between - self.along * between.dot(&self.along)).norm()
    }
}

fn is_parallel(a: Vec3, b: Vec3) -> bool {
    a.cross(&b).norm() < PARALLEL
}

/// Returns the angle \[rad\] at which flat sides meet in a row about one axis, with two or more sides of equal width between two others; `None` if
/// there is no such row. At this angle a smooth surface is taken to end.
pub fn angle_in_row(mesh: &TetMesh) -> Option<f64> {
    let bends = bends(mesh);
    let mut of_sides: BTreeMap<usize, Vec<Bend>> = BTreeMap::new();
    for bend in &bends {
        bend.sides.iter().for_each(|side| of_sides.entry(*side).or_default().push(*bend));
    }
    // Widths of a side between this bend and similar ones
    let widths = |side: &usize, bend: &Bend| -> Vec<f64> {
        let others = of_sides[side].iter().filter(|other| other.sides != bend.sides && other.is_like(bend));
        others.map(|other| bend.distance(other)).collect()
    };
    let is_in_row = |bend: &Bend| {
        let [left, right] = bend.sides.map(|side| widths(&side, bend));
        left.iter().any(|a| right.iter().any(|b| (a - b).abs() < ALIKE * a))
    };
    bends.iter().copied().find(is_in_row).map(|bend| bend.angle.abs())
}

/// Returns the straight edges between flat sides at which the angle is at least that of a crease.
fn bends(mesh: &TetMesh) -> Vec<Bend> {
    let facets = boundary_facets(mesh);
    let normal = |k: usize, at: [f64; 2]| mesh.facet_normal(facets[k] as usize, at).normalize();
    let mut at_edges: HashMap<[u32; 2], Vec<FacetNormal>> = HashMap::new();
    for (k, f) in facets.iter().enumerate() {
        let own = mesh.facet(*f as usize);
        for (e, [i, j]) in FACET_EDGES.into_iter().enumerate() {
            let ends = [own[i].min(own[j]), own[i].max(own[j])];
            at_edges.entry(ends).or_default().push((k, normal(k, FACET_NODES[3 + e])));
        }
    }
    let mut pairs: Vec<([u32; 2], [FacetNormal; 2])> =
        at_edges.into_iter().filter_map(|(ends, two)| Some((ends, <[_; 2]>::try_from(two).ok()?))).collect();
    pairs.sort_unstable_by_key(|(ends, _)| *ends);
    let angle = |[a, b]: &[FacetNormal; 2]| a.1.cross(&b.1).norm().atan2(a.1.dot(&b.1));
    let mut sides = DisjointSets::new(facets.len());
    for (_, two) in pairs.iter().filter(|(_, two)| angle(two) < FLAT) {
        sides.join(&two.map(|(k, _)| k as u32));
    }
    let mut found: BTreeMap<[usize; 2], Option<Bend>> = BTreeMap::new();
    for (ends, two) in pairs.iter().filter(|(_, two)| (crease(mesh.order)..MOST).contains(&angle(two))) {
        let [a, b] = ends.map(|node| mesh.points[node as usize]);
        let mut own = two.map(|(k, _)| sides.first(k as u32) as usize);
        own.sort_unstable();
        let middle =
            |k: usize| mesh.facet(facets[k] as usize)[..3].iter().map(|n| mesh.points[*n as usize]).sum::<Vec3>() / 3.0;
        let is_convex = (middle(two[1].0) - middle(two[0].0)).dot(&two[0].1) < 0.0;
        let angle = if is_convex { angle(two) } else { -angle(two) };
        let bend = Bend { sides: own, at: a, along: (b - a).normalize(), angle };
        let known = found.entry(own).or_insert(Some(bend));
        // A curved edge does not belong to a row
        *known = known.filter(|known| is_parallel(known.along, bend.along));
    }
    found.into_values().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::made::curved::{bracket, cylinder, hole, octant, tube};
    use crate::mesh::made::structured::block;

    /// Prisms of six and eight sides have a row, as does a part of one. Blocks, brackets and round bodies with more facets do not.
    #[test]
    fn sides_in_a_row_are_found() {
        let degrees = |mesh: &TetMesh| angle_in_row(mesh).map(|angle| angle.to_degrees().round());
        let tube = |n: usize, order| tube([1.0, 2.0], 3.0, [1, n, 2], order);
        assert_eq!([5, 6, 8].map(|n| degrees(&tube(n, Order::Linear))), [72.0, 60.0, 45.0].map(Some));
        assert_eq!([4, 9, 16].map(|n| degrees(&tube(n, Order::Linear))), [None; 3]);
        assert_eq!([6, 8].map(|n| degrees(&tube(n, Order::Quadratic))), [None; 2]);
        assert_eq!(degrees(&cylinder(1.0, 2.0, 1, 2, Order::Linear)), Some(60.0));
        let others = [
            block(3, 2, 2, 1.0, 1.0, 1.0, Order::Linear),
            bracket(2.0, 1.0, [2, 1], Order::Linear),
            octant(1.0, 2.0, 3, 2, Order::Linear),
            hole(1.0, 2.0, 0.5, [2, 4, 1], Order::Linear),
            cylinder(1.0, 2.0, 2, 2, Order::Linear),
        ];
        assert!(others.iter().all(|mesh| angle_in_row(mesh).is_none()));
    }

    /// A block with bevels of 45° has sides at equal angles about one axis, with two widths; if all widths are equal, it is a prism of eight sides.
    #[test]
    fn bevels_are_no_row() {
        let bevelled = |bevel: f64| {
            let mut mesh = tube([1.0, 2.0], 3.0, [1, 8, 2], Order::Linear);
            // Corners of the outline of a square of edge 2 with bevels of this size
            let (near, far) = (1.0 - bevel, 1.0);
            let outline = [
                [far, -near],
                [far, near],
                [near, far],
                [-near, far],
                [-far, near],
                [-far, -near],
                [-near, -far],
                [near, -far],
            ];
            for p in &mut mesh.points {
                let k = ((p.y.atan2(p.x) / std::f64::consts::FRAC_PI_4).round() as i64).rem_euclid(8) as usize;
                let r = p.xy().norm();
                (p.x, p.y) = (r * outline[k][0], r * outline[k][1]);
            }
            mesh
        };
        assert!(angle_in_row(&bevelled(0.2)).is_none() && angle_in_row(&bevelled(0.8)).is_none());
        let equal = 2.0 - std::f64::consts::SQRT_2;
        assert!(angle_in_row(&bevelled(equal)).is_some_and(|angle| (angle.to_degrees() - 45.0).abs() < 1e-6));
    }
}
