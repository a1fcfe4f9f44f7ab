//! Contact points of a surface: nodes with their tributary areas, or quadrature points.
//!
//! On tet4 facets each node takes a third of the area, which is ∫ N_a dA: a uniform pressure is reproduced exactly. On tet10 facets ∫ N_a dA is zero
//! at the corners, so that pressures are evaluated at the six points of a rule of degree 4. The corners in between could still cross an obstacle:
//! they are guards, with a millionth of the area.

use super::placement::AffineFrame;
use crate::math::tensor::Vec3;
use crate::mesh::{Order, TetMesh, element, quadrature};
use std::collections::BTreeMap;

/// Area of a guard relative to that of its facets \[–\].
const GUARD: f64 = 1e-6;

/// A contact point of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePoint {
    /// X_q \[m\]
    pub at: Vec3,
    pub nodes: Vec<u32>,
    /// N_a
    pub weights: Vec<f64>,
    /// W_q \[m²\]
    pub area: f64,
    /// Facets of the mesh at the point, each with its part of the area at rest \[m²\]; empty for a guard and for a point of a rigid body
    pub sides: Vec<(u32, f64)>,
    /// Radius of a ball about the point \[m\], 0 for a point of a surface
    pub radius: f64,
    /// The affine body to which the ball belongs, whose four nodes are those of the point; `None` for a point of a surface
    pub carrier: Option<AffineFrame>,
}

impl SurfacePoint {
    /// Builds a point of a surface, without a ball and without facets.
    pub fn flat(at: Vec3, nodes: Vec<u32>, weights: Vec<f64>, area: f64) -> Self {
        Self { at, nodes, weights, area, sides: Vec::new(), radius: 0.0, carrier: None }
    }

    /// Returns N_a of the material at `arm` from the point, for the mean of two displacements of the nodes.
    pub(super) fn weights_at(&self, displacements: [&[f64]; 2], arm: &Vec3) -> Vec<f64> {
        let Some(frame) = &self.carrier else { return self.weights.clone() };
        // A collapsed body has no material except at its centre.
        let back = |x: &[f64]| frame.gradient_of(x).try_inverse().map_or(Vec3::zeros(), |back| back * arm);
        let turned = displacements.map(back).iter().sum::<Vec3>() / 2.0;
        frame.weights(&(self.at + turned)).to_vec()
    }
}

/// Choice of the contact points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// At the nodes, for forces at nodes
    Nodes,
    /// Where a pressure can act: nodes of tet4, quadrature points and guards of tet10
    Pressures,
}

/// Builds the points of facets of a mesh at rest; all have the same number of nodes.
pub fn points(mesh: &TetMesh, facets: &[u32], sampling: Sampling) -> Vec<SurfacePoint> {
    if mesh.order == Order::Linear || sampling == Sampling::Nodes {
        return nodes(mesh, facets);
    }
    let rule = quadrature::tri(4);
    let mut out = Vec::new();
    let mut guarded = std::collections::BTreeSet::new();
    for &f in facets {
        let list = mesh.facet(f as usize);
        let at = |weights: &[f64]| list.iter().zip(weights).map(|(&k, w)| mesh.points[k as usize] * *w).sum();
        let mut area = 0.0;
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let weights = element::facet_shape(mesh.order, xi)[..list.len()].to_vec();
            let part = w * mesh.facet_normal(f as usize, xi).norm();
            area += part;
            let point = SurfacePoint::flat(at(&weights), list.to_vec(), weights, part);
            out.push(SurfacePoint { sides: vec![(f, part)], ..point });
        }
        for a in (0..list.len()).filter(|&a| guarded.insert(list[a])) {
            let weights: Vec<f64> = (0..list.len()).map(|k| if k == a { 1.0 } else { 0.0 }).collect();
            out.push(SurfacePoint::flat(at(&weights), list.to_vec(), weights, GUARD * area));
        }
    }
    out
}

/// Builds every node with its part of the area of its facets, ∫ N_a dA for flat facets: a third each on tet4; on tet10 zero at a corner and a third
/// at a mid-edge node. The nodes on which a uniform pressure exerts a force thus have the whole area.
fn nodes(mesh: &TetMesh, facets: &[u32]) -> Vec<SurfacePoint> {
    let mut sides = BTreeMap::<u32, Vec<(u32, f64)>>::new();
    let rule = quadrature::tri(4);
    for &f in facets {
        let parts = rule.points.iter().zip(&rule.weights).map(|(&xi, w)| w * mesh.facet_normal(f as usize, xi).norm());
        let area: f64 = parts.sum();
        for (a, &node) in mesh.facet(f as usize).iter().enumerate() {
            let share = if mesh.order == Order::Quadratic && a < 3 { 0.0 } else { 1.0 / 3.0 };
            sides.entry(node).or_default().push((f, share * area));
        }
    }
    let point = |(node, sides): (u32, Vec<(u32, f64)>)| {
        let area = sides.iter().fold(0.0, |sum, side| sum + side.1);
        SurfacePoint { sides, ..SurfacePoint::flat(mesh.points[node as usize], vec![node], vec![1.0], area) }
    };
    sides.into_iter().map(point).collect()
}
