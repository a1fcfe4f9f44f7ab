//! Narrow gaps between the parts of a body: facets of parts without common faces that face each other at a distance far below their size.
//!
//! From the centre of every facet, the nearest facet that faces it within 45° is searched for. Facets of one part, as in solids that share only some
//! of their facets, count only if they coincide: a slit may be narrow on purpose. Curved facets count as flat triangles.

use super::OPPOSITE;
use crate::math::boxes::{aabb, hierarchy};
use crate::math::nearest::to_triangle;
use crate::math::tensor::Vec3;
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::geometry::bounds;
use crate::mesh::made::parts::parts_by_faces;
use crate::mesh::surface::boundary::facet_cells;
use std::collections::BTreeSet;

/// Distance of two facets relative to the shorter of their mean edges, up to which they may have been meant to coincide \[–\].
const NARROW: f64 = 0.05;
/// Such a distance for two facets of one part, beyond the rounding of coordinates in files \[–\].
const COINCIDENT: f64 = 1e-4;
/// Number of facets that one thread handles at a time.
const FACETS: usize = 256;

/// Summary of all narrow gaps between parts of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Number of pairs of parts; two sides of one part count as a pair
    pub pairs: usize,
    /// Whether the gaps are all between sides of one part, not between different parts
    pub is_within_parts: bool,
    /// Largest distance between two sides \[m\]
    pub distance: f64,
    /// Position at which the distance is largest \[m\]
    pub at: Vec3,
    /// Area of the gaps, the mean of both sides \[m²\]
    pub area: f64,
    /// Distance within which every node of a side has a node of the other side \[m\]; `None` if nodes are not opposite each other
    pub between_nodes: Option<f64>,
}

/// A facet of the boundary.
struct Facet {
    corners: [Vec3; 3],
    middle: Vec3,
    normal: Vec3,
    area: f64,
    edge: f64,
    /// Part to which it belongs, identified by one of its cells
    part: u32,
}

/// A facet together with another facet that it faces.
struct Facing {
    parts: [u32; 2],
    distance: f64,
    at: Vec3,
    area: f64,
    /// Largest distance of its corners from the corners of the facing facet; `None` if a corner is farther away than the width of a narrow gap
    corners: Option<f64>,
}

/// Returns the narrow gaps of a mesh; `None` if its parts are clearly separate, or joined.
pub fn gap(mesh: &TetMesh) -> Option<Gap> {
    let of_cells = parts_by_faces(mesh);
    let outer = facet_cells(mesh).into_iter().enumerate().filter(|(_, (_, is_inside))| !is_inside);
    let facets: Vec<Facet> = outer.map(|(f, (cell, _))| facet(mesh, f, of_cells[cell as usize])).collect();
    let boxes = hierarchy(facets.iter().map(|facet| bounds(facet.corners.iter().copied())));
    let faced = |facet: &Facet| {
        let reach = Vec3::repeat(NARROW * facet.edge);
        let around = aabb((facet.middle - reach, facet.middle + reach));
        let found = boxes.intersect_aabb(&around).filter_map(|k| facing(facet, &facets[k as usize]));
        found.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.parts.cmp(&b.parts)))
    };
    let of_part = |part: &[Facet]| part.iter().filter_map(faced).collect::<Vec<_>>();
    let found: Vec<Facing> = threads::map(facets.chunks(FACETS).collect(), of_part).into_iter().flatten().collect();
    let widest = found.iter().max_by(|a, b| a.distance.total_cmp(&b.distance))?;
    let corners = found.iter().map(|f| f.corners).collect::<Option<Vec<f64>>>();
    Some(Gap {
        pairs: found.iter().map(|f| f.parts).collect::<BTreeSet<_>>().len(),
        is_within_parts: found.iter().all(|f| f.parts[0] == f.parts[1]),
        distance: widest.distance,
        at: widest.at,
        area: 0.5 * found.iter().map(|f| f.area).sum::<f64>(),
        between_nodes: corners.map(|all| all.into_iter().fold(0.0, f64::max)),
    })
}

fn facet(mesh: &TetMesh, f: usize, part: u32) -> Facet {
    let corners: [Vec3; 3] = std::array::from_fn(|k| mesh.points[mesh.facet(f)[k] as usize]);
    let [a, b, c] = corners;
    let twice = (b - a).cross(&(c - a));
    let edge = ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3.0;
    Facet { corners, middle: (a + b + c) / 3.0, normal: twice.normalize(), area: 0.5 * twice.norm(), edge, part }
}

/// Returns the data of two facets if they face each other across a narrow gap.
fn facing(one: &Facet, other: &Facet) -> Option<Facing> {
    let narrow = if one.part == other.part { COINCIDENT } else { NARROW };
    let reach = narrow * one.edge.min(other.edge);
    if one.normal.dot(&other.normal) > OPPOSITE {
        return None;
    }
    let distance = to_triangle(&one.middle, &other.corners);
    let to_corner = |p: &Vec3| other.corners.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
    let corners = one.corners.iter().map(to_corner).fold(0.0, f64::max);
    (distance <= reach).then(|| Facing {
        parts: [one.part.min(other.part), one.part.max(other.part)],
        distance,
        at: one.middle,
        area: one.area,
        corners: Some(corners).filter(|corners| *corners <= reach),
    })
}
