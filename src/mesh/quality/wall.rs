//! Cells across the thinnest wall of a body: what a mesh knows of the bending of thin parts.
//!
//! From the middle of every facet of the surface, and of parts of large ones, a ray goes inward to the opposite side; where the two sides face away from each other
//! within 45°, its length is the thickness there. The thinnest wall is where the thickness is within a quarter of the one that a twentieth of the
//! surface is below. There the layers of cells are counted: the least number of edges from a facet to a node of the opposite side,
//! as a mean over the area. A ray that is crossed by cells says less: it crosses three cells of one layer of a grid.
//!
//! Facets held in the direction of their normal (planes of symmetry, plane strain, clamped faces) are no sides of a wall. Notches, a small share of the surface
//! with sides that do not face the opposite one, are in [`super::notch`].

use super::OPPOSITE;
use crate::math::boxes::to_parry;
use crate::math::tensor::Vec3;
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::surface::boundary::boundary_facets;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// Share of the surface that is at most as thick as the thinnest wall \[–\].
pub(crate) const SHARE: f64 = 0.05;
/// Thickness of a facet that belongs to the thinnest wall, over that of the wall \[–\].
pub(crate) const ABOUT: f64 = 1.25;
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
pub(super) struct Side {
    pub corners: [u32; 3],
    pub normal: Vec3,
    pub middle: Vec3,
    /// By which it counts: its area, or the length of an edge
    pub share: f64,
    /// Length of the ray to the opposite side \[m\]
    pub thickness: f64,
}

/// The boundary of a mesh, and which of its facets are sides of walls.
pub(super) struct Skin {
    pub facets: Vec<[u32; 3]>,
    /// \[facets\] twice the area, along the outward normal \[m²\]
    pub normals: Vec<Vec3>,
    /// \[facets\] those not held in the direction of their normal
    pub free: Vec<bool>,
    tree: TriMesh,
}

impl Skin {
    /// None of a mesh without cells.
    pub fn new(mesh: &TetMesh, held: impl Fn(u32, usize) -> bool) -> Option<Self> {
        let facets: Vec<[u32; 3]> =
            boundary_facets(mesh).into_iter().map(|f| std::array::from_fn(|k| mesh.facet(f as usize)[k])).collect();
        let points = mesh.points.iter().map(to_parry).collect();
        let tree = TriMesh::new(points, facets.clone()).ok()?;
        let normals: Vec<Vec3> = facets.iter().map(|t| normal(mesh, t)).collect();
        let is_free = |(t, n): (&[u32; 3], &Vec3)| !t.iter().all(|node| held(*node, n.iamax()));
        let free = facets.iter().zip(&normals).map(is_free).collect();
        Some(Self { facets, normals, free, tree })
    }

    /// Length of the ray from a place of the surface inward along the unit normal n, where it ends at a side that faces the other way; `size` is that of the
    /// part around the place \[m\].
    pub fn thickness(&self, at: &Vec3, n: &Vec3, size: f64) -> Option<f64> {
        // Off the surface itself, by far less than a cell
        let start = at - n * (1e-6 * size);
        let hit =
            self.tree.cast_local_ray_and_get_normal(&Ray::new(to_parry(&start), to_parry(&-n)), f64::MAX, false)?;
        let other = hit.subshape as usize;
        (self.free[other] && self.normals[other].normalize().dot(n) < OPPOSITE).then_some(hit.time_of_impact)
    }
}

/// The mean number of layers of cells across these sides of a wall, by their shares; none where no path leads across.
pub(super) fn mean_layers(mesh: &TetMesh, skin: &Skin, sides: &[Side]) -> Option<f64> {
    let stride = sides.len().div_ceil(SAMPLES).max(1);
    let mut layers = Layers::new(mesh, skin);
    let (mut sum, mut whole) = (0.0, 0.0);
    for side in sides.iter().step_by(stride) {
        if let Some(cells) = layers.across(mesh, side) {
            sum += side.share * cells as f64;
            whole += side.share;
        }
    }
    (whole > 0.0).then(|| sum / whole)
}

/// The thinnest wall of a body; `held` says whether the displacement of a node is prescribed along an axis. None where less than
/// a twentieth of the surface is the side of a wall.
pub fn thinnest(mesh: &TetMesh, held: impl Fn(u32, usize) -> bool) -> Option<Wall> {
    let skin = Skin::new(mesh, held)?;
    let whole: f64 = skin.normals.iter().map(|n| 0.5 * n.norm()).sum();
    let side = |k: usize, (middle, area): (Vec3, f64)| {
        let normal = skin.normals[k].normalize();
        let thickness = skin.thickness(&middle, &normal, area.sqrt())?;
        Some(Side { corners: skin.facets[k], normal, middle, share: area, thickness })
    };
    let chosen: Vec<usize> = (0..skin.facets.len()).filter(|k| skin.free[*k]).collect();
    let rays = threads::map(chosen.chunks(RAYS).collect(), |chunk: &[usize]| {
        let parts = |k: usize| {
            let corners = skin.facets[k].map(|node| mesh.points[node as usize]);
            parts(&corners, whole).into_iter().filter_map(move |part| side(k, part))
        };
        chunk.iter().flat_map(|facet| parts(*facet)).collect::<Vec<_>>()
    });
    let mut sides: Vec<Side> = rays.into_iter().flatten().collect();
    sides.sort_by(|a, b| a.thickness.total_cmp(&b.thickness));
    let mut below = 0.0;
    let thickness = sides.iter().find_map(|s| {
        below += s.share;
        (below >= SHARE * whole).then_some(s.thickness)
    })?;
    let count = sides.partition_point(|s| s.thickness <= ABOUT * thickness);
    let cells = mean_layers(mesh, &skin, &sides[..count])?;
    Some(Wall { thickness, cells })
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
    fn new(mesh: &TetMesh, skin: &Skin) -> Self {
        let mut neighbours = vec![vec![]; mesh.points.len()];
        for (i, j) in mesh.edges().entries().filter(|(i, j)| i != j) {
            neighbours[i].push(j as u32);
            neighbours[j].push(i as u32);
        }
        let mut normals = vec![vec![]; mesh.points.len()];
        for (corners, n) in skin.facets.iter().zip(&skin.normals) {
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
