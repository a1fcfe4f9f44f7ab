//! Free rigid bodies in an impact: their rigid motions, and the rigid motion that is nearest to a velocity, for which the difference has the least
//! kinetic energy.
//!
//! ```text
//! v' = R (RᵀMR)⁻¹ RᵀM v      R: the six motions of the body where it is
//! ```
//!
//! For v = M⁻¹Hᵀ this is the response of a rigid body, R (RᵀMR)⁻¹ RᵀHᵀ.

use crate::math::tensor::Vec3;
use crate::solve::diagnosis::rigid_motions::RigidPartMotions;
use crate::solve::start::Start;
use crate::system::{Dofs, System};
use nalgebra::{DMatrix, DVector};

/// A free rigid body at its current position.
pub(super) struct FreeBody {
    dofs: Vec<usize>,
    /// Rigid motions R \[dofs × 6\]
    motions: DMatrix<f64>,
    /// Projection (RᵀMR)⁻¹ RᵀM \[6 × dofs\]
    nearest: DMatrix<f64>,
}

impl FreeBody {
    /// Finds the free rigid bodies of the system at displacement x, without prescribed dofs; empty if `places` \[nodes\] is.
    pub fn all(system: &System, mass: &Start, places: &[Vec3], x: &[f64]) -> Vec<Self> {
        if places.is_empty() {
            return Vec::new();
        }
        system
            .turning_bodies()
            .filter_map(|nodes| Self::new(system, mass, &RigidPartMotions::new(nodes, places, x)))
            .collect()
    }

    fn new(system: &System, mass: &Start, part: &RigidPartMotions) -> Option<Self> {
        let dofs: Vec<usize> = part.nodes.iter().flat_map(|&node| 3 * node as usize..3 * node as usize + 3).collect();
        let equations: Vec<usize> = dofs.iter().map(|&dof| system.dofs.equation[dof] as usize).collect();
        if equations.contains(&(Dofs::FIXED as usize)) {
            return None;
        }
        let (mut motions, mut momenta) = (DMatrix::zeros(dofs.len(), 6), DMatrix::zeros(dofs.len(), 6));
        for j in 0..6 {
            let unit = DVector::from_fn(6, |i, _| f64::from(u8::from(i == j)));
            for i in 0..part.nodes.len() {
                motions.fixed_view_mut::<3, 1>(3 * i, j).copy_from(&part.motion(i, &unit));
            }
            let of_part: Vec<(usize, f64)> = equations.iter().copied().zip(motions.column(j).iter().copied()).collect();
            let momentum = mass.momentum(&of_part);
            equations.iter().enumerate().for_each(|(row, &equation)| momenta[(row, j)] = momentum[equation]);
        }
        let nearest = motions.tr_mul(&momenta).cholesky()?.solve(&momenta.transpose());
        Some(Self { dofs, motions, nearest })
    }

    /// Replaces the velocities of the body among `v` \[dofs\] by the nearest rigid motion.
    pub fn make_rigid(&self, v: &mut [f64]) {
        let own = DVector::from_iterator(self.dofs.len(), self.dofs.iter().map(|&dof| v[dof]));
        let rigid = &self.motions * (&self.nearest * own);
        self.dofs.iter().zip(rigid.iter()).for_each(|(&dof, of_body)| v[dof] = *of_body);
    }
}
