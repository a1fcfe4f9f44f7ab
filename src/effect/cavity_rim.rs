//! Rim of an open cavity that is held or slides in planes.
//!
//! ```text
//! δV = −∫ δx·n dA + ∮ δx·(v × dx)                         v: field of the volume, rim oriented by its facets
//! c_a = ∂V/∂x_a + ∫ N_a n dA = ∮ N_a v × dx
//! ```
//!
//! by Stokes' theorem. c is zero at free unknowns, so that p ∂V/∂x and the forces −p ∫ N_a n dA of the pressure on the wall have the same equilibria.
//! At held unknowns they differ: the reaction that holds the rim against the pressure on the wall is the residual with −p ∂V/∂x plus p c.

use super::cavity::VolumeField;
use super::open_cavity::{GAUSS, edge_shape};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::system::Blocks;

/// Returns the mean position of edges, weighted by their length \[m\], with the mid-node last; `None` without edges. Edges in a plane have their mean
/// exactly in it, however they are divided.
pub fn middle_of_edges(mesh: &TetMesh, edges: &[&Vec<u32>]) -> Option<Vec3> {
    let (mut length, mut moment) = (0.0, Vec3::zeros());
    for edge in edges {
        for (s, weight) in GAUSS {
            let (shape, slope) = edge_shape(edge.len(), s);
            let sum = |of: [f64; 3]| edge.iter().zip(of).map(|(&k, n)| n * mesh.points[k as usize]).sum::<Vec3>();
            let part = weight * sum(slope).norm();
            length += part;
            moment += part * sum(shape);
        }
    }
    (length > 0.0).then(|| moment / length)
}

/// Returns the flux \[m³\] of a field through the cones from a point over edges, oriented by their facets, with the mid-node last: positive out of
/// the cavity behind the facets.
pub fn flux_through_cones(mesh: &TetMesh, edges: &[&Vec<u32>], from: Vec3, field: &VolumeField) -> f64 {
    let flow = |v: Vec3| field.weights.component_mul(&v);
    let mut flux = 0.0;
    for edge in edges {
        for (s, weight) in GAUSS {
            let (shape, slope) = edge_shape(edge.len(), s);
            let sum = |of: [f64; 3]| edge.iter().zip(of).map(|(&k, n)| n * mesh.points[k as usize]).sum::<Vec3>();
            let arm = sum(shape) - from;
            let mean = flow(from - field.origin) / 2.0 + flow(arm) / 3.0;
            flux += weight * mean.dot(&arm.cross(&sum(slope)));
        }
    }
    flux
}

/// The edges of a rim, and the field that measures the volume behind it.
pub struct CavityRim {
    field: VolumeField,
    edges: Blocks,
    /// \[edges × nodes of an edge\] X \[m\]
    reference: Vec<Vec3>,
}

/// A point of an edge: weight, shape functions and their derivatives, v, and dx.
struct EdgePoint {
    weight: f64,
    shape: [f64; 3],
    slope: [f64; 3],
    flow: Vec3,
    along: Vec3,
}

impl CavityRim {
    /// Builds a rim from edges oriented by their facets, with the mid-node last.
    pub fn new(mesh: &TetMesh, edges: &[Vec<u32>], field: VolumeField) -> Self {
        let reference = edges.iter().flatten().map(|&k| mesh.points[k as usize]).collect();
        Self { field, edges: Blocks::new(edges.iter().map(Vec::as_slice)), reference }
    }

    fn points(&self, x: &[f64], b: usize) -> impl Iterator<Item = EdgePoint> {
        let nodes = self.edges.nodes(b);
        let moved =
            |a: usize| self.reference[b * nodes.len() + a] + Vec3::from_column_slice(&x[3 * nodes[a] as usize..][..3]);
        let places: Vec<Vec3> = (0..nodes.len()).map(moved).collect();
        let field = self.field;
        GAUSS.into_iter().map(move |(s, weight)| {
            let (shape, slope) = edge_shape(places.len(), s);
            let sum = |of: &[f64; 3]| places.iter().zip(of).map(|(x, n)| *n * x).sum::<Vec3>();
            let flow = field.weights.component_mul(&(sum(&shape) - field.origin));
            EdgePoint { weight, shape, slope, flow, along: sum(&slope) }
        })
    }

