//! Stiffness-proportional damping r = β K_* v \[N\], β \[s\]: the stiffness term of Rayleigh 1877, for comparison with other
//! simulators. K_* is the tangent of the damped effects, at rest (K₀) or at the start of the step (K(xₙ)).
//!
//! Together with mass damping, C = αM + βK: a small vibration of angular frequency ω has the damping ratio α/2ω + βω/2. It is not objective: K₀
//! resists further rotation of a body that has rotated, K(xₙ) that of a body under stress; and K(xₙ) adds energy where it is indefinite. Within a
//! step K_* is constant, so that the tangent cᵥ β K_* is exact and symmetric.
//!
//! Its derivative with respect to xₙ needs ∂K/∂x, which is computed by eighth-order differences of K; each block copies the state for it.

use super::damping_work::work;
use crate::math::difference::EIGHTH;
use crate::math::tensor::Vec3;
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative, Perturbation, Want,
};
use std::sync::Arc;

/// State at which the stiffness is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stiffness {
    /// K₀, in the reference configuration
    Initial,
    /// K(xₙ), at the start of the step
    Last,
}

/// Reason why the stiffness of an effect cannot be damped.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Undamped {
    /// The effect has pressures, whose rate is not damped
    #[error("stiffness damping of a mixed formulation is not defined")]
    SecondField,
    /// The effect acts on means of positions: its blocks are lists of means, those of the damping lists of nodes
    #[error("stiffness damping of the effect {effect}, which acts on means of positions, is not defined")]
    OnMeans { effect: String },
}

/// Stiffness-proportional damping of some effects that store energy.
pub struct StiffnessDamping {
    beta: f64,
    stiffness: Stiffness,
    damped: Vec<Arc<dyn Effect>>,
    blocks: Blocks,
    /// \[blocks\] effect and its block
    source: Vec<(usize, usize)>,
    /// \[blocks\] shortest distance between two nodes at rest \[m\]
    sizes: Vec<f64>,
    /// \[displacements\] zeros, the displacement at rest \[m\]
    rest: Vec<f64>,
}

impl StiffnessDamping {
    /// Builds the damping with β in s; the nodes are at `points`.
    ///
    /// # Errors
    ///
    /// An effect has a second field or acts on means.
    pub fn new(
        damped: Vec<Arc<dyn Effect>>,
        beta: f64,
        stiffness: Stiffness,
        points: &[Vec3],
    ) -> Result<Self, Undamped> {
        if let Some(on_means) = damped.iter().find(|effect| effect.capabilities().means.is_some()) {
            return Err(Undamped::OnMeans { effect: on_means.name().into() });
        }
        let list = |e: usize| (0..damped[e].blocks().len()).map(move |b| (e, b));
        let source: Vec<(usize, usize)> = (0..damped.len()).flat_map(list).collect();
        if source.iter().any(|&(e, b)| !damped[e].blocks().scalars(b).is_empty()) {
            return Err(Undamped::SecondField);
        }
        let blocks = Blocks::new(source.iter().map(|&(e, b)| damped[e].blocks().nodes(b)));
        let distance = |i: u32, j: u32| (points[i as usize] - points[j as usize]).norm();
        let size = |nodes: &[u32]| {
            let pairs = nodes.iter().enumerate().flat_map(|(k, &i)| nodes[..k].iter().map(move |&j| (i, j)));
            pairs.fold(f64::INFINITY, |least, (i, j)| least.min(distance(i, j)))
        };
        let sizes = (0..blocks.len()).map(|b| size(blocks.nodes(b))).collect();
        Ok(Self { beta, stiffness, damped, blocks, source, sizes, rest: vec![0.0; 3 * points.len()] })
    }
}

impl Effect for StiffnessDamping {
    fn name(&self) -> &str {
        "stiffness_damping"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        let x = match self.stiffness {
            Stiffness::Initial => &self.rest,
            Stiffness::Last => at.old,
        };
        let k = self.tangent(at, x, b)?;
        add_product(&k, &self.blocks, at.v, b, 1.0, out);
        if want == Want::Tangent {
            out.k.iter_mut().zip(&k).for_each(|(out, k)| *out = at.rates.cv * k);
        }
        out.energy = work(&self.blocks, at, b, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: false },
            past: Some(self),
            linear_in_rates: self.stiffness == Stiffness::Initial,
            ..Capabilities::default()
        }
    }
}

impl PastDerivative for StiffnessDamping {
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        if self.stiffness == Stiffness::Initial {
            add_product(&self.tangent(at, &self.rest, b)?, &self.blocks, direction.v, b, 1.0, out);
            return Ok(());
        }
        add_product(&self.tangent(at, at.old, b)?, &self.blocks, direction.v, b, 1.0, out);
        self.turn(at, direction.old, b, out)
    }
}

/// Difference step h, as a strain: if K is analytic in strains below ½ and a cell is strained by 4h, the truncation error h⁸/630 of the ninth
/// derivative is 576 (4h/½)⁸/½ = 2e-14 of K; rounding adds 2ε/h = 4e-13.
const STRAIN: f64 = 1e-3;

impl StiffnessDamping {
    /// Returns β K of block `b` at displacement x \[n × n\], column ≤ row.
    fn tangent(&self, at: &At, x: &[f64], b: usize) -> Result<Vec<f64>, EvalError> {
        let (effect, block) = self.source[b];
        let mut elastic = BlockValues::new(self.blocks.size(b));
        self.damped[effect].eval(&At { x, old: x, ..*at }, block, Want::Tangent, &mut elastic)?;
        elastic.k.iter_mut().for_each(|k| *k *= self.beta);
        Ok(elastic.k)
    }

    /// Adds β (∂K/∂x dₙ) v at xₙ to r_e. This needs the third derivative of the energy, which laws do not provide; it is computed by differences of
    /// K.
    fn turn(&self, at: &At, change: &[f64], b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let dofs: Vec<usize> = self.blocks.dofs(b).map(|dof| dof as usize).collect();
        let mean =
            |i: usize| dofs.iter().skip(i).step_by(3).map(|&dof| change[dof]).sum::<f64>() * 3.0 / dofs.len() as f64;
        let translation = [mean(0), mean(1), mean(2)];
        let motion: Vec<f64> = dofs.iter().enumerate().map(|(k, &dof)| change[dof] - translation[k % 3]).collect();
        let size = motion.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
        if size == 0.0 {
            return Ok(());
        }
        let h = STRAIN * self.sizes[b] / size;
        let mut x = at.old.to_vec();
        for (j, weight) in (1..).zip(EIGHTH) {
            for sign in [1.0, -1.0] {
                let s = sign * f64::from(j) * h;
                dofs.iter().zip(&motion).for_each(|(&dof, d)| x[dof] = at.old[dof] + s * d);
                add_product(&self.tangent(at, &x, b)?, &self.blocks, at.v, b, sign * weight / h, out);
            }
        }
        Ok(())
    }
}

/// Adds factor · K v with the symmetric K_e of block `b` to r_e.
fn add_product(k: &[f64], blocks: &Blocks, v: &[f64], b: usize, factor: f64, out: &mut BlockValues) {
    let n = blocks.size(b);
    let v: Vec<f64> = blocks.dofs(b).map(|dof| factor * v[dof as usize]).collect();
    for row in 0..n {
        for column in 0..=row {
            let k = k[row * n + column];
            out.r[row] += k * v[column];
            if column < row {
                out.r[column] += k * v[row];
            }
        }
    }
}
