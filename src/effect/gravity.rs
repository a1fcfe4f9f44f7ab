//! Gravity: φ = −∫ ρ ĝ·x dV per unit of s(t), with the acceleration g = s(t) ĝ \[m/s²\].

use super::dead_load::DeadLoad;
use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::system::{At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Want};

/// Weight of a region: the dead load of its nodal masses.
pub struct Gravity(DeadLoad);

impl Gravity {
    /// Builds the weight of cells of density `rho` \[kg/m³\]; `direction` is a unit vector, `acceleration` its signal \[m/s²\].
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
        let masses: Vec<(u32, f64)> = nodes.iter().map(|&k| (k, nodal[k as usize])).collect();
        Self(DeadLoad::new("gravity".to_string(), &masses, direction, acceleration))
    }
}

impl Effect for Gravity {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn role(&self) -> EnergyRole {
        self.0.role()
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.0.intensity(now)
    }

    fn blocks(&self) -> &Blocks {
        self.0.blocks()
    }

    fn capabilities(&self) -> Capabilities<'_> {
        self.0.capabilities()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.0.eval(at, b, want, out)
    }
}
