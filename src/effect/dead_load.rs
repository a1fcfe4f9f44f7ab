//! Dead load: a force of fixed direction on a weighted mean of nodes, φ = −Σ_i w_i d·u_i per unit of s(t), r_i = −s w_i d.
//!
//! With the weights of an embedded point or ball (Σ w = 1, [`crate::mesh::embed`]) it is a force s(t) \[N\] there: the embedded point moves as Σ w_i
//! u_i, and the transpose of that map distributes the force to the nodes, so that the power is the same. With w_i = ∫ N_i dA it is a traction s(t)
//! \[Pa\] per reference area, with w_i = ∫ ρ N_i dV a weight. The direction does not rotate with the body; for a pressure that follows the surface
//! use a cavity.

use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::system::{At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, PolynomialLoad, Want};

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
    /// Builds a load from pairs (node, w_i) of an embedded point or patch, areas or masses; `direction` is a unit vector, `intensity` the signal s
    /// \[N\], \[Pa\] or \[m/s²\].
    pub fn new(name: String, weights: &[(u32, f64)], direction: Vec3, intensity: Signal) -> Self {
        let (nodes, weights): (Vec<u32>, Vec<f64>) = weights.iter().copied().unzip();
        Self { name, direction, intensity, blocks: Blocks::new(nodes.chunks(1)), weights }
    }

    /// Residual of component `i` on block `b` per unit of intensity.
    fn unit(&self, b: usize, i: usize) -> f64 {
        -self.weights[b] * self.direction[i]
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
        Capabilities { polynomial: Some(self), ..Capabilities::default() }
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let dof = 3 * self.blocks.nodes(b)[0] as usize;
        let s = if want > Want::Energy { self.intensity.at(at.clock()) } else { 0.0 };
        for i in 0..3 {
            let unit = self.unit(b, i);
            out.energy += unit * at.x[dof + i];
            out.r[i] = s * unit;
        }
        Ok(())
    }
}

impl PolynomialLoad for DeadLoad {
    fn degree(&self) -> usize {
        0
    }

    fn unit_residual(&self, _: &[f64], b: usize, out: &mut BlockValues) {
        (0..3).for_each(|i| out.r[i] = self.unit(b, i));
    }
}
