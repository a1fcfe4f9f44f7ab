//! Cavity: a fluid behind a part of the surface, under one pressure p everywhere.
//!
//! ```text
//! V(x) = −⅓ ∫ (x − o)·n dA,  n dA = x,ξ × x,η dξ dη      n outward of the body, o the origin of the cones
//! ```
//!
//! For a closed surface V is the volume inside and −∫ N_a n dA its gradient: p ∂V/∂x are the follower forces of the
//! pressure, which therefore have the potential −p V and a symmetric tangent (Schweizerhof & Ramm, Comput. Struct. 18,
//! 1984). This also holds for an open surface whose rim is held or slides in planes through o: the cones between the rim and o do not change. V is
//! then the volume of the cones, which equals the volume of the cavity up to a constant.
//!
//! A rim in a plane that does not contain o would add a cone over a cap of changing area. If the rim slides in two parallel planes x_k = const, the
//! field ⅓ (x − o) is therefore replaced by W (x − o) with W diagonal, tr W = 1 and W_kk = 0: its divergence is also 1, and its flux through planes
//! x_k = const is zero. V is the volume between the two planes.
//!
//! Under a prescribed pressure the cavity is the load −p(t) V; under a prescribed change of volume it is the exact constraint g = V(x) − V₀ − ΔV(t) =
//! 0, whose multiplier is the pressure. Volume control passes limit points of the pressure. The integrals are exact on tet4 and curved tet10 facets
//! (a polynomial of degree 4).
//!
//! A surface that does not consist of facets follows the body by x_v = X_v + Σ_i w_vi u_i. V is the volume of its flat triangles, and gradient and
//! Hessian follow by the chain rule: with the matrix A of the weights they are Aᵀ ∂V/∂x_v and Aᵀ ∂²V/∂x_v² A. The work of the pressure on the nodes
//! is therefore p dV to rounding, and the resultant and its moment equal those on the surface (Σ_i w_vi = 1, Σ_i w_vi X_i = X_v).

use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Constraint, ConstraintKind, Effect, EnergyRole, EvalError, PolynomialLoad,
    Want,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Shape functions of a facet at a quadrature point, and the weight of the point.
pub(super) struct FacetPoint {
    pub weight: f64,
    pub n: [f64; 6],
    /// ∂N/∂ξ, ∂N/∂η
    pub d: [[f64; 2]; 6],
}

/// A field v = W (x − o) of divergence 1, whose flux through a closed surface is the volume inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeField {
    /// o \[m\]
    pub origin: Vec3,
    /// Diagonal of W, of sum 1 \[–\]
    pub weights: Vec3,
}

impl VolumeField {
    /// The field ⅓ (x − o) of cones with their apex at o.
    pub fn cones(origin: Vec3) -> Self {
        Self { origin, weights: Vec3::repeat(1.0 / 3.0) }
    }

    /// The field without flux along the axes that are `closed`; `None` if all are closed.
    pub fn across(origin: Vec3, closed: [bool; 3]) -> Option<Self> {
        let open = closed.iter().filter(|closed| !**closed).count();
        let weights = Vec3::from_fn(|k, _| if closed[k] { 0.0 } else { 1.0 / open as f64 });
        (open > 0).then_some(Self { origin, weights })
    }
}

/// Geometry of a cavity; its blocks are the facets, or the triangles of a surface that follows the body.
pub struct Cavity {
    name: String,
    field: VolumeField,
    blocks: Blocks,
    /// \[blocks × nodes of a facet\] X \[m\]
    reference: Vec<Vec3>,
    points: Vec<FacetPoint>,
    /// Nodes of a facet
    nodes: usize,
    /// \[blocks × nodes of the block\] weights of the node in the three vertices, for a surface that follows the body
    carried: Option<Vec<Vec<[f64; 3]>>>,
}

impl Cavity {
    /// Builds a cavity on boundary facets of the body; the flux of the field through a plane in which the rim slides must be zero.
    pub fn new(name: String, mesh: &TetMesh, facets: &[u32], field: VolumeField) -> Self {
        let lists = || facets.iter().map(|&f| mesh.facet(f as usize));
        let reference = lists().flatten().map(|&k| mesh.points[k as usize]).collect();
        let (blocks, points, nodes) = (Blocks::new(lists()), facet_points(mesh.order), mesh.order.facet_nodes());
        Self { name, field, blocks, reference, points, nodes, carried: None }
    }

