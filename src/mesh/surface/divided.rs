//! Surfaces subdivided for loads on a mesh: their triangles become about as large as the adjacent facets, or smaller.
//!
//! Where triangles are larger than facets, a load on the vertices acts on points, and the solution has no limit as h → 0. The three edges of such a
//! triangle are bisected, and its neighbours are divided along the bisected edges: flat triangles keep their position, and a closed surface stays
//! closed. The facets of cells that are split into eight are divided in the same way, so that the parts of a triangle that coincided with a facet
//! also coincide with facets.

use super::boundary::boundary_facets;
use super::closed_surface::matched;
use super::distance::Nearest;
use super::flat::{edges, flat_triangles};
use crate::math::tensor::Vec3;
use crate::math::threads;
use crate::mesh::TetMesh;
use crate::mesh::file::surface_file::Surface;
use std::collections::HashMap;

/// Longest edge of a triangle, relative to that of an adjacent facet, above which it is divided \[–\]: in split cells edges are half as long, up to
/// their curvature.
const LARGER: f64 = 1.25;
/// Number of triangles that one thread handles at a time.
const TRIANGLES: usize = 256;
/// Number of triangles above which a surface is not divided further: a surface far from the body may lie entirely next to its smallest facets.
const MOST: usize = 4_000_000;

/// The sizes of the facets of a mesh, searchable by position.
pub struct FacetSizes {
    nearest: Nearest,
    /// \[flat triangles of the boundary\] longest edge \[m\]
    longest: Vec<f64>,
}

impl FacetSizes {
    /// Computes the sizes of the boundary facets; a quadratic facet counts as four.
    ///
    /// # Panics
    /// If the mesh has no cells.
    pub fn new(mesh: &TetMesh) -> Self {
        let triangles = flat_triangles(mesh, &boundary_facets(mesh));
        let surface = Surface { points: mesh.points.clone(), triangles };
        let longest = surface.triangles.iter().map(|t| longest(&corners(&surface, t))).collect();
        Self { nearest: Nearest::new(&surface).expect("a body has a surface"), longest }
    }

    /// Returns the surface divided such that no triangle is larger than the adjacent facets; existing vertices keep their indices.
    pub fn divided(&self, surface: Surface) -> Surface {
        let mut divided = surface;
        while let Some(finer) = self.halved(&divided) {
            divided = finer;
        }
        divided
    }

    /// Returns the surface with the edges of its larger triangles bisected; `None` if no triangle is larger, or if there are too many triangles.
    fn halved(&self, surface: &Surface) -> Option<Surface> {
        let is_larger = |t: &&[u32; 3]| self.is_larger(&corners(surface, t));
        let of_part = |part: &[[u32; 3]]| part.iter().filter(is_larger).copied().collect::<Vec<_>>();
        let larger = threads::map(surface.triangles.chunks(TRIANGLES).collect(), of_part).concat();
        if larger.is_empty() || surface.triangles.len() >= MOST {
            return None;
        }
        let (mut points, mut middles) = (surface.points.clone(), HashMap::new());
        for ([a, b], _) in edges(&larger) {
            middles.insert([a, b], points.len() as u32);
            points.push((points[a as usize] + points[b as usize]) * 0.5);
        }
        let triangles = surface.triangles.iter().flat_map(|t| parts(t, &middles)).collect();
        Some(Surface { points, triangles })
    }

    /// Whether the longest edge is longer than that of the facets at the centre and near the corners.
    fn is_larger(&self, corners: &[Vec3; 3]) -> bool {
        let sum: Vec3 = corners.iter().sum();
        let places = corners.iter().map(|corner| (sum + corner * 3.0) / 6.0).chain([sum / 3.0]);
        let length = longest(corners);
        places.map(|at| self.longest[self.nearest.of(&at).triangle as usize]).any(|of| length > LARGER * of)
    }

