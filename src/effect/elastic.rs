//! Elastic forces: Π = ∫ ψ(F) dV, r_a = ∫ P ∂N_a/∂X dV, K_ab = ∫ ∂N_a/∂X A ∂N_b/∂X dV.
//!
//! Displacement formulation: tet4 with one point, tet10 with four. tet4 locks as ν → ½.

use super::cell::CellPoints;
use crate::material::{Law, LawError};
use crate::math::tensor::Mat3;
use crate::mesh::TetMesh;
use crate::system::{At, Blocks, Effect, EvalError, Local, Role, Want};

/// A law on the cells of a region.
pub struct Elastic {
    name: String,
    law: Box<dyn Law>,
    points: CellPoints,
}

impl Elastic {
    pub fn new(name: String, mesh: &TetMesh, cells: &[u32], law: Box<dyn Law>) -> Self {
        Self { name, law, points: CellPoints::new(mesh, cells) }
    }

    /// For each cell of the region: index in the mesh, volume [m³] and F at each of its points with its weight [m³].
    pub fn deformation<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (u32, Vec<(f64, Mat3)>)> + 'a {
        self.points.cells.iter().enumerate().map(move |(b, &c)| {
            let at = |q| (self.points.weight(b, q), self.points.deformation_gradient(x, b, q));
            (c, (0..self.points.points()).map(at).collect())
        })
    }
}

impl Effect for Elastic {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> Role {
        Role::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError> {
        for q in 0..self.points.points() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let response = self.law.eval(&f, want).map_err(|LawError::Inverted { j }| EvalError::Inverted {
                effect: self.name.clone(),
                cell: self.points.cells[b] as usize,
                j,
            })?;
            out.energy += self.points.weight(b, q) * response.psi;
            if want > Want::Energy {
                self.points.scatter(b, q, self.points.blocks.size(b), &response.p, &response.a, want, out);
            }
        }
        Ok(())
    }
}
