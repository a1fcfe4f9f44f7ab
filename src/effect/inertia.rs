//! Inertia: r = M a, ∂r/∂x = ca M; kinetic energy ½ v·Mv.

use super::mass::Mass;
use crate::system::{At, Blocks, Direction, Effect, EvalError, Local, Needs, Past, Role, Want};

pub struct Inertia {
    pub mass: Mass,
}

impl Effect for Inertia {
    fn name(&self) -> &str {
        "inertia"
    }

    fn role(&self) -> Role {
        Role::Kinetic
    }

    fn needs(&self) -> Needs {
        Needs { velocity: true, acceleration: true }
    }

    fn blocks(&self) -> &Blocks {
        &self.mass.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError> {
        out.energy = self.mass.apply(at.v, b, 0.0, 0.0, Want::Energy, out);
        self.mass.apply(at.a, b, 1.0, at.rates.ca, want, out);
        Ok(())
    }

    fn past(&self) -> Option<&dyn Past> {
        Some(self)
    }
}

impl Past for Inertia {
    fn along(&self, _: &At, direction: &Direction, b: usize, out: &mut Local) -> Result<(), EvalError> {
        self.mass.apply(direction.a, b, 1.0, 0.0, Want::Residual, out);
        Ok(())
    }
}
