//! Derivative of the mixed formulation with respect to a constant θ of its law, at fixed displacements and pressures:
//!
//! ∂Π/∂θ = ∫ ∂ψ̃/∂θ dV − ½ Σ_cd p_c ∂C_cd/∂θ p_d, C_cd = ∫ N_c N_d/κ + (α/μ)(N_c − ΠN_c)(N_d − ΠN_d) dV
//!
//! p G(J) contains no constant. The unit s of the unknown π = p/s is kept fixed: it only scales the unknown and affects no displacement.

use super::cell::CellPoints;
use crate::material::Law;
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// The derivative ∂/∂θ of a [`super::MixedElastic`].
pub(super) struct MixedAlong {
    pub(super) name: String,
    /// ∂ψ̃/∂θ
    pub(super) rest: Box<dyn Law>,
    pub(super) points: Arc<CellPoints>,
    pub(super) blocks: Blocks,
    /// \[cells\] s² ∂C/∂θ
    pub(super) compliance: Vec<[[f64; 4]; 4]>,
}

impl Effect for MixedAlong {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let n = self.blocks.size(b);
        self.points.integrate(&*self.rest, &self.name, at.x, b, n, want, out)?;
        let pi: [f64; 4] = std::array::from_fn(|c| at.x[self.blocks.scalars(b)[c] as usize]);
        for (c, compliance) in self.compliance[b].iter().enumerate() {
            let row: f64 = compliance.iter().zip(&pi).map(|(k, p)| k * p).sum();
            out.energy -= 0.5 * row * pi[c];
            out.r[n - 4 + c] -= row;
            if want == Want::Tangent {
                let entries = &mut out.k[(n - 4 + c) * n + n - 4..][..4];
                entries.iter_mut().zip(compliance).for_each(|(k, c)| *k -= c);
            }
        }
        Ok(())
    }
}
