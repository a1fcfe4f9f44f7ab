//! Stiffness-proportional damping r = β K_* v [N], β [s]: the stiffness term of Rayleigh 1877, for comparison with other
//! simulators. K_* is the tangent of the effects that are damped, at rest (K₀) or at the start of the step (K(xₙ)).
//!
//! With mass damping it is C = αM + βK: a small vibration of angular frequency ω has the damping ratio α/2ω + βω/2. It is
//! not objective: K₀ resists a body that turns after it has turned, K(xₙ) one that turns under stress; and K(xₙ) feeds
//! energy in where it is indefinite. Within a step K_* is constant, so the tangent cᵥ β K_* is exact and symmetric.

use super::damping::work;
use crate::system::{At, Blocks, Effect, EvalError, Local, Needs, Role, Want};
use std::sync::Arc;

/// Where the stiffness is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stiffness {
    /// K₀, in the reference configuration
    Initial,
    /// K(xₙ), at the start of the step
    Last,
}

/// Damping of some effects that store energy.
pub struct StiffnessDamping {
    beta: f64,
    stiffness: Stiffness,
    damped: Vec<Arc<dyn Effect>>,
    blocks: Blocks,
    /// [blocks] effect and its block
    source: Vec<(usize, usize)>,
    /// [displacements] zeros, the displacement at rest [m]
    rest: Vec<f64>,
}

impl StiffnessDamping {
    /// None if one of the effects has a second field (pressure), whose rate is not damped. β in s, on `nodes` nodes.
    pub fn new(damped: Vec<Arc<dyn Effect>>, beta: f64, stiffness: Stiffness, nodes: usize) -> Option<Self> {
        let list = |e: usize| (0..damped[e].blocks().len()).map(move |b| (e, b));
        let source: Vec<(usize, usize)> = (0..damped.len()).flat_map(list).collect();
        if source.iter().any(|&(e, b)| !damped[e].blocks().scalars(b).is_empty()) {
            return None;
        }
        let blocks = Blocks::new(source.iter().map(|&(e, b)| damped[e].blocks().nodes(b)));
        Some(Self { beta, stiffness, damped, blocks, source, rest: vec![0.0; 3 * nodes] })
    }
}

impl Effect for StiffnessDamping {
    fn name(&self) -> &str {
        "stiffness_damping"
    }

    fn role(&self) -> Role {
        Role::Dissipative
    }

    fn needs(&self) -> Needs {
        Needs { velocity: true, acceleration: false }
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError> {
        if at.rates.cv == 0.0 {
            // Statics: t only orders the loads, nothing has a rate.
            return Ok(());
        }
        let x = match self.stiffness {
            Stiffness::Initial => &self.rest,
            Stiffness::Last => at.old,
        };
        let (effect, block) = self.source[b];
        let n = self.blocks.size(b);
        let mut elastic = Local::new(n);
        self.damped[effect].eval(&At { x, old: x, ..*at }, block, Want::Tangent, &mut elastic)?;
        let v: Vec<f64> = self.blocks.dofs(b).map(|dof| at.v[dof as usize]).collect();
        for row in 0..n {
            for column in 0..=row {
                let k = self.beta * elastic.k[row * n + column];
                out.r[row] += k * v[column];
                if column < row {
                    out.r[column] += k * v[row];
                }
                if want == Want::Tangent {
                    out.k[row * n + column] = at.rates.cv * k;
                }
            }
        }
        out.energy = work(&self.blocks, at, b, out);
        Ok(())
    }
}
