//! Inertia: r = M a, ∂r/∂x = ca M; kinetic energy ½ v·Mv.

use super::mass::Mass;
use crate::system::{
    At, Batch, Batched, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative,
    Perturbation, Want,
};

pub struct Inertia {
    pub mass: Mass,
}

impl Effect for Inertia {
    fn name(&self) -> &str {
        "inertia"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Kinetic
    }

    fn blocks(&self) -> &Blocks {
        &self.mass.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        out.energy = self.mass.energy(at.v, b);
        self.mass.apply(at.a, b, 1.0, at.rates.ca, want, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: true },
            past: Some(self),
            batched: Some(self),
            linear_in_rates: true,
            ..Capabilities::default()
        }
    }
}

impl Batched for Inertia {
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError> {
        out.energy = self.mass.energy_of_batch(at.v, first);
        if want == Want::Tangent {
            let n = self.blocks().size(first);
            out.clear_rows(n, 0..n);
        }
        self.mass.apply_batch(at.a, first, 1.0, at.rates.ca, want, out);
        Ok(())
    }
}

impl PastDerivative for Inertia {
    fn along(&self, _: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        self.mass.apply(direction.a, b, 1.0, 0.0, Want::Residual, out);
        Ok(())
    }
}
