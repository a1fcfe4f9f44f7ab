//! Points of a surface that contact looks at: nodes with a share of the area, or quadrature points.
//!
//! Nodes of tet4 facets take a third of each, which is ∫ N_a dA: a uniform pressure comes out uniform. On tet10 facets ∫ N_a dA
//! is zero at the corners, so pressures are evaluated at the six points of a rule of degree 4 there. Corners between them might still
//! cross an obstacle: they are guards, with a millionth of the area.

use super::placement::AffineFrame;
use crate::math::tensor::Vec3;
use crate::mesh::{Order, TetMesh, element, quadrature};
use std::collections::BTreeMap;

/// Share of the area of a facet that a guard has \[–\].
const GUARD: f64 = 1e-6;

/// A point of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePoint {
    /// X_q \[m\]
    pub at: Vec3,
    pub nodes: Vec<u32>,
    /// N_a
    pub weights: Vec<f64>,
    /// W_q \[m²\]
    pub area: f64,
    /// Facets of the mesh at the point, each with a part of its area at rest \[m²\]; a guard and a point of a rigid body have none
    pub sides: Vec<(u32, f64)>,
    /// Of a ball about the point \[m\], 0 of a point of a surface
    pub radius: f64,
    /// The affine body that the ball is a part of, whose four nodes are those of the point; None of a point of a surface
    pub carrier: Option<AffineFrame>,
}

impl SurfacePoint {
    /// A point of a surface, without a ball about it or facets.
    pub fn flat(at: Vec3, nodes: Vec<u32>, weights: Vec<f64>, area: f64) -> Self {
        Self { at, nodes, weights, area, sides: Vec::new(), radius: 0.0, carrier: None }
    }

    /// N_a of the material that lies at `arm` from the point in the mean of two displacements of the nodes.
    pub(super) fn weights_at(&self, displacements: [&[f64]; 2], arm: &Vec3) -> Vec<f64> {
        let Some(frame) = &self.carrier else { return self.weights.clone() };
        // A collapsed body has no material elsewhere than in its centre.
        let back = |x: &[f64]| frame.gradient_of(x).try_inverse().map_or(Vec3::zeros(), |back| back * arm);
        let turned = displacements.map(back).iter().sum::<Vec3>() / 2.0;
        frame.weights(&(self.at + turned)).to_vec()
    }
}

/// Where the points are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// At the nodes, for forces at nodes
    Nodes,
    /// Where a pressure can stand: nodes of tet4, quadrature points and guards of tet10
    Pressures,
}

/// Points of facets of a mesh at rest, all with one number of nodes.
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

/// Every node with a part of the areas of its facets, ∫ N_a dA of flat ones: a third each on tet4; none at a corner and a third at a mid-edge on tet10. So the
/// nodes on which a uniform pressure has a force have all of the area.
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
