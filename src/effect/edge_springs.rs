//! Springs on the edges of a mesh, the elastic part of a mass–spring–damper body: Π = Σ ½ k (l − l₀)², r_j = k (l − l₀) τ,
//! K = k ττᵀ + k (1 − l₀/l)(I − ττᵀ).
//!
//! k is the same on every edge, as in comparable simulators, or k = E Σ_T V_T / l₀² over the cells around the edge (Van Gelder 1998, the 3-D form of
//! his stiffness of triangle area over squared edge length). The second spreads 6 E V = Σ k l₀² over the body; with edges distributed uniformly over
//! all directions the small-strain tangent is then that of Hooke's law with λ = μ = ⅖ E, Young's modulus E and ν = ¼, the only ν that central forces
//! allow (Cauchy's relation λ = μ). On a given mesh it is anisotropic and differs from this. Linear cells only: springs along a straight chain do not
//! hold a mid-node.

use super::edges::{Edges, add_force, longer};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};

/// A linear spring on each edge, at rest in the reference configuration.
pub struct EdgeSprings {
    edges: Edges,
    /// \[edges\] k \[N/m\]
    stiffness: Vec<f64>,
}

impl EdgeSprings {
    /// Puts springs of one stiffness k \[N/m\] on the edges of some cells. The body stiffens as 1/h when the mesh is refined.
    pub fn uniform(mesh: &TetMesh, cells: &[u32], k: f64) -> Self {
        let (edges, around) = Edges::of_cells(mesh, cells);
        Self { edges, stiffness: vec![k; around.len()] }
    }

    /// Puts springs of the stiffness k = E Σ_T V_T / l₀² on the edges of some cells, with E \[Pa\].
    pub fn of_modulus(mesh: &TetMesh, cells: &[u32], e: f64) -> Self {
        let (edges, around) = Edges::of_cells(mesh, cells);
        let stiffness =
            around.iter().enumerate().map(|(b, volume)| e * volume / edges.rest(b).norm_squared()).collect();
        Self { edges, stiffness }
    }

    /// Puts springs of one stiffness k \[N/m\] between pairs of nodes.
    pub fn between(points: &[Vec3], pairs: &[[u32; 2]], k: f64) -> Self {
        Self { edges: Edges::between(points, pairs), stiffness: vec![k; pairs.len()] }
    }
}

impl Effect for EdgeSprings {
    fn name(&self) -> &str {
        "edge_springs"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.edges.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (k, rest, stretching) = (self.stiffness[b], self.edges.rest(b), self.edges.stretching(at.x, b));
        let elongation = longer(rest, stretching);
        out.energy = 0.5 * k * elongation * elongation;
        if want > Want::Energy {
            let (l, tau) = self.edges.direction(self.name(), b, rest + stretching)?;
            let n = k * elongation;
            add_force(tau, n, k, n / l, want, out);
        }
        Ok(())
    }
}
