//! Cells across the thinnest wall of a body: what a mesh knows of the bending of thin parts.
//!
//! From the middle of every facet of the surface, and of parts of large ones, a ray goes inward to the opposite side; where the two sides face away from each other
//! within 45°, its length is the thickness there. The thinnest wall is where the thickness is within a quarter of the one that a twentieth of the
//! surface is below. There the layers of cells are counted: the least number of edges from a facet to a node of the opposite side,
//! as a mean over the area. A ray that is crossed by cells says less: it crosses three cells of one layer of a grid.
//!
//! Facets held in the direction of their normal (planes of symmetry, plane strain, clamped faces) are no sides of a wall.

use crate::math::boxes::to_parry;
use crate::math::tensor::Vec3;
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::surface::boundary::boundary_facets;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// Share of the surface that is at most as thick as the thinnest wall \[–\].
const SHARE: f64 = 0.05;
/// Thickness of a facet that belongs to the thinnest wall, over that of the wall \[–\].
const ABOUT: f64 = 1.25;
/// Cosine between outward normals of two sides of one wall is below this.
const OPPOSITE: f64 = -std::f64::consts::FRAC_1_SQRT_2;
/// Cells across a wall below which a mesh does not show how it bends.
pub const LEAST_CELLS: f64 = 2.0;
/// Facets at which layers are counted, evenly spread over those of the wall.
const SAMPLES: usize = 200;
/// Parts of the surface from which rays go at least: a facet with a larger share of it is divided.
const PARTS: f64 = 2000.0;
/// Most parts of a side of a facet.
const DIVISIONS: f64 = 12.0;
/// Rays that one thread casts at a time.
const RAYS: usize = 256;

/// The thinnest wall of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// \[m\]
    pub thickness: f64,
    /// Layers of cells across it, mean over its area
    pub cells: f64,
}

/// Whether so many cells across a wall show how it bends. They count as printed, to one decimal.
pub fn shows_bending(cells: f64) -> bool {
    cells >= LEAST_CELLS - 0.05
}

/// One side of a wall.
struct Side {
    corners: [u32; 3],
    normal: Vec3,
    middle: Vec3,
    area: f64,
    /// Length of the ray to the opposite side \[m\]
    thickness: f64,
}

/// The thinnest wall of a body; `held` says whether the displacement of a node is prescribed along an axis. None where less than
/// a twentieth of the surface is the side of a wall.
pub fn thinnest(mesh: &TetMesh, held: impl Fn(u32, usize) -> bool) -> Option<Wall> {
    let facets: Vec<[u32; 3]> =
        boundary_facets(mesh).into_iter().map(|f| std::array::from_fn(|k| mesh.facet(f as usize)[k])).collect();
    let points = mesh.points.iter().map(to_parry).collect();
    let surface = TriMesh::new(points, facets.clone()).ok()?;
    let normals: Vec<Vec3> = facets.iter().map(|t| normal(mesh, t)).collect();
    let is_held = |k: usize| {
        let axis = normals[k].iamax();
        facets[k].iter().all(|node| held(*node, axis))
    };
    let free: Vec<bool> = (0..facets.len()).map(|k| !is_held(k)).collect();
    let whole: f64 = normals.iter().map(|n| 0.5 * n.norm()).sum();
    let side = |k: usize, (middle, area): (Vec3, f64)| {
        let n = normals[k].normalize();
        // Off the facet itself, by far less than a cell
        let start = middle - n * (1e-6 * area.sqrt());
        let hit = surface.cast_local_ray_and_get_normal(&Ray::new(to_parry(&start), to_parry(&-n)), f64::MAX, false)?;
        let other = hit.subshape as usize;
        let is_wall = free[other] && normals[other].normalize().dot(&n) < OPPOSITE;
        is_wall.then_some(Side { corners: facets[k], normal: n, middle, area, thickness: hit.time_of_impact })
    };
    let chosen: Vec<usize> = (0..facets.len()).filter(|k| free[*k]).collect();
    let rays = threads::map(chosen.chunks(RAYS).collect(), |chunk: &[usize]| {
        let parts = |k: usize| {
            let corners = facets[k].map(|node| mesh.points[node as usize]);
            parts(&corners, whole).into_iter().filter_map(move |part| side(k, part))
        };
        chunk.iter().flat_map(|facet| parts(*facet)).collect::<Vec<_>>()
    });
    let mut sides: Vec<Side> = rays.into_iter().flatten().collect();
    sides.sort_by(|a, b| a.thickness.total_cmp(&b.thickness));
    let mut below = 0.0;
    let thickness = sides.iter().find_map(|s| {
        below += s.area;
        (below >= SHARE * whole).then_some(s.thickness)
    })?;
    let count = sides.partition_point(|s| s.thickness <= ABOUT * thickness);
    let stride = count.div_ceil(SAMPLES);
    let mut layers = Layers::new(mesh, &facets, &normals);
    let (mut sum, mut area) = (0.0, 0.0);
    for side in sides[..count].iter().step_by(stride) {
        if let Some(cells) = layers.across(mesh, side) {
            sum += side.area * cells as f64;
            area += side.area;
        }
    }
    (area > 0.0).then(|| Wall { thickness, cells: sum / area })
}