    /// Returns c \[m²\] as (unknown, value), edge by edge.
    pub fn excess(&self, x: &[f64]) -> Vec<(u32, f64)> {
        let mut out = Vec::new();
        for b in 0..self.edges.len() {
            for point in self.points(x, b) {
                let force = point.weight * point.flow.cross(&point.along);
                let nodes = self.edges.nodes(b).iter().zip(point.shape);
                out.extend(nodes.flat_map(|(&node, n)| (0..3).map(move |i| (3 * node + i, n * force[i as usize]))));
            }
        }
        out
    }

    /// Returns the gradient of Σ w c \[m\] for weights w of the unknowns, as (unknown, derivative).
    pub fn gradient(&self, x: &[f64], weight: impl Fn(u32) -> f64) -> Vec<(u32, f64)> {
        let mut out = Vec::new();
        for b in 0..self.edges.len() {
            let nodes = self.edges.nodes(b);
            for point in self.points(x, b) {
                let of_node = |&node: &u32| Vec3::from_fn(|i, _| weight(3 * node + i as u32));
                let w: Vec3 = nodes.iter().zip(point.shape).map(|(node, n)| n * of_node(node)).sum();
                let by_place = self.field.weights.component_mul(&point.along.cross(&w));
                let by_slope = w.cross(&point.flow);
                for ((&node, n), d) in nodes.iter().zip(point.shape).zip(point.slope) {
                    let g = point.weight * (n * by_place + d * by_slope);
                    out.extend((0..3).map(|i| (3 * node + i, g[i as usize])));
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Cavity;
    use crate::mesh::Order;
    use crate::mesh::rim::rim;
    use crate::mesh::structured::block;
    use std::collections::BTreeMap;

    fn sum(of: impl IntoIterator<Item = (u32, f64)>) -> BTreeMap<u32, f64> {
        let mut out = BTreeMap::new();
        of.into_iter().for_each(|(dof, value)| *out.entry(dof).or_insert(0.0) += value);
        out
    }

    /// Compares c with ∂V/∂x + ∫ N n dA of the facets, and its derivatives with central differences, which are exact for a quadratic function;
    /// rounding is 1e-13.
    #[test]
    fn the_line_integral_is_that_of_the_facets() {
        for order in [Order::Linear, Order::Quadratic] {
            let mesh = block(2, 3, 1, 1.0, 1.2, 0.5, order);
            let facets: Vec<u32> = (0..mesh.facet_count() as u32)
                .filter(|&f| mesh.facet(f as usize)[..3].iter().all(|&k| mesh.points[k as usize].z > 0.49))
                .collect();
            let field = VolumeField { origin: Vec3::new(0.3, -0.2, 0.7), weights: Vec3::new(0.5, 0.2, 0.3) };
            let cavity = Cavity::new("c".into(), &mesh, &facets, field);
            let held = CavityRim::new(&mesh, &rim(&mesh, &facets), field);
            let wave = |k: usize, a: f64| 0.1 * (a * k as f64).sin();
            let x: Vec<f64> = (0..3 * mesh.points.len()).map(|k| wave(k, 1.7)).collect();
            let mut expected = sum(cavity.volume_gradient(&x));
            for b in 0..cavity.facets().len() {
                for point in cavity.points() {
                    let [_, u, v] = cavity.frame(&x, b, point);
                    let normal = point.weight * u.cross(&v);
                    for (a, &node) in cavity.facets().nodes(b).iter().enumerate() {
                        for i in 0..3 {
                            *expected.entry(3 * node + i).or_default() += point.n[a] * normal[i as usize];
                        }
                    }
                }
            }
            let found = sum(held.excess(&x));
            for (dof, value) in &expected {
                let own = found.get(dof).copied().unwrap_or(0.0);
                assert!((own - value).abs() < 1e-13, "{order:?}, {dof}: {own} {value}");
            }
            assert!(found.values().any(|c| c.abs() > 0.01));
            let weight = |dof: u32| wave(dof as usize, 0.9);
            let functional = |x: &[f64]| held.excess(x).iter().map(|(dof, c)| weight(*dof) * c).sum::<f64>();
            for (dof, slope) in sum(held.gradient(&x, weight)) {
                let at = |d: f64| {
                    let mut moved = x.clone();
                    moved[dof as usize] += d;
                    functional(&moved)
                };
                let exact = (at(0.5) - at(-0.5)) / 1.0;
                assert!((slope - exact).abs() < 1e-13, "{order:?}, {dof}: {slope} {exact}");
            }
        }
    }
}
