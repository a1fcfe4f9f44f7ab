//! A surface of flat triangles with the points that carry pressure, and its connectivity.

use crate::effect::contact::{Sampling, SurfacePoint, points};
use crate::math::tensor::Vec3;
use crate::mesh::flat::edges;
use crate::mesh::flat::flat_triangles;
use crate::mesh::{Order, TetMesh};
use std::collections::BTreeMap;

/// Areas of the nodes of curved facets as guards, relative to their area, where the surface is flat and where it is sharp \[–\].
const FLAT: f64 = 1e-3;
const SHARP: f64 = 0.1;

/// An edge of flat triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    pub nodes: [u32; 2],
    /// A third of the area of its triangles \[m²\]
    pub area: f64,
    /// 0 if its triangles are coplanar at rest, 1 from a right angle on, and if it has only one triangle \[–\]
    pub sharp: f64,
}

/// The surface of some facets of a mesh.
pub struct Surface {
    pub points: Vec<SurfacePoint>,
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<Edge>,
    /// Triangles at each edge, and around each node
    sides: BTreeMap<[u32; 2], Vec<u32>>,
    stars: BTreeMap<u32, Vec<u32>>,
}

impl Surface {
    pub fn new(mesh: &TetMesh, facets: &[u32]) -> Self {
        let triangles = flat_triangles(mesh, facets);
        let (mut sides, mut stars) = (BTreeMap::<[u32; 2], Vec<u32>>::new(), BTreeMap::<u32, Vec<u32>>::new());
        for (t, &[a, b, c]) in (0..).zip(&triangles) {
            for [i, j] in [[a, b], [b, c], [c, a]] {
                sides.entry([i.min(j), i.max(j)]).or_default().push(t);
            }
            [a, b, c].iter().for_each(|&k| stars.entry(k).or_default().push(t));
        }
        let normal = |t: &u32| {
            let [a, b, c] = triangles[*t as usize].map(|k| mesh.points[k as usize]);
            0.5 * (b - a).cross(&(c - a))
        };
        let edge = |(nodes, _)| {
            let normals: Vec<Vec3> = sides[&nodes].iter().map(normal).collect();
            let sharp = match normals[..] {
                [a, b] => (1.0 - a.dot(&b) / (a.norm() * b.norm())).clamp(0.0, 1.0),
                _ => 1.0,
            };
            Edge { nodes, area: normals.iter().map(Vec3::norm).sum::<f64>() / 3.0, sharp }
        };
        let edges: Vec<Edge> = edges(&triangles).into_iter().map(edge).collect();
        let mut points = points(mesh, facets, Sampling::Pressures);
        if mesh.order == Order::Quadratic {
            let mut sharp = BTreeMap::<u32, f64>::new();
            for (k, e) in edges.iter().flat_map(|e| e.nodes.map(|k| (k, e))) {
                let known = sharp.entry(k).or_default();
                *known = known.max(e.sharp);
            }
            for point in &mut points {
                let Some(at) = point.weights.iter().position(|w| *w == 1.0) else { continue };
                let node = point.nodes[at];
                let area = stars[&node].iter().map(|t| normal(t).norm()).sum::<f64>() / 3.0;
                point.area = area * (FLAT + (SHARP - FLAT) * sharp[&node]);
            }
        }
        Self { points, triangles, edges, sides, stars }
    }

    /// Nodes, in ascending order.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.stars.keys().copied()
    }

    /// Number of triangles at an edge that share no node with `own`.
    pub fn at_side(&self, side: &[u32; 2], own: &[u32]) -> usize {
        self.apart_from(&self.sides[side], own)
    }

    /// Returns 1 − n + m, with n the number of triangles at a corner that share no node with `own` and m the number of edges at which these meet
    /// there. This is 0 for an open fan and 1 for a closed one.
    pub fn closes(&self, corner: u32, own: &[u32]) -> i32 {
        let star = &self.stars[&corner];
        let others = star.iter().flat_map(|&t| self.triangles[t as usize]).filter(|&k| k != corner);
        let mut others: Vec<u32> = others.collect();
        others.sort_unstable();
        others.dedup();
        let common = |&k: &u32| self.at_side(&[corner.min(k), corner.max(k)], own).saturating_sub(1) as i32;
        1 - self.apart_from(star, own) as i32 + others.iter().map(common).sum::<i32>()
    }

    fn apart_from(&self, list: &[u32], own: &[u32]) -> usize {
        list.iter().filter(|&&t| !self.triangles[t as usize].iter().any(|k| own.contains(k))).count()
    }

    /// Mean length of the edges at rest \[m\].
    pub fn size(&self, rest: &[Vec3]) -> f64 {
        let length = |e: &Edge| (rest[e.nodes[0] as usize] - rest[e.nodes[1] as usize]).norm();
        self.edges.iter().map(length).sum::<f64>() / self.edges.len() as f64
    }
}
