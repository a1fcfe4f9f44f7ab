//! Adjoint solutions: the derivatives of functionals with respect to changes of the equations of a static state.
//!
//! A remaining residual ρ and remaining gaps γ at a state change it by K Δx + H Δλ = −ρ, Hᵀ Δx − C Δλ = γ, with H = ∂c/∂x of the active constraints
//! and their compliance C. A functional J changes by −z·ρ + μ·γ, where
//!
//! ```text
//! K z + H μ = ∂J/∂x,   Hᵀ z − C μ = ∂J/∂λ.
//! ```
//!
//! Reactions R = r + H λ at the prescribed dofs p with weights w add K_fp w to the first right-hand side and h_p·w to the second.
//!
//! A parameter θ that changes the equations at a fixed state leaves ρ = r_θ + λ h_θ + K m + Σ h λ_max′ and γ = g_θ − h·m, where m is the motion of
//! the prescribed dofs and λ_max′ the change of multipliers at their limits. One product thus gives dJ/dθ for each of any number of parameters.
//!
//! Source: Becker & Rannacher, *Acta Numerica* 10 (2001), Section 2. Limits: statics; symmetric tangents.

use crate::math::linear::{Factor, LinearError, Method};
use crate::math::vector::dot;
use crate::solve::linear::multipliers::Schur;
use crate::solve::{Failure, Step};
use crate::system::{
    ConstraintKind, Dofs, EquationChange, Gradient, State, Want, WantedRows, add_products, constraint_changes,
    keep_prescribed,
};

/// The adjoint solution z and μ of one functional.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjoint {
    /// \[unknowns\] z \[unit of J per N\]; zero at prescribed dofs
    pub z: Vec<f64>,
    /// \[constraints\] μ; zero for a constraint that is not active
    pub mu: Vec<f64>,
}

impl Adjoint {
    /// Derivatives of the functional with this `gradient` with respect to parameters that change the equations by `own` at the converged `state`.
    pub fn along(
        &self,
        gradient: &Gradient,
        step: &Step,
        state: &State,
        own: &[EquationChange],
    ) -> Result<Vec<f64>, Failure> {
        let (system, at) = (step.system, step.at(state));
        let is_at_limit =
            |c: usize| matches!(system.constraints[c].kind(), ConstraintKind::Bounded(most) if state.lambda[c] >= most);
        let at_limits = |change: &EquationChange| -> Vec<f64> {
            change.limits.iter().enumerate().map(|(c, limit)| if is_at_limit(c) { *limit } else { 0.0 }).collect()
        };
        let limits: Vec<Vec<f64>> = own.iter().map(at_limits).collect();
        let motions: Vec<&[f64]> = own.iter().map(|change| &change.motion[..]).collect();
        let directions: Vec<(&[f64], &[f64])> = motions.iter().zip(&limits).map(|(m, l)| (*m, &l[..])).collect();
        let mut rho: Vec<Vec<f64>> = own.iter().map(|change| change.residual.clone()).collect();
        for rows in [WantedRows::Free, WantedRows::Prescribed] {
            add_products(system, &at, &state.lambda, rows, &directions, &mut rho).map_err(Failure::Eval)?;
        }
        let gaps = constraint_changes(system, &at, &motions).map_err(Failure::Eval)?;
        let of = |k: usize| {
            let held = State { x: own[k].motion.clone(), lambda: limits[k].clone(), ..system.rest() };
            let gamma: Vec<f64> = own[k].gaps.iter().zip(&gaps[k]).map(|(own, moved)| own - moved).collect();
            let mut reactions = rho[k].clone();
            keep_prescribed(system, &mut reactions);
            // z is zero at prescribed dofs, whose rows are the reactions
            gradient.along(&held, &reactions) - dot(&self.z, &rho[k]) + dot(&self.mu, &gamma)
        };
        Ok((0..own.len()).map(of).collect())
    }
}

/// Computes the adjoint solutions of functionals with these gradients, with one factorisation of the tangent at `state`.
pub fn adjoints(method: Method, step: &Step, state: &State, of: &[Gradient]) -> Result<Vec<Adjoint>, Failure> {
    let (system, at) = (step.system, step.at(state));
    let assemble = |increment: Option<&[f64]>| {
        let mut sums = system.workspace();
        system.assemble(&at, &state.lambda, Want::Tangent, increment, &mut sums).map_err(Failure::Eval)?;
        Ok::<_, Failure>(sums)
    };
    let sums = assemble(None)?;
    let mut factor = Factor::by(method, sums.pattern.clone(), system.definiteness());
    factor.move_to(&state.x);
    factor.factorise(&sums.k).map_err(Failure::Linear)?;
    let holds = |c: &usize| system.constraints[*c].kind().holds(state.lambda[*c]);
    let held: Vec<usize> = (0..state.lambda.len()).filter(holds).collect();
    let rows: Vec<Vec<f64>> = held.iter().map(|&c| sums.gradient[c].clone()).collect();
    let Schur { z: along, s, .. } = Schur::new(&mut factor, &sums, system, &held, &rows).map_err(Failure::Linear)?;
    let (n, m) = (system.dofs.free.len(), held.len());
    let lu = nalgebra::DMatrix::from_row_slice(m, m, &s).lu();
    let mut solve = |gradient: &Gradient| {
        let (mut by_x, mut by_lambda) = (vec![0.0; n], vec![0.0; state.lambda.len()]);
        for (dof, weight) in &gradient.x {
            let equation = system.dofs.equation[*dof as usize];
            if equation != Dofs::FIXED {
                by_x[equation as usize] += weight;
            }
        }
        gradient.lambda.iter().for_each(|(c, weight)| by_lambda[*c] += weight);
        if !gradient.reaction.is_empty() {
            let mut w = vec![0.0; state.x.len()];
            gradient.reaction.iter().for_each(|(dof, weight)| w[*dof as usize] += weight);
            let with = assemble(Some(&w))?;
            by_x.iter_mut().zip(&with.increment_force).for_each(|(a, k)| *a += k);
            by_lambda.iter_mut().zip(&with.increment_gap).for_each(|(b, h)| *b += h);
        }
        factor.solve(&sums.k, &mut by_x).map_err(Failure::Linear)?;
        let mut mu = vec![0.0; state.lambda.len()];
        if m > 0 {
            let b = nalgebra::DVector::from_fn(m, |i, _| dot(&rows[i], &by_x) - by_lambda[held[i]]);
            let solved = lu.solve(&b).ok_or(Failure::Linear(LinearError::Singular))?;
            for ((&c, column), value) in held.iter().zip(along.chunks_exact(n)).zip(&solved) {
                mu[c] = *value;
                by_x.iter_mut().zip(column).for_each(|(z, column)| *z -= column * value);
            }
        }
        let mut z = vec![0.0; state.x.len()];
        system.expand(&by_x, &mut z);
        Ok(Adjoint { z, mu })
    };
    of.iter().map(&mut solve).collect()
}
