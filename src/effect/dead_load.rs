//! Dead load: a force of fixed direction on a weighted mean of nodes, φ = −Σ_i w_i d·u_i per unit of s(t), r_i = −s w_i d.
//!
//! With the weights of an embedded point or ball (Σ w = 1, [`crate::mesh::embed`]) it is a force s(t) \[N\] there: the
//! embedded point moves as Σ w_i u_i, and the transpose of that map takes the force to the nodes, so that its power is the
//! same on both sides. With w_i = ∫ N_i dA it is a traction s(t) \[Pa\] per reference area, with w_i = ∫ ρ N_i dV a weight. The direction does not turn with
//! the body; a pressure that follows the surface is a cavity.

use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::system::{At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Want};

/// Dead load on nodes.
pub struct DeadLoad {
    name: String,
    direction: Vec3,
    intensity: Signal,
    blocks: Blocks,
    /// \[blocks\] w_i \[–\], \[m²\] or \[kg\]
    weights: Vec<f64>,
}

impl DeadLoad {
    /// (node, w_i): of an embedded point or patch, areas or masses; `direction` is a unit vector, `intensity` its signal \[N\], \[Pa\] or
    /// \[m/s²\].
    pub fn new(name: String, weights: &[(u32, f64)], direction: Vec3, intensity: Signal) -> Self {
        let (nodes, weights): (Vec<u32>, Vec<f64>) = weights.iter().copied().unzip();
        Self { name, direction, intensity, blocks: Blocks::new(nodes.chunks(1)), weights }
    }
}

impl Effect for DeadLoad {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.intensity.at(now)
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { degree: Some(0), ..Capabilities::default() }
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let dof = 3 * self.blocks.nodes(b)[0] as usize;
        let s = if want > Want::Energy { self.intensity.at(at.clock()) } else { 0.0 };
        for i in 0..3 {
            let unit = -self.weights[b] * self.direction[i];
            out.energy += unit * at.x[dof + i];
            out.r[i] = s * unit;
        }
        Ok(())
    }
}
