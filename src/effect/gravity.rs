//! Gravity: φ = −∫ ρ ĝ·x dV per unit of s(t), with the acceleration g = s(t) ĝ \[m/s²\].

use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::system::{At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Want};

/// Weight of a region; `direction` is a unit vector, `acceleration` its signal \[m/s²\].
pub struct Gravity {
    direction: Vec3,
    acceleration: Signal,
    blocks: Blocks,
    /// \[blocks\] ∫ ρ N_a dV \[kg\]
    mass: Vec<f64>,
}

impl Gravity {
    pub fn new(mesh: &TetMesh, cells: &[u32], rho: f64, direction: Vec3, acceleration: Signal) -> Self {
        let rule = quadrature::tet(4);
        let mut nodal = vec![0.0; mesh.points.len()];
        for &c in cells {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let shape = element::cell_shape(mesh.order, xi);
                let factor = rho * w * mesh.jacobian(c as usize, xi).determinant();
                for (&node, n) in mesh.cell(c as usize).iter().zip(shape) {
                    nodal[node as usize] += factor * n;
                }
            }
        }
        let mut nodes: Vec<u32> = cells.iter().flat_map(|&c| mesh.cell(c as usize)).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mass = nodes.iter().map(|&k| nodal[k as usize]).collect();
        Self { direction, acceleration, blocks: Blocks::new(nodes.chunks(1)), mass }
    }
}

impl Effect for Gravity {
    fn name(&self) -> &str {
        "gravity"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.acceleration.at(now)
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { degree: Some(0), ..Capabilities::default() }
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let dof = 3 * self.blocks.nodes(b)[0] as usize;
        let s = if want > Want::Energy { self.acceleration.at(at.clock()) } else { 0.0 };
        for i in 0..3 {
            let unit = -self.mass[b] * self.direction[i];
            out.energy += unit * at.x[dof + i];
            out.r[i] = s * unit;
        }
        Ok(())
    }
}
