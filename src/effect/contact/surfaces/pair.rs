//! Geometry of the two surfaces in a state.

use super::candidates::{Pass, least_of_edges, least_of_points, pierced_by_edges};
use super::surface::{Edge, Surface};
use crate::effect::contact::SurfacePoint;
use crate::effect::contact::placement::displacement;
use crate::math::boxes::Span;
use crate::math::nearest::{between, to_triangle};
use crate::math::tensor::Vec3;
use crate::mesh::overlap::pierces;
use crate::system::CacheKey;
use std::collections::BTreeMap;

/// Distance that nodes may move before candidates are searched again, in mean edge lengths \[–\].
const MARGIN: f64 = 0.1;
/// Distance beyond which parts of one surface are not searched for, in mean edge lengths \[–\].
const NEAR: f64 = 10.0;
/// Smallest cosine of the angle between a normal and the inward normal of the part that it faces; the normal of an edge is the mean of its sides
/// \[–\].
const OPPOSED: f64 = 0.5;

/// Two surfaces in contact, or one in contact with itself.
pub struct Surfaces {
    pub name: String,
    pub(super) first: Surface,
    /// `None` for contact of the first with itself
    pub(super) second: Option<Surface>,
    /// \[nodes of the mesh\] X − `centre` \[m\]: far from the origin, differences of positions would lose digits
    pub(super) rest: Vec<Vec3>,
    /// Centre of the nodes of both surfaces; all positions here are relative to it \[m\]
    centre: Vec3,
    /// Pairs that are farther apart do not interact \[m\]
    pub(super) reach: f64,
    /// Motion of a node up to which the candidates remain valid \[m\]
    pub(super) margin: f64,
    /// Nodes of both surfaces, in ascending order
    pub(super) nodes: Vec<u32>,
    pub(super) key: CacheKey,
}

impl Surfaces {
    /// Whether a node belongs to one of the surfaces.
    pub fn have(&self, node: u32) -> bool {
        self.nodes.binary_search(&node).is_ok()
    }

    /// Builds the surfaces of a mesh with nodes at `rest` \[m\].
    pub fn new(name: String, mut first: Surface, mut second: Option<Surface>, mut rest: Vec<Vec3>, reach: f64) -> Self {
        let size = second.as_ref().map_or(f64::INFINITY, |s| s.size(&rest)).min(first.size(&rest));
        let mut nodes: Vec<u32> = first.nodes().chain(second.iter().flat_map(Surface::nodes)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let centre = nodes.iter().map(|&k| rest[k as usize]).sum::<Vec3>() / nodes.len().max(1) as f64;
        rest.iter_mut().for_each(|place| *place -= centre);
        let points = [Some(&mut first), second.as_mut()].into_iter().flatten().flat_map(|s| &mut s.points);
        points.for_each(|point| point.at -= centre);
        Self { name, first, second, rest, centre, reach, margin: MARGIN * size, nodes, key: CacheKey::default() }
    }

    /// The surface whose forces are recorded.
    pub fn first(&self) -> &Surface {
        &self.first
    }

    /// Number of points of both surfaces.
    pub fn point_count(&self) -> usize {
        self.first.points.len() + self.second.as_ref().map_or(0, |s| s.points.len())
    }

    /// Whether this is contact of one surface with itself.
    pub fn is_self_contact(&self) -> bool {
        self.second.is_none()
    }

    /// Whether the two surfaces share nodes.
    pub fn is_joined(&self) -> bool {
        let Some(second) = &self.second else { return true };
        let own: Vec<u32> = self.first.nodes().collect();
        second.nodes().any(|k| own.binary_search(&k).is_ok())
    }

    pub(super) fn passes(&self) -> Vec<Pass<'_>> {
        let pass = |points, triangles| Pass { points, triangles };
        match &self.second {
            None => vec![pass(&self.first, &self.first)],
            Some(second) => vec![pass(&self.first, second), pass(second, &self.first)],
        }
    }

