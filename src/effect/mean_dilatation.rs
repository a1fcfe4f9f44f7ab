//! Mean dilatation on tet10 (P2 displacement, P0 pressure, condensed): Π = Σ_cells ∫ ψ̃(F) dV + ½κ V Ḡ² with the cell mean
//! Ḡ = (1/V) ∫ G(J) dV (Nagtegaal, Parks & Rice 1974; Simo, Taylor & Pister 1985).
//!
//! Positive definite wherever the law is, so that Cholesky factorisation remains applicable; the pressure is one order less accurate than with
//! Taylor–Hood. On tet4 it would be identical to the displacement formulation, and is refused.

use super::cell::CellPoints;
use super::mixed::add_pressure_tangent;
use super::stress::{PointStress, Stressed};
use crate::material::{Law, LawError, Moduli, Volumetric};
use crate::math::tensor::{Mat3, cofactor, det_minus_one};
use crate::mesh::{Order, TetMesh};
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// A law with a split on the tet10 cells of a region.
pub struct MeanDilatation {
    name: String,
    /// The law without its volumetric part
    rest: Box<dyn Law>,
    volumetric: Volumetric,
    /// Hooke's constants of the whole law at F = I
    hooke: Moduli,
    points: Arc<CellPoints>,
}

impl MeanDilatation {
    /// Builds the effect; `None` for laws without a split, and on tet4.
    pub fn new(name: String, mesh: &TetMesh, cells: &[u32], law: &dyn Law) -> Option<Self> {
        let (rest, volumetric) = law.split()?;
        (mesh.order == Order::Quadratic).then(|| Self {
            name,
            rest,
            volumetric,
            hooke: law.small_strain(),
            points: Arc::new(CellPoints::new(mesh, cells)),
        })
    }

    /// V \[m³\] and Ḡ \[–\] of block `b`.
    fn mean_gap(&self, x: &[f64], b: usize) -> Result<(f64, f64), LawError> {
        let (mut volume, mut sum) = (0.0, 0.0);
        for q in 0..self.points.points() {
            let (g, ..) = self.volumetric.gap(dilatation(&self.points.deformation_gradient(x, b, q)))?;
            volume += self.points.weight(b, q);
            sum += self.points.weight(b, q) * g;
        }
        Ok((volume, sum / volume))
    }
}

/// Returns J − 1.
fn dilatation(f: &Mat3) -> f64 {
    det_minus_one(&(f - Mat3::identity()))
}

impl Effect for MeanDilatation {
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
        let undefined = |e| EvalError::of_law(&self.name, self.points.cells[b] as usize, e);
        let points = self.points.points();
        let (volume, mean) = self.mean_gap(at.x, b).map_err(undefined)?;
        // The pressure of the cell
        let p = self.volumetric.kappa * mean;
        out.energy = 0.5 * volume * p * mean;
        let n = self.points.blocks.size(b);
        let mut gradient = vec![0.0; n];
        for q in 0..points {
            let f = self.points.deformation_gradient(at.x, b, q);
            let response = self.rest.eval(&f, want).map_err(undefined)?;
            let (_, dg, d2g) = self.volumetric.gap(dilatation(&f)).map_err(undefined)?;
            let w = self.points.weight(b, q);
            out.energy += w * response.psi;
            if want < Want::Residual {
                continue;
            }
            let cof = cofactor(&f);
            let mut a = response.a;
            if want == Want::Tangent {
                add_pressure_tangent(&mut a, &f, &cof, p * dg, p * d2g);
                for (node, coupling) in self.points.contract(b, q, &cof).enumerate() {
                    let entries = &mut gradient[3 * node..][..3];
                    entries.iter_mut().zip(coupling).for_each(|(g, b)| *g += w * dg * b);
                }
            }
            self.points.scatter(b, q, n, &(response.p + p * dg * cof), &a, want, out);
        }
        if want == Want::Tangent {
            // ∂(V Ḡ)/∂u ⊗ ∂(V Ḡ)/∂u κ/V
            for row in 0..n {
                for column in 0..=row {
                    out.k[row * n + column] += self.volumetric.kappa / volume * gradient[row] * gradient[column];
                }
            }
        }
        Ok(())
    }
}

impl PointStress for MeanDilatation {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let (_, mean) = self.mean_gap(x, b)?;
        let at = |q| {
            let f = self.points.deformation_gradient(x, b, q);
            let (_, dg, _) = self.volumetric.gap(dilatation(&f))?;
            Ok(self.rest.eval(&f, Want::Residual)?.p + self.volumetric.kappa * mean * dg * cofactor(&f))
        };
        (0..self.points.points()).map(at).collect()
    }
}

impl Stressed for MeanDilatation {
    fn displacement_only(&self) -> bool {
        false
    }

    fn moduli(&self) -> Moduli {
        self.hooke
    }

    fn volume_gaps(&self, x: &[f64], b: usize) -> Option<Vec<(f64, f64)>> {
        let (_, mean) = self.mean_gap(x, b).ok()?;
        let at = |q| {
            let dilatation = dilatation(&self.points.deformation_gradient(x, b, q));
            Some((1.0 + dilatation, self.volumetric.gap(dilatation).ok()?.0 - mean))
        };
        (0..self.points.points()).map(at).collect()
    }

    /// Derivative of the effect with respect to a constant of its law: Π is linear in ψ̃ and κ.
    fn along(&self, _: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect> {
        let (rest, volumetric) = law.split().expect("the derivative of a law splits where the law does");
        let (name, hooke, points) = (self.name.clone(), law.small_strain(), self.points.clone());
        Box::new(Self { name, rest, volumetric, hooke, points })
    }
}
