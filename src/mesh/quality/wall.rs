//! Number of cells across the thinnest wall of a body: how well a mesh can represent the bending of thin parts.
//!
//! From the centre of every facet of the surface, and of parts of large facets, a ray is cast inward to the opposite side; if the two sides face away
//! from each other within 45°, its length is the thickness there. The thinnest wall consists of the facets at which the thickness is at most a
//! quarter above its 5 % quantile over the surface. There the layers of cells are counted: the smallest number of edges from a facet to a node of the
//! opposite side, averaged over the area. Counting the cells that a ray crosses would be less meaningful: it crosses three cells in one layer of a
//! grid.
//!
//! Facets held in the direction of their normal (symmetry planes, plane strain, clamped faces) do not count as sides of a wall. For notches, which
//! are a small share of the surface and whose sides do not face the opposite one, see [`super::notch`].

use super::OPPOSITE;
use crate::math::boxes::to_parry;
use crate::math::tensor::Vec3;
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::surface::boundary::boundary_facets;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// Share of the surface with a thickness of at most that of the thinnest wall \[–\].
pub(crate) const SHARE: f64 = 0.05;
/// Largest thickness at a facet of the thinnest wall, relative to that of the wall \[–\].
pub(crate) const ABOUT: f64 = 1.25;
/// Number of cells across a wall below which a mesh cannot represent its bending.
pub const LEAST_CELLS: f64 = 2.0;
/// Number of facets at which layers are counted, evenly distributed over those of the wall.
const SAMPLES: usize = 200;
/// Smallest number of parts of the surface from which rays are cast: a facet with a larger share of the surface is divided.
const PARTS: f64 = 2000.0;
/// Largest number of divisions of a side of a facet.
const DIVISIONS: f64 = 12.0;
/// Number of rays that one thread casts at a time.
const RAYS: usize = 256;

/// The thinnest wall of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// \[m\]
    pub thickness: f64,
    /// Number of layers of cells across it, averaged over its area
    pub cells: f64,
}

/// Whether this number of cells across a wall is enough to represent its bending. It is compared as printed, to one decimal.
pub fn shows_bending(cells: f64) -> bool {
    cells >= LEAST_CELLS - 0.05
}

/// One side of a wall.
pub(super) struct Side {
    pub corners: [u32; 3],
    pub normal: Vec3,
    pub middle: Vec3,
    /// Weight of the side: its area, or the length of an edge
    pub share: f64,
    /// Length of the ray to the opposite side \[m\]
    pub thickness: f64,
}

/// The boundary of a mesh, and which of its facets are sides of walls.
pub(super) struct Skin {
    pub facets: Vec<[u32; 3]>,
    /// \[facets\] twice the area, along the outward normal \[m²\]
    pub normals: Vec<Vec3>,
    /// \[facets\] whether it is not held in the direction of its normal
    pub free: Vec<bool>,
    tree: TriMesh,
}

impl Skin {
    /// Builds the skin; `None` for a mesh without cells.
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

    /// Returns the length of the ray from a position on the surface inward along the unit normal n, if it ends at a side that faces the opposite
    /// direction; `size` is the size of the part around the position \[m\].
    pub fn thickness(&self, at: &Vec3, n: &Vec3, size: f64) -> Option<f64> {
        // Start just below the surface, by far less than a cell
        let start = at - n * (1e-6 * size);
        let hit =
            self.tree.cast_local_ray_and_get_normal(&Ray::new(to_parry(&start), to_parry(&-n)), f64::MAX, false)?;
        let other = hit.subshape as usize;
        (self.free[other] && self.normals[other].normalize().dot(n) < OPPOSITE).then_some(hit.time_of_impact)
    }
}

/// Returns the mean number of layers of cells across these sides of a wall, weighted by their shares; `None` if no path leads across.
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

/// Returns the thinnest wall of a body; `held` says whether the displacement of a node is prescribed along an axis. `None` if less than a twentieth
/// of the surface is the side of a wall.
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

/// Returns the centres \[m\] and areas \[m²\] of the equal parts into which a facet is divided according to its share of the `whole` surface.
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

/// Counts layers of edges between the sides of a wall.
struct Layers {
    /// \[nodes\] corners that share an edge with a corner
    neighbours: Vec<Vec<u32>>,
    /// \[nodes\] unit normals of the facets at a node
    normals: Vec<Vec<Vec3>>,
    /// \[nodes\] the last search that visited the node
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

    /// Returns the smallest number of edges from a side to a surface node that faces the opposite direction, at a depth of at least half of the
    /// thickness.
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
