//! Direct differentiation of a static equilibrium r(x, θ) + λ h(x) = 0, g(x) = target − c(x) by parameters θ:
//!
//! K x′ + Σ h λ′ = −∂r/∂θ, h·x′ = 0 on a taut row, λ′ = 0 on a slack one,
//!
//! K and h = ∂c/∂x at the converged state: with Z = K⁻¹H and S = HᵀZ of the taut rows, y = −K⁻¹ ∂r/∂θ, S λ′ = Hᵀy and
//! x′ = y − Z λ′. The same for every path of loading where nothing remembers it, so no step needs the one before.
//!
//! Source: Choi & Kim, *Structural Sensitivity Analysis and Optimization 2: Nonlinear Systems and Applications*, 2005.
//! Limits: statics without history, prescribed motions and targets that do not depend on θ; at a row that is just taut
//! (λ = 0 and g = 0) the answer has two derivatives, and the one of the slack side is given.

use super::Failure;
use super::multipliers::Schur;
use crate::math::linear::{Factor, LinearError, dot};
use crate::system::{Assembled, At, Effect, Rates, State, System, Want};

/// Derivative of an equilibrium by one parameter θ.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// [unknowns] ∂x/∂θ
    pub x: Vec<f64>,
    /// [constraints] ∂λ/∂θ
    pub lambda: Vec<f64>,
    /// [unknowns] ∂/∂θ of the residual at prescribed dofs, the reaction; not used elsewhere
    pub reaction: Vec<f64>,
}

/// Factorisation and sums of its own, beside those of the run.
pub struct Differentiator<'a> {
    system: &'a System,
    factor: Factor,
    sums: Assembled,
}

impl<'a> Differentiator<'a> {
    pub fn new(system: &'a System) -> Self {
        let factor = match system.scalar_equations() {
            0 => Factor::new(system.pattern.clone()),
            _ => Factor::indefinite(system.pattern.clone()),
        };
        Self { system, factor, sums: system.workspace() }
    }

    /// At a converged static state; `by` holds for each θ the effects whose residuals sum to ∂r/∂θ.
    pub fn at(&mut self, state: &State, by: &[Vec<Box<dyn Effect>>]) -> Result<Vec<Change>, Failure> {
        let Self { system, factor, sums } = self;
        let State { t, x, v, a, history, lambda, inputs, .. } = state;
        let rates = Rates::default();
        let at = At { t: *t, dt: f64::INFINITY, x, v, a, old: x, history, inputs, rates };
        system.assemble(&at, lambda, Want::Tangent, None, sums).map_err(Failure::Eval)?;
        factor.factorise(&sums.k).map_err(Failure::Linear)?;
        // A slack row is none: it is dropped from H.
        let taut: Vec<usize> = (0..lambda.len()).filter(|&c| !system.is_one_sided(c) || lambda[c] > 0.0).collect();
        let all = std::mem::take(&mut sums.gradient);
        sums.gradient = taut.iter().map(|&c| all[c].clone()).collect();
        let schur = Schur::new(factor, sums);
        let rows = std::mem::replace(&mut sums.gradient, all);
        let Schur { z, s, .. } = schur.map_err(Failure::Linear)?;
        let m = taut.len();
        let lu = nalgebra::DMatrix::from_row_slice(m, m, &s).lu();
        let (n, unknowns) = (system.dofs.free.len(), x.len());
        let mut changes = Vec::with_capacity(by.len());
        for effects in by {
            let mut reaction = vec![0.0; unknowns];
            for effect in effects {
                system.add_residual(effect.as_ref(), &at, &mut reaction).map_err(Failure::Eval)?;
            }
            let mut y = system.restrict(&reaction);
            y.iter_mut().for_each(|y| *y = -*y);
            factor.solve(&sums.k, &mut y).map_err(Failure::Linear)?;
            let mut rate = vec![0.0; lambda.len()];
            if m > 0 {
                let along = nalgebra::DVector::from_fn(m, |i, _| dot(&rows[i], &y));
                let solved = lu.solve(&along).ok_or(Failure::Linear(LinearError::Singular))?;
                for ((&c, z), value) in taut.iter().zip(z.chunks_exact(n)).zip(&solved) {
                    rate[c] = *value;
                    y.iter_mut().zip(z).for_each(|(y, z)| *y -= z * value);
                }
            }
            let mut full = vec![0.0; unknowns];
            system.dofs.free.iter().zip(y).for_each(|(&dof, y)| full[dof as usize] = y);
            changes.push(Change { x: full, lambda: rate, reaction });
        }
        let mut reactions: Vec<Vec<f64>> = changes.iter_mut().map(|c| std::mem::take(&mut c.reaction)).collect();
        let directions: Vec<(&[f64], &[f64])> = changes.iter().map(|c| (&c.x[..], &c.lambda[..])).collect();
        system.add_reactions(&at, lambda, &directions, &mut reactions).map_err(Failure::Eval)?;
        changes.iter_mut().zip(reactions).for_each(|(c, reaction)| c.reaction = reaction);
        Ok(changes)
    }
}
