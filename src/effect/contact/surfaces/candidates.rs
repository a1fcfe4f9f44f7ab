//! Candidate pairs of a point and a triangle, and of two edges, found by the bounding volume hierarchies of parry3d.
//!
//! Pairs that share a node do not count. The lists are in ascending order.

use super::surface::{Edge, Surface};
use crate::effect::contact::SurfacePoint;
use crate::math::boxes::{Span, from_parry, hierarchy, overlapping, widened};
use crate::math::tensor::Vec3;
use parry3d_f64::partitioning::BvhNode;
use std::cell::Cell;

/// Points of one surface against triangles of another.
pub struct Pass<'a> {
    pub points: &'a Surface,
    pub triangles: &'a Surface,
}

/// Candidate pairs as indices into the lists of the surfaces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Candidates {
    /// Pairs of point and triangle, pass by pass
    pub points: Vec<Vec<[u32; 2]>>,
    /// Pairs of edges of the first and of the second surface
    pub edges: Vec<[u32; 2]>,
}

/// Returns the pairs whose boxes, around points and nodes, are nearer than `radius`. For self-contact, each pair of edges occurs once.
pub fn candidates(
    passes: &[Pass],
    radius: f64,
    of_point: &dyn Fn(&SurfacePoint) -> Span,
    of_node: &dyn Fn(u32) -> Span,
) -> Candidates {
    let over = |nodes: &[u32]| nodes.iter().map(|&k| of_node(k)).reduce(join).expect("a triangle or an edge has nodes");
    let mut found = Candidates::default();
    for Pass { points, triangles } in passes {
        let tree = hierarchy(triangles.triangles.iter().map(|t| over(t)));
        let mut pairs = Vec::new();
        for (k, point) in (0..).zip(&points.points) {
            for t in overlapping(&tree, widened(of_point(point), radius)) {
                if !triangles.triangles[t as usize].iter().any(|n| point.nodes.contains(n)) {
                    pairs.push([k, t]);
                }
            }
        }
        found.points.push(pairs);
    }
    let (first, second) = (&passes[0].points.edges, &passes[0].triangles.edges);
    let tree = hierarchy(second.iter().map(|e| over(&e.nodes)));
    let itself = passes.len() == 1;
    for (k, Edge { nodes, .. }) in (0..).zip(first) {
        for other in overlapping(&tree, widened(over(nodes), radius)) {
            let shared = second[other as usize].nodes.iter().any(|n| nodes.contains(n));
            if !(shared || itself && other <= k) {
                found.edges.push([k, other]);
            }
        }
    }
    found
}

/// Returns the smallest distance between a point and a triangle, at most `most`; boxes that are farther apart than the smallest distance so far are
/// skipped.
pub fn least_of_points(
    passes: &[Pass],
    most: f64,
    of_point: &dyn Fn(&SurfacePoint) -> Vec3,
    of_node: &dyn Fn(u32) -> Vec3,
    to_triangle: &dyn Fn(&Pass, &SurfacePoint, u32) -> f64,
) -> f64 {
    let best = Cell::new(most);
    for pass in passes {
        let tree = hierarchy(pass.triangles.triangles.iter().map(|t| around(t, of_node)));
        for point in &pass.points.points {
            let at = of_point(point);
            for t in tree.leaves(|node| apart(node, (at, at)) < best.get()) {
                if !pass.triangles.triangles[t as usize].iter().any(|n| point.nodes.contains(n)) {
                    best.set(best.get().min(to_triangle(pass, point, t)));
                }
            }
        }
    }
    best.get()
}

/// Returns the smallest distance between two edges, at most `most`; boxes that are farther apart than the smallest distance so far are skipped.
pub fn least_of_edges(
    passes: &[Pass],
    most: f64,
    of_node: &dyn Fn(u32) -> Vec3,
    between: &dyn Fn(&Edge, &Edge) -> f64,
) -> f64 {
    let best = Cell::new(most);
    let second = &passes[0].triangles.edges;
    let tree = hierarchy(second.iter().map(|e| around(&e.nodes, of_node)));
    for edge in &passes[0].points.edges {
        let span = around(&edge.nodes, of_node);
        for other in tree.leaves(|node| apart(node, span) < best.get()) {
            let other = &second[other as usize];
            if !other.nodes.iter().any(|n| edge.nodes.contains(n)) {
                best.set(best.get().min(between(edge, other)));
            }
        }
    }
    best.get()
}

/// Box around nodes.
fn around(nodes: &[u32], of_node: &dyn Fn(u32) -> Vec3) -> Span {
    nodes.iter().map(|&k| (of_node(k), of_node(k))).reduce(join).expect("a triangle or an edge has nodes")
}

/// Distance between two boxes \[m\].
fn apart(node: &BvhNode, (low, high): Span) -> f64 {
    (from_parry(node.mins()) - high).sup(&(low - from_parry(node.maxs()))).sup(&Vec3::zeros()).norm()
}

/// Returns the pairs of an edge and a triangle without a common node whose boxes overlap: the edges of each surface with the triangles of the other.
pub fn pierced_by_edges(passes: &[Pass], of_node: &dyn Fn(u32) -> Span) -> Vec<([u32; 2], [u32; 3])> {
    let over = |nodes: &[u32]| nodes.iter().map(|&k| of_node(k)).reduce(join).expect("a triangle or an edge has nodes");
    let mut found = Vec::new();
    for Pass { points, triangles } in passes {
        let tree = hierarchy(triangles.triangles.iter().map(|t| over(t)));
        for Edge { nodes, .. } in &points.edges {
            let near = overlapping(&tree, over(nodes)).into_iter().map(|t| triangles.triangles[t as usize]);
            found.extend(near.filter(|t| !t.iter().any(|k| nodes.contains(k))).map(|t| (*nodes, t)));
        }
    }
    found
}

fn join(a: Span, b: Span) -> Span {
    (a.0.inf(&b.0), a.1.sup(&b.1))
}