    /// Position of a node at displacement x, relative to the centre \[m\].
    pub(super) fn node(&self, x: &[f64], k: u32) -> Vec3 {
        self.rest[k as usize] + displacement(x, k)
    }

    /// Position of a point at displacement x, relative to the centre \[m\].
    pub(super) fn place(&self, x: &[f64], p: &SurfacePoint) -> Vec3 {
        p.nodes.iter().zip(&p.weights).fold(p.at, |at, (&k, w)| at + displacement(x, k) * *w)
    }

    pub(super) fn displacements(&self, x: &[f64]) -> Vec<Vec3> {
        self.nodes.iter().map(|&k| displacement(x, k)).collect()
    }

    /// Smallest distance \[m\] between parts that share no node, at displacement x; infinite if there are none.
    pub fn gap(&self, x: &[f64]) -> f64 {
        let corners = |pass: &Pass, t: u32| pass.triangles.triangles[t as usize].map(|k| self.node(x, k));
        let ends = |e: &Edge| e.nodes.map(|k| self.node(x, k));
        let of_point = |pass: &Pass, p: &SurfacePoint, t: u32| to_triangle(&self.place(x, p), &corners(pass, t));
        let of_edges = |a: &Edge, b: &Edge| between(&ends(a), &ends(b));
        let (passes, node) = (self.passes(), |k: u32| self.node(x, k));
        let of_points = least_of_points(&passes, f64::INFINITY, &|p| self.place(x, p), &node, &of_point);
        least_of_edges(&passes, of_points, &node, &of_edges)
    }

    /// Smallest distance \[m\] between the surfaces at displacement x. For self-contact, and for surfaces that share nodes, it is the smallest
    /// distance between a point and a triangle that face each other, which excludes neighbours on one face, and at most ten edge lengths.
    pub fn gap_between(&self, x: &[f64]) -> f64 {
        if !self.is_joined() {
            return self.gap(x);
        }
        let passes = self.passes();
        let corners = |t: &[u32; 3]| t.map(|k| self.node(x, k));
        let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - a));
        let mut normals = BTreeMap::<u32, Vec3>::new();
        for t in passes.iter().flat_map(|pass| &pass.points.triangles) {
            t.iter().for_each(|&k| *normals.entry(k).or_default() += normal(corners(t)));
        }
        // A quadrature point has the normal of its facet: the normal of a node on an edge is the mean of its sides
        let outward = |p: &SurfacePoint| match p.nodes[..] {
            [a, b, c, ..] => normal(corners(&[a, b, c])).normalize(),
            _ => p.nodes.iter().zip(&p.weights).map(|(k, w)| normals[k].normalize() * *w).sum(),
        };
        let of_point = |pass: &Pass, p: &SurfacePoint, t: u32| {
            let triangle = corners(&pass.triangles.triangles[t as usize]);
            let (at, against) = (self.place(x, p), normal(triangle));
            let faces = (at - triangle[0]).dot(&against) > 0.0 && outward(p).dot(&against) < -OPPOSED * against.norm();
            if faces { to_triangle(&at, &triangle) } else { f64::INFINITY }
        };
        let most = NEAR * self.margin / MARGIN;
        least_of_points(&passes, most, &|p| self.place(x, p), &|k| self.node(x, k), &of_point)
    }

    /// Returns a position where an edge pierces a triangle at displacement x \[m\].
    pub fn crossing(&self, x: &[f64]) -> Option<Vec3> {
        let passes = self.passes();
        let spot = |at: Vec3| -> Span { (at, at) };
        let node = |k: u32| self.node(x, k);
        let found = pierced_by_edges(&passes, &|k| spot(node(k)));
        found.into_iter().find_map(|(edge, triangle)| {
            let [a, b] = edge.map(node);
            Some(self.centre + a + (b - a) * pierces(&a, &b, &triangle.map(node))?)
        })
    }
}
