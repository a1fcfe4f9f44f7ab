//! Choice of the nodes at which an imported body is held: a region of the file whose name says so, otherwise a flat end of each component, otherwise its wide
//! end.
//!
//! A flat end is bounded by edges of cells on every mesh; a slab of a body without a flat end is bounded within cells.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::boundary::boundary_facets;
use std::collections::{BTreeMap, BTreeSet};

/// Parts of names of regions that suggest where a robot is held.
const HOLDS: [&str; 10] = ["fix", "root", "base", "held", "clamp", "ground", "bottom", "mount", "encastre", "support"];
/// Largest share of the nodes that a region may hold and still be taken for a fixture.
const MOST: f64 = 0.5;
/// Thickness of the slab that is held, relative to the length of the component.
const SLAB: f64 = 0.05;
/// Distance, relative to the size of a component, within which facets of a flat end lie in one plane.
const FLAT: f64 = 1e-5;
/// Smallest area of a flat end, relative to the rectangle around the component in that direction.
const LEAST_AREA: f64 = 0.02;
/// Relative difference below which areas are equal \[–\]
const EQUAL: f64 = 1e-6;
/// The part of an imported body that is held.
pub enum Fixture {
    /// A region of the file
    Region(String),
    /// A slab at the end of each component
    Slabs(Vec<Slab>),
}

/// The box that contains the held end of a component.
pub struct Slab {
    /// Lower and upper corner \[m\]
    pub low: Vec3,
    pub high: Vec3,
    /// Axis along which the end is one of the two
    pub axis: usize,
    /// Whether the box contains exactly a flat end; otherwise the component has none
    pub flat: bool,
}

impl Slab {
    /// A name for the end of the body, such as `the larger flat end along z`.
    pub fn end(&self) -> String {
        let kind = if self.flat { "larger flat" } else { "wider" };
        format!("the {kind} end along {}", ["x", "y", "z"][self.axis])
    }
}

/// A region whose name suggests that the body is held there and that contains nodes of all components; otherwise slabs at ends. `of_cells` are the components
/// from [`crate::mesh::parts::parts`].
pub(in crate::scene) fn fixture(mesh: &TetMesh, of_cells: &[u32]) -> Fixture {
    let mut component = vec![0u32; mesh.points.len()];
    let mut nodes: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (c, &part) in of_cells.iter().enumerate() {
        mesh.cell(c).iter().for_each(|&i| component[i as usize] = part);
    }
    component.iter().enumerate().for_each(|(i, &part)| nodes.entry(part).or_default().push(i as u32));
    for word in HOLDS {
        for (name, region) in mesh.regions.iter().filter(|(name, _)| name.to_lowercase().contains(word)) {
            let inside = mesh.nodes_of(region);
            let reached: BTreeSet<u32> = inside.iter().map(|&i| component[i as usize]).collect();
            if reached.len() == nodes.len()
                && (inside.len() as f64) < MOST * mesh.points.len() as f64
                && inside.len() > 2
            {
                return Fixture::Region(name.clone());
            }
        }
    }
    let skin = boundary_facets(mesh);
    let is_of = |part: u32, corners: &[u32; 3]| component[corners[0] as usize] == part;
    let of =
        |part: u32| -> Vec<[u32; 3]> { skin.iter().map(|&f| corners(mesh, f)).filter(|c| is_of(part, c)).collect() };
    let end = |(part, nodes): (&u32, &Vec<u32>)| flat_end(mesh, &of(*part), nodes).unwrap_or_else(|| slab(mesh, nodes));
    Fixture::Slabs(nodes.iter().map(end).collect())
}

/// The corners of a facet.
fn corners(mesh: &TetMesh, facet: u32) -> [u32; 3] {
    let nodes = mesh.facet(facet as usize);
    [nodes[0], nodes[1], nodes[2]]
}

