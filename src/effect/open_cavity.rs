//! Open cavity: a pressure p(t) on a part of the surface whose rim is free, always along the current normal.
//!
//! ```text
//! r_a = p ∫ N_a n dA,  n dA = x,ξ × x,η dξ dη                       n outward of the body
//! ∂r_a/∂x_c = p ∫ N_a [∂N_c/∂η x,ξ − ∂N_c/∂ξ x,η]× dξ dη = K_ac + A_ac
//! K_ac = ½p ∫ [(N_a ∂N_c/∂η − N_c ∂N_a/∂η) x,ξ − (N_a ∂N_c/∂ξ − N_c ∂N_a/∂ξ) x,η]× dξ dη
//! A_ac = −½p ∮ N_a N_c [dx]×                                        along the rim, oriented by its facets
//! ```
//!
//! K is symmetric, A skew: by Stokes' theorem the skew parts of neighbouring facets cancel on their common edge. Only a free rim therefore makes the
//! tangent unsymmetric, and the pressure there has no potential (Schweizerhof & Ramm, Comput. Struct. 18, 1984; Bonet & Wood, Nonlinear Continuum
//! Mechanics, 2008, ch. 8). Where the rim is held, A acts on no free unknown.
//!
//! Energy of a step: ∫ dx·n dA over the surface as it moves in a straight line from its last state, the swept volume, with the sign of the load's φ.
//! Simpson's rule is exact for it. The integrals are exact on tet4 and curved tet10 facets.

use super::cavity::{CYCLES, Cavity, FacetPoint};
use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::rim::rim;
use crate::system::{At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, SkewTangent, Want};
use std::sync::Arc;

/// Pressure p(t) \[Pa\] on an open surface with a free rim; a negative pressure is a vacuum.
pub struct OpenCavityPressure {
    cavity: Arc<Cavity>,
    pressure: Signal,
    /// Edges of the rim
    rim: Blocks,
    /// \[edges × nodes of an edge\] X \[m\]
    reference: Vec<Vec3>,
}

impl OpenCavityPressure {
    /// Builds the pressure on a cavity, whose facets in the mesh are `facets`.
    pub fn new(cavity: Arc<Cavity>, mesh: &TetMesh, facets: &[u32], pressure: Signal) -> Self {
        let edges = rim(mesh, facets);
        let reference = edges.iter().flatten().map(|&k| mesh.points[k as usize]).collect();
        Self { cavity, pressure, rim: Blocks::new(edges.iter().map(Vec::as_slice)), reference }
    }

    /// Returns ∫ (x − xₙ)·n dA along the straight path from xₙ to x \[m³\].
    fn swept(&self, at: &At, b: usize, point: &FacetPoint) -> f64 {
        let [now, u, v] = self.cavity.frame(at.x, b, point);
        let [old, p, q] = self.cavity.frame(at.old, b, point);
        let middle = (u + p).cross(&(v + q));
        point.weight * (now - old).dot(&(u.cross(&v) + middle + p.cross(&q))) / 6.0
    }
}

impl Effect for OpenCavityPressure {
    fn name(&self) -> &str {
        self.cavity.name()
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Follower
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.pressure.at(now)
    }

    fn blocks(&self) -> &Blocks {
        self.cavity.facets()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let p = self.intensity(at.clock());
        for point in self.cavity.points() {
            out.energy += self.swept(at, b, point);
            if want == Want::Energy {
                continue;
            }
            let [_, u, v] = self.cavity.frame(at.x, b, point);
            let (w, normal) = (p * point.weight, u.cross(&v));
            let FacetPoint { n: shape, d, .. } = point;
            let nodes = self.cavity.facets().nodes(b).len();
            for a in 0..nodes {
                for i in 0..3 {
                    out.r[3 * a + i] += w * shape[a] * normal[i];
                }
                if want < Want::Tangent {
                    continue;
                }
                for c in 0..=a {
                    // [q]×_ij = −ε_ijk q_k
                    let q = 0.5
                        * w
                        * ((shape[a] * d[c][1] - shape[c] * d[a][1]) * u
                            - (shape[a] * d[c][0] - shape[c] * d[a][0]) * v);
                    for (i, j, k, sign) in CYCLES {
                        out.k[(3 * a + i) * 3 * nodes + 3 * c + j] -= sign * q[k];
                    }
                }
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { skew: Some(self), ..Capabilities::default() }
    }
}

impl SkewTangent for OpenCavityPressure {
    fn blocks(&self) -> &Blocks {
        &self.rim
    }

    fn eval(&self, at: &At, b: usize, out: &mut BlockValues) {
        let nodes = self.rim.nodes(b);
        let p = self.intensity(at.clock());
        for (s, weight) in GAUSS {
            let (shape, slope) = edge_shape(nodes.len(), s);
            let dx: Vec3 = (0..nodes.len())
                .map(|a| {
                    let u = Vec3::from_column_slice(&at.x[3 * nodes[a] as usize..][..3]);
                    slope[a] * (self.reference[b * nodes.len() + a] + u)
                })
                .sum();
            for (a, c) in (0..nodes.len()).flat_map(|a| (0..=a).map(move |c| (a, c))) {
                let t = 0.5 * p * weight * shape[a] * shape[c] * dx;
                for (i, j, k, sign) in CYCLES {
                    out.k[(3 * a + i) * 3 * nodes.len() + 3 * c + j] += sign * t[k];
                }
            }
        }
    }
}

/// Gauss's three-point rule on \[0, 1\], exact to degree 5: N_a N_c x′ of a curved edge.
pub(super) const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Returns N and dN/ds of the nodes of an edge, with the mid-node last.
pub(super) fn edge_shape(nodes: usize, s: f64) -> ([f64; 3], [f64; 3]) {
    match nodes {
        2 => ([1.0 - s, s, 0.0], [-1.0, 1.0, 0.0]),
        _ => (
            [(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)],
            [4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s],
        ),
    }
}