    /// Returns the boundary facets on which a surface lies, in ascending order: each triangle, or each of its parts, coincides with a facet.
    /// Otherwise returns the number of triangles that do not.
    pub fn facets_under(&self, mesh: &TetMesh, surface: &Surface, reach: f64) -> Result<Vec<u32>, usize> {
        let (mut loose, mut parts) = (None, surface.clone());
        loop {
            let found = matched(mesh, &parts, reach);
            let missing = found.iter().filter(|facet| facet.is_none()).count();
            if missing == 0 {
                let mut facets: Vec<u32> = found.into_iter().flatten().collect();
                facets.sort_unstable();
                return Ok(facets);
            }
            loose.get_or_insert(missing);
            // If there are more parts than facets, they cannot each coincide with a facet
            match self.halved(&parts).filter(|finer| finer.triangles.len() <= self.longest.len()) {
                Some(finer) => parts = finer,
                None => return Err(loose.unwrap_or(missing)),
            }
        }
    }
}

fn corners(surface: &Surface, triangle: &[u32; 3]) -> [Vec3; 3] {
    triangle.map(|k| surface.points[k as usize])
}

/// Length of the longest edge of a triangle \[m\].
fn longest([a, b, c]: &[Vec3; 3]) -> f64 {
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

/// The parts of a triangle between the midpoints of its bisected edges, with the same orientation.
fn parts(triangle: &[u32; 3], middles: &HashMap<[u32; 2], u32>) -> Vec<[u32; 3]> {
    let middle = |a: u32, b: u32| middles.get(&[a.min(b), a.max(b)]).copied();
    for first in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| triangle[(first + k) % 3]);
        match [middle(a, b), middle(b, c), middle(c, a)] {
            [Some(p), Some(q), Some(r)] => return vec![[a, p, r], [p, b, q], [r, q, c], [p, q, r]],
            [Some(p), Some(q), None] => return vec![[p, b, q], [a, p, q], [a, q, c]],
            [Some(p), None, None] => return vec![[a, p, c], [p, b, c]],
            _ => {}
        }
    }
    vec![*triangle]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::closed_surface::{closed, enclosed};
    use crate::mesh::made::enrich::Enriched;
    use crate::mesh::made::structured::block;

    fn skin_of(mesh: &TetMesh) -> Surface {
        let triangles = boundary_facets(mesh).iter().map(|&f| [0, 1, 2].map(|k| mesh.facet(f as usize)[k])).collect();
        Surface { points: mesh.points.clone(), triangles }
    }

    /// Every facet of a split mesh is a part of a facet of the original mesh.
    #[test]
    fn the_facets_of_split_cells_are_found() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(2, 1, 3, 0.2, 0.3, 0.1, order);
            let surface = skin_of(&mesh);
            for level in 0..3 {
                let found = FacetSizes::new(&mesh).facets_under(&mesh, &surface, 1e-6);
                assert_eq!(found, Ok(boundary_facets(&mesh)), "{order:?}, level {level}");
                mesh = Enriched::by_splitting(&mesh).mesh;
            }
        }
    }

    /// A box of twelve triangles on a mesh that is fine at one end: closed, with the same volume, and nowhere coarser than the facets.
    #[test]
    fn a_coarse_box_is_divided_by_the_facets_next_to_it() {
        let box_of_twelve = skin_of(&block(1, 1, 1, 0.3, 0.2, 0.2, Order::Linear));
        let mut mesh = block(8, 6, 6, 0.3, 0.2, 0.2, Order::Linear);
        mesh.points.iter_mut().for_each(|p| p.x = 0.3 * (p.x / 0.3).powi(2));
        let sizes = FacetSizes::new(&mesh);
        let divided = sizes.divided(box_of_twelve.clone());
        assert_eq!(divided.points[..8], box_of_twelve.points[..]);
        let triangles = closed(&divided).expect("closed");
        assert!((enclosed(&divided.points, &triangles) / 0.012 - 1.0).abs() < 1e-12);
        assert!(divided.triangles.iter().all(|t| !sizes.is_larger(&corners(&divided, t))));
        let at_end = |low: f64| divided.points.iter().filter(|p| (low..low + 0.1).contains(&p.x)).count();
        assert!(at_end(0.0) > at_end(0.2), "{} and {}", at_end(0.0), at_end(0.2));
        assert_eq!(sizes.facets_under(&mesh, &box_of_twelve, 1e-6), Err(12));
    }
}