/// The larger flat end of a component along the longest axis that has one.
fn flat_end(mesh: &TetMesh, facets: &[[u32; 3]], nodes: &[u32]) -> Option<Slab> {
    let (low, high) = bounds(mesh, nodes);
    let size = high - low;
    let depth = FLAT * size.norm();
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| size[*b].total_cmp(&size[*a]));
    let flat_area = |axis: usize, at: f64| -> f64 {
        let points = facets.iter().map(|corners| corners.map(|k| mesh.points[k as usize]));
        let flat = points.filter(|points| points.iter().all(|p| (p[axis] - at).abs() <= depth));
        flat.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
    };
    axes.into_iter().find_map(|axis| {
        let [at_low, at_high] = [low[axis], high[axis]].map(|at| flat_area(axis, at));
        let around = size.product() / size[axis];
        (at_low.max(at_high) > LEAST_AREA * around).then(|| {
            let (mut a, mut b) = with_margin(low, high);
            // Of two ends whose areas differ only by rounding, the lower one is taken
            let at = if at_high > at_low * (1.0 + EQUAL) { high[axis] } else { low[axis] };
            (a[axis], b[axis]) = (at - depth, at + depth);
            Slab { low: a, high: b, axis, flat: true }
        })
    })
}

/// Lower and upper corner of the box around nodes.
fn bounds(mesh: &TetMesh, nodes: &[u32]) -> (Vec3, Vec3) {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    nodes.iter().map(|i| mesh.points[*i as usize]).fold(start, |(a, b), p| (a.inf(&p), b.sup(&p)))
}

/// The box enlarged by a margin, because its text is rounded.
fn with_margin(low: Vec3, high: Vec3) -> (Vec3, Vec3) {
    let margin = Vec3::repeat(1e-4 * (high - low).norm());
    (low - margin, high + margin)
}

/// The end of a component along its longest axis that has more nodes, which is its widest one. It contains at least three nodes that span a plane.
fn slab(mesh: &TetMesh, nodes: &[u32]) -> Slab {
    let at = |i: &u32| mesh.points[*i as usize];
    let (low, high) = bounds(mesh, nodes);
    let size = high - low;
    let axis = size.imax();
    let mut share = SLAB;
    loop {
        let depth = share * size[axis];
        let first: Vec<Vec3> = nodes.iter().map(at).filter(|p| p[axis] <= low[axis] + depth).collect();
        let last: Vec<Vec3> = nodes.iter().map(at).filter(|p| p[axis] >= high[axis] - depth).collect();
        let (inside, at_low) = if first.len() >= last.len() { (first, true) } else { (last, false) };
        if share > 0.5 || spans_a_plane(&inside) {
            let (mut a, mut b) = with_margin(low, high);
            match at_low {
                true => b[axis] = low[axis] + depth,
                false => a[axis] = high[axis] - depth,
            }
            return Slab { low: a, high: b, axis, flat: false };
        }
        share *= 1.5;
    }
}

/// Whether the points contain three that do not lie on one line.
fn spans_a_plane(points: &[Vec3]) -> bool {
    let Some(first) = points.first() else { return false };
    let far = points.iter().max_by(|a, b| (*a - first).norm().total_cmp(&(*b - first).norm())).expect("not empty");
    let along = far - first;
    points.iter().any(|p| (p - first).cross(&along).norm() > 0.05 * along.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;

    /// A block is held at one of its ends, whatever its mesh; a block whose ends are pulled to a wedge is held at a flat side.
    #[test]
    fn a_flat_end_is_held_and_nothing_else() {
        for divisions in [4, 7] {
            let mut mesh = block(divisions, 2, 2, 0.4, 0.2, 0.1, Order::Linear);
            let one = vec![0; mesh.cell_count()];
            let slab = |mesh: &TetMesh| match fixture(mesh, &one) {
                Fixture::Slabs(mut slabs) => slabs.remove(0),
                Fixture::Region(name) => panic!("{name}"),
            };
            mesh.regions.clear();
            let inside = |mesh: &TetMesh, s: &Slab| {
                mesh.points.iter().filter(|p| (0..3).all(|d| p[d] >= s.low[d] && p[d] <= s.high[d])).count()
            };
            let end = slab(&mesh);
            assert!(end.flat && end.axis == 0 && inside(&mesh, &end) == 9, "{}", inside(&mesh, &end));
            mesh.points.iter_mut().for_each(|p| p.x += 0.4 * (p.x - 0.2) * p.z / 0.1);
            let side = slab(&mesh);
            assert!(side.flat && side.axis == 1 && inside(&mesh, &side) == 3 * (divisions + 1));
        }
    }
}
