//! Elastic forces: Π = ∫ ψ(F) dV, r_a = ∫ P ∂N_a/∂X dV, K_ab = ∫ ∂N_a/∂X A ∂N_b/∂X dV.
//!
//! Displacement formulation: tet4 with one point, tet10 with four. tet4 locks as ν → ½.

use super::cell::CellPoints;
use super::constitution::Constitution;
use super::stress::{PointStress, Stressed};
use crate::material::{Law, LawCard, LawError, Moduli};
use crate::math::tensor::Mat3;
use crate::mesh::TetMesh;
use crate::system::{At, Batch, Batched, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// A law on the cells of a region.
pub struct Elastic {
    name: String,
    law: Box<dyn Law>,
    points: Arc<CellPoints>,
}

impl Elastic {
    pub fn new(name: String, mesh: &TetMesh, cells: &[u32], law: Box<dyn Law>) -> Self {
        Self { name, law, points: Arc::new(CellPoints::new(mesh, cells)) }
    }
}

impl Effect for Elastic {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.points.integrate(&*self.law, &self.name, at.x, b, self.points.blocks.size(b), want, out)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { batched: Some(self), ..Capabilities::default() }
    }
}

impl Batched for Elastic {
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError> {
        self.points.integrate_batch(&*self.law, &self.name, at.x, first, want, out)
    }
}

impl PointStress for Elastic {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let at = |q| Ok(self.law.eval(&self.points.deformation_gradient(x, b, q), Want::Residual)?.p);
        (0..self.points.points()).map(at).collect()
    }

    fn has_small_strains(&self) -> bool {
        !self.law.info().objective
    }
}

impl Stressed for Elastic {
    fn displacement_only(&self) -> bool {
        true
    }

    fn moduli(&self) -> Moduli {
        self.law.small_strain()
    }

    fn constitution(&self) -> Option<Constitution<'_>> {
        let law = LawCard::of(&*self.law);
        Some(Constitution { law, points: &self.points, blocks: &self.points.blocks, pressure: None })
    }

    fn along(&self, _: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect> {
        Box::new(Self { name: self.name.clone(), law, points: self.points.clone() })
    }
}
