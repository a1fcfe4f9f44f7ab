//! Damping: mass-proportional, and viscous in the bulk.

use super::cell::CellPoints;
use super::mass::Mass;
use crate::math::tensor::{Mat3, ZERO9};
use crate::mesh::TetMesh;
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative, Perturbation, Want,
};

/// Mass-proportional damping: r = α M v \[N\], α \[1/s\] (the mass term of Rayleigh 1877).
pub struct MassDamping {
    pub alpha: f64,
    pub mass: Mass,
}

impl Effect for MassDamping {
    fn name(&self) -> &str {
        "mass_damping"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.mass.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.mass.apply(at.v, b, self.alpha, at.rates.cv, want, out);
        out.energy = work(&self.mass.blocks, at, b, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: false },
            past: Some(self),
            ..Capabilities::default()
        }
    }
}

impl PastDerivative for MassDamping {
    fn along(&self, _: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        self.mass.apply(direction.v, b, self.alpha, 0.0, Want::Residual, out);
        Ok(())
    }
}

/// Kelvin–Voigt damping S_v = η Ė with Ė = (E − Eₙ)/Δt, E = ½(FᵀF − I), η \[Pa s\].
///
/// Objective, with a symmetric exact tangent (it derives from the incremental potential ½ηΔt ‖Ė‖²); of first order in Δt
/// under every integrator.
pub struct ViscousDamping {
    eta: f64,
    points: CellPoints,
}

impl ViscousDamping {
    /// On the cells of a region, η in Pa s.
    pub fn new(mesh: &TetMesh, cells: &[u32], eta: f64) -> Self {
        Self { eta, points: CellPoints::new(mesh, cells) }
    }
}

impl Effect for ViscousDamping {
    fn name(&self) -> &str {
        "viscous_damping"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.rates.cv == 0.0 {
            // Statics: t only orders the loads, nothing has a rate.
            return Ok(());
        }
        let c = self.eta / at.dt;
        for q in 0..self.points.points() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let old = self.points.deformation_gradient(at.old, b, q);
            let s: Mat3 = 0.5 * c * (f.tr_mul(&f) - old.tr_mul(&old));
            let mut a = ZERO9;
            if want == Want::Tangent {
                // A_iJkL = δ_ik S_LJ + ½c (F_iL F_kJ + δ_LJ F_iM F_kM)
                let b = f * f.transpose();
                for (row, a) in a.iter_mut().enumerate() {
                    let (i, j) = (row / 3, row % 3);
                    for (column, a) in a.iter_mut().enumerate() {
                        let (k, l) = (column / 3, column % 3);
                        let geometric = if i == k { s[(l, j)] } else { 0.0 };
                        let diagonal = if l == j { b[(i, k)] } else { 0.0 };
                        *a = geometric + 0.5 * c * (f[(i, l)] * f[(k, j)] + diagonal);
                    }
                }
            }
            self.points.scatter(b, q, self.points.blocks.size(b), &(f * s), &a, want, out);
        }
        out.energy = work(&self.points.blocks, at, b, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: false },
            past: Some(self),
            ..Capabilities::default()
        }
    }
}

impl PastDerivative for ViscousDamping {
    /// S_v changes by −(η/Δt) sym(FₙᵀdFₙ).
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.rates.cv == 0.0 {
            return Ok(());
        }
        for q in 0..self.points.points() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let old = self.points.deformation_gradient(at.old, b, q);
            let half = old.tr_mul(&(self.points.deformation_gradient(direction.old, b, q) - Mat3::identity()));
            let s = -0.5 * self.eta / at.dt * (half + half.transpose());
            self.points.scatter(b, q, self.points.blocks.size(b), &(f * s), &ZERO9, Want::Residual, out);
        }
        Ok(())
    }
}

/// r_e·(x − old) of block `b` \[J\].
pub(super) fn work(blocks: &Blocks, at: &At, b: usize, out: &BlockValues) -> f64 {
    let dofs = blocks.nodes(b).iter().flat_map(|&n| 3 * n as usize..3 * n as usize + 3);
    dofs.zip(&out.r).map(|(dof, r)| r * (at.x[dof] - at.old[dof])).sum()
}