    /// Builds a cavity on the triangles of a surface, oriented outward from the volume that it encloses; each vertex follows the (node, weight) pairs
    /// of its list.
    pub fn on_surface(
        name: String,
        (vertices, triangles): (&[Vec3], &[[u32; 3]]),
        weights: &[Vec<(u32, f64)>],
        field: VolumeField,
    ) -> Self {
        // Outward from the body means into the volume.
        let inward = || triangles.iter().map(|&[a, b, c]| [a, c, b]);
        let reference = inward().flatten().map(|k| vertices[k as usize]).collect();
        let by_node = |corners: [u32; 3]| {
            let mut of: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
            for (corner, vertex) in corners.into_iter().enumerate() {
                for &(node, weight) in weights[vertex as usize].iter().filter(|(_, weight)| *weight != 0.0) {
                    of.entry(node).or_default()[corner] += weight;
                }
            }
            of
        };
        let lists: Vec<BTreeMap<u32, [f64; 3]>> = inward().map(by_node).collect();
        let nodes: Vec<Vec<u32>> = lists.iter().map(|of| of.keys().copied().collect()).collect();
        let blocks = Blocks::new(nodes.iter().map(Vec::as_slice));
        let carried = Some(lists.into_iter().map(|of| of.into_values().collect()).collect());
        Self { name, field, blocks, reference, points: facet_points(Order::Linear), nodes: 3, carried }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The blocks on which its pressure acts.
    pub fn facets(&self) -> &Blocks {
        &self.blocks
    }

    pub(super) fn points(&self) -> &[FacetPoint] {
        &self.points
    }

    /// V(x) \[m³\]
    pub fn volume(&self, x: &[f64]) -> f64 {
        (0..self.blocks.len()).map(|b| self.facet_volume(x, b)).sum()
    }

    /// Returns ∂V/∂x \[m²\] as (unknown, derivative), facet by facet.
    pub fn volume_gradient(&self, x: &[f64]) -> Vec<(u32, f64)> {
        let mut out = Vec::new();
        for b in 0..self.blocks.len() {
            let mut values = BlockValues::new(self.blocks.size(b));
            self.facet(x, b, -1.0, Want::Residual, &mut values);
            out.extend(self.blocks.dofs(b).zip(values.r.iter().copied()));
        }
        out
    }

    /// Position of node `a` of facet `b` relative to o \[m\].
    fn position(&self, x: &[f64], b: usize, a: usize) -> Vec3 {
        let motion = |node: u32| Vec3::from_column_slice(&x[3 * node as usize..][..3]);
        let moved = match &self.carried {
            None => motion(self.blocks.nodes(b)[a]),
            Some(weights) => self.blocks.nodes(b).iter().zip(&weights[b]).map(|(&k, w)| motion(k) * w[a]).sum(),
        };
        self.reference[b * self.nodes + a] - self.field.origin + moved
    }

    /// x − o, x,ξ and x,η at a quadrature point.
    pub(super) fn frame(&self, x: &[f64], b: usize, point: &FacetPoint) -> [Vec3; 3] {
        (0..self.nodes).fold([Vec3::zeros(); 3], |[at, u, v], a| {
            let p = self.position(x, b, a);
            [at + point.n[a] * p, u + point.d[a][0] * p, v + point.d[a][1] * p]
        })
    }

    fn facet_volume(&self, x: &[f64], b: usize) -> f64 {
        let cone = |point: &FacetPoint| {
            let [at, u, v] = self.frame(x, b, point);
            -point.weight * self.field.weights.component_mul(&at).dot(&u.cross(&v))
        };
        self.points.iter().map(cone).sum()
    }

    /// Writes −V of facet `b`, and its gradient and Hessian times `factor`.
    fn facet(&self, x: &[f64], b: usize, factor: f64, want: Want, out: &mut BlockValues) {
        let Some(weights) = &self.carried else { return self.by_corners(x, b, factor, want, out) };
        let mut own = BlockValues::new(9);
        self.by_corners(x, b, factor, want, &mut own);
        out.energy = own.energy;
        if want > Want::Energy {
            carry(&own, &weights[b], want, out);
        }
    }

    /// Writes −V of facet `b`, and its gradient and Hessian times `factor`, with respect to the displacements of the facet's corners.
    fn by_corners(&self, x: &[f64], b: usize, factor: f64, want: Want, out: &mut BlockValues) {
        out.energy = -self.facet_volume(x, b);
        if want == Want::Energy {
            return;
        }
        let n = 3 * self.nodes;
        for point in &self.points {
            let [at, u, v] = self.frame(x, b, point);
            let scale = self.field.weights;
            let (w, flow) = (factor * point.weight, scale.component_mul(&at));
            let FacetPoint { n: shape, d, .. } = point;
            for a in 0..self.nodes {
                let normal = scale.component_mul(&u.cross(&v));
                let g = w * (shape[a] * normal + d[a][0] * v.cross(&flow) + d[a][1] * flow.cross(&u));
                out.r[3 * a..3 * a + 3].iter_mut().zip(g.iter()).for_each(|(r, g)| *r += g);
                if want < Want::Tangent {
                    continue;
                }
                for c in 0..=a {
                    // ∂²/∂x_a∂x_c = ε_ijk (W_i p − W_j q + s)_k; with W = ⅓ 1 antisymmetric in a, c
                    let p = shape[a] * (d[c][0] * v - d[c][1] * u);
                    let q = shape[c] * (d[a][0] * v - d[a][1] * u);
                    let s = (d[a][0] * d[c][1] - d[c][0] * d[a][1]) * flow;
                    for (i, j, k, sign) in CYCLES {
                        let m = scale[i] * p[k] - scale[j] * q[k] + s[k];
                        out.k[(3 * a + i) * n + 3 * c + j] += sign * w * m;
                    }
                }
            }
        }
    }
}

/// Transforms gradient and Hessian with respect to three vertices to the nodes that move them.
fn carry(own: &BlockValues, weights: &[[f64; 3]], want: Want, out: &mut BlockValues) {
    let n = 3 * weights.len();
    // Only the lower triangle is given.
    let hessian = |row: usize, column: usize| own.k[9 * row.max(column) + row.min(column)];
    for (a, of) in weights.iter().enumerate() {
        for i in 0..3 {
            out.r[3 * a + i] += (0..3).map(|p| of[p] * own.r[3 * p + i]).sum::<f64>();
        }
        if want < Want::Tangent {
            continue;
        }
        for (i, j) in (0..9).map(|ij| (ij / 3, ij % 3)) {
            let half: [f64; 3] =
                std::array::from_fn(|q| (0..3).map(|p| of[p] * hessian(3 * p + i, 3 * q + j)).sum::<f64>());
            for (c, other) in weights[..=a].iter().enumerate() {
                out.k[(3 * a + i) * n + 3 * c + j] += (0..3).map(|q| half[q] * other[q]).sum::<f64>();
            }
        }
    }
}

/// Quadrature points of a facet.
fn facet_points(order: Order) -> Vec<FacetPoint> {
    let rule = quadrature::tri(4);
    let point = |(&xi, &weight): (&[f64; 2], &f64)| FacetPoint {
        weight,
        n: element::facet_shape(order, xi),
        d: element::facet_gradients(order, xi),
    };
    rule.points.iter().zip(&rule.weights).map(point).collect()
}

/// (i, j, k, ε_ijk) for the nonzero ε_ijk.
pub(super) const CYCLES: [(usize, usize, usize, f64); 6] =
    [(0, 1, 2, 1.0), (1, 2, 0, 1.0), (2, 0, 1, 1.0), (1, 0, 2, -1.0), (2, 1, 0, -1.0), (0, 2, 1, -1.0)];

/// Cavity under a prescribed pressure p(t) \[Pa\]; a negative pressure is a vacuum.
pub struct CavityPressure {
    pub cavity: Arc<Cavity>,
    pub pressure: Signal,
}

impl Effect for CavityPressure {
    fn name(&self) -> &str {
        &self.cavity.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.pressure.at(now)
    }

