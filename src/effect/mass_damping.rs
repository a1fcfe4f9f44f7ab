//! Mass-proportional damping.

use super::damping_work::work;
use super::mass::Mass;
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
            linear_in_rates: true,
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