/// Middles and areas of the equal parts of a facet that its share of the `whole` surface asks for \[m, m²\].
fn parts([a, b, c]: &[Vec3; 3], whole: f64) -> Vec<(Vec3, f64)> {
    let area = 0.5 * (b - a).cross(&(c - a)).norm();
    let n = (area / whole * PARTS).sqrt().ceil().clamp(1.0, DIVISIONS);
    let at = |i: f64, j: f64| (a + (b - a) * (i / n) + (c - a) * (j / n), area / (n * n));
    let third = 1.0 / 3.0;
    let rows = || (0..n as u32).map(f64::from);
    let upright = rows().flat_map(|i| rows().map(move |j| (i, j))).filter(|(i, j)| i + j < n);
    let turned = rows().flat_map(|i| rows().map(move |j| (i, j))).filter(|(i, j)| i + j < n - 1.0);
    let upright = upright.map(|(i, j)| at(i + third, j + third));
    upright.chain(turned.map(|(i, j)| at(i + 2.0 * third, j + 2.0 * third))).collect()
}

/// Twice the area of a facet, along its outward normal \[m²\].
fn normal(mesh: &TetMesh, corners: &[u32; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|node| mesh.points[node as usize]);
    (b - a).cross(&(c - a))
}

/// Counts edges between the sides of a wall.
struct Layers {
    /// \[nodes\] Corners that share an edge with a corner
    neighbours: Vec<Vec<u32>>,
    /// \[nodes\] Unit normals of the facets at a node
    normals: Vec<Vec<Vec3>>,
    /// \[nodes\] The last search that came by
    seen: Vec<usize>,
    searches: usize,
}

impl Layers {
    fn new(mesh: &TetMesh, facets: &[[u32; 3]], of_facets: &[Vec3]) -> Self {
        let mut neighbours = vec![vec![]; mesh.points.len()];
        for (i, j) in mesh.edges().entries().filter(|(i, j)| i != j) {
            neighbours[i].push(j as u32);
            neighbours[j].push(i as u32);
        }
        let mut normals = vec![vec![]; mesh.points.len()];
        for (corners, n) in facets.iter().zip(of_facets) {
            corners.iter().for_each(|node| normals[*node as usize].push(n.normalize()));
        }
        Self { neighbours, normals, seen: vec![0; mesh.points.len()], searches: 0 }
    }

    /// Least number of edges from a side to a node of the surface that looks the other way, at least half the thickness behind.
    fn across(&mut self, mesh: &TetMesh, side: &Side) -> Option<usize> {
        self.searches += 1;
        let is_opposite = |node: u32, normals: &[Vec3]| {
            let depth = (side.middle - mesh.points[node as usize]).dot(&side.normal);
            depth > 0.5 * side.thickness && normals.iter().any(|n| n.dot(&side.normal) < OPPOSITE)
        };
        let mut front = side.corners.to_vec();
        front.iter().for_each(|node| self.seen[*node as usize] = self.searches);
        let mut layers = 0;
        while !front.is_empty() {
            if front.iter().any(|node| is_opposite(*node, &self.normals[*node as usize])) {
                return Some(layers);
            }
            layers += 1;
            let mut next = vec![];
            for node in front {
                for &other in &self.neighbours[node as usize] {
                    if self.seen[other as usize] != self.searches {
                        self.seen[other as usize] = self.searches;
                        next.push(other);
                    }
                }
            }
            front = next;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_facet_have_its_area_and_middle() {
        let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 0.0, 1.0), Vec3::new(1.0, 2.0, 2.0)];
        let area = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
        for (whole, count) in [(1e6 * area, 1), (PARTS / 3.9 * area, 4), (area, 144)] {
            let parts = parts(&corners, whole);
            assert_eq!(parts.len(), count);
            let sum: f64 = parts.iter().map(|part| part.1).sum();
            let middle: Vec3 = parts.iter().map(|part| part.0 * (part.1 / sum)).sum();
            assert!((sum / area - 1.0).abs() < 1e-12);
            assert!((middle - corners.iter().sum::<Vec3>() / 3.0).norm() < 1e-12, "{middle}");
        }
    }
}