    fn blocks(&self) -> &Blocks {
        &self.cavity.blocks
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { polynomial: Some(self), ..Capabilities::default() }
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.cavity.facet(at.x, b, self.intensity(at.clock()), want, out);
        Ok(())
    }
}

impl PolynomialLoad for CavityPressure {
    fn degree(&self) -> usize {
        2
    }

    fn unit_residual(&self, x: &[f64], b: usize, out: &mut BlockValues) {
        self.cavity.facet(x, b, 1.0, Want::Residual, out);
    }
}

/// Cavity whose volume changes by a prescribed ΔV(t) \[m³\].
pub struct CavityVolume {
    pub cavity: Arc<Cavity>,
    pub growth: Signal,
    /// V₀ \[m³\]
    pub rest: f64,
    /// Volume to which g is related \[m³\]
    pub scale: f64,
}

impl Constraint for CavityVolume {
    fn name(&self) -> &str {
        &self.cavity.name
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Equality
    }

    fn scale(&self) -> f64 {
        self.scale
    }

    fn target(&self, now: Clock) -> f64 {
        -(self.rest + self.growth.at(now))
    }

    fn blocks(&self) -> &Blocks {
        &self.cavity.blocks
    }

    fn eval(&self, x: &[f64], b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.cavity.facet(x, b, 1.0, want, out);
        Ok(())
    }
}
