//! Direct differentiation of the states of a run by parameters θ, step by step. At the end of a step
//! r(x, v, a, xₙ, hₙ; θ) + λ h(x) = 0 and g(x) = target − c(x), where v and a are linear in x and the past
//! (xₙ, vₙ, aₙ, qₙ). So
//!
//! K x′ + Σ h λ′ = −(∂r/∂θ + ∂r/∂v v̂′ + ∂r/∂a â′ + ∂r/∂xₙ xₙ′ + ∂r/∂hₙ hₙ′), h·x′ = 0 on a taut constraint, λ′ = 0 on a slack one,
//!
//! with K and h = ∂c/∂x at the converged state and v̂′, â′ the change at fixed x. With Z = K⁻¹H and S = HᵀZ of the taut constraints,
//! y = −K⁻¹(…), S λ′ = Hᵀy and x′ = y − Z λ′. The integrator maps derivatives of states as it maps states, and effects that
//! remember bring h′ to the end of the step ([`Past`](crate::system::PastDerivative)).
//!
//! Sources: Tortorelli & Michaleris, *Inverse Problems in Engineering* 1, 1994; Kleiber, *Parameter Sensitivity in Nonlinear
//! Mechanics*, 1997; Choi & Kim, *Structural Sensitivity Analysis and Optimization 2*, 2005.
//! Limits: converged states; prescribed motions and targets that do not depend on θ; at a constraint that is just taut (λ = 0 and
//! g = 0) the answer has two derivatives, and the one of the slack side is given.

use super::multipliers::Schur;
use super::start::{Start, before};
use super::{Failure, Integrator, Step, tangent};
use crate::math::linear::{Factor, LinearError, Method};
use crate::math::vector::dot;
use crate::system::{
    Assembled, ParameterDerivative, Perturbation, Rates, State, System, Want, add_history_derivative, add_reactions,
    add_residual_derivative,
};

/// Derivatives of the state of a run, with a factorisation and sums of its own, in addition to those of the run.
pub struct Differentiator<'a> {
    system: &'a System,
    /// Per θ: what makes up ∂r/∂θ
    by: Vec<Vec<ParameterDerivative>>,
    pub factor: Factor,
    method: Method,
    sums: Assembled,
    /// K of the factorisation
    factored: Vec<f64>,
    /// Per θ: ∂/∂θ of the last state
    pub changes: Vec<State>,
    /// Per θ: \[unknowns\] ∂/∂θ of the residual of the last state at fixed x
    residuals: Vec<Vec<f64>>,
}

impl<'a> Differentiator<'a> {
    /// From rest; each θ with its terms. `method` chooses between direct and iterative linear solvers.
    pub fn new(method: Method, system: &'a System, by: Vec<Vec<ParameterDerivative>>) -> Self {
        let factor = Factor::by(method.clone(), system.pattern.clone(), system.scalar_equations() == 0);
        let changes = vec![system.rest(); by.len()];
        let residuals = changes.iter().map(|c| c.x.clone()).collect();
        Self { system, by, factor, method, sums: system.workspace(), factored: Vec::new(), changes, residuals }
    }

    /// A stage begins at `state`, whose acceleration is that of the start: M a′ is what is left of the change of r.
    pub fn begin(&mut self, integrator: Integrator, state: &State) -> Result<(), Failure> {
        let system = self.system;
        if integrator.needs_initial_acceleration() {
            let mut start = Start::new(self.method.clone(), system, state, &state.a)?;
            let at = before(state, &state.a, Rates::default());
            let still = vec![0.0; state.x.len()];
            for (change, terms) in self.changes.iter_mut().zip(&self.by) {
                let State { x, v, history, lambda, .. } = &*change;
                let mut residual = vec![0.0; x.len()];
                let direction = Perturbation { x, v, a: &still, old: x, history };
                add_residual_derivative(system, &at, &direction, terms, &mut residual).map_err(Failure::Eval)?;
                let free = system.restrict(x);
                let mut sum = vec![0.0; free.len()];
                start.sums.pattern.multiply(&start.sums.k, &free, &mut sum);
                start.sums.skew.add_product(&free, &mut sum);
                sum.iter_mut().zip(system.restrict(&residual)).for_each(|(s, r)| *s += r);
                for (h, rate) in start.sums.gradient.iter().zip(lambda) {
                    sum.iter_mut().zip(h).for_each(|(s, h)| *s += rate * h);
                }
                change.a = start.solve(system, Some(sum))?;
            }
        }
        self.changes.iter_mut().for_each(|change| integrator.begin(change));
        Ok(())
    }

    /// The step ended at the converged state `next`. In statics without history no step needs the one before, so steps may
    /// be left out there.
    pub fn step(&mut self, step: &Step, next: &State) -> Result<(), Failure> {
        let rests = |state: &State| {
            let State { x, v, a, history, .. } = state;
            [x, v, a, history].iter().all(|values| values.iter().all(|value| *value == 0.0))
        };
        if rests(next) && self.changes.iter().all(rests) {
            // ∂P/∂θ = 0 at F = I: at rest nothing changes, and the body need not be held by what comes later.
            self.residuals.iter_mut().for_each(|residual| residual.fill(0.0));
            for change in &mut self.changes {
                let past = change.clone();
                change.lambda.fill(0.0);
                step.integrator.finish(&past, step.dt, change);
            }
            return Ok(());
        }
        let Self { system, factor, sums, .. } = self;
        let (at, lambda) = (step.at(next), &next.lambda);
        system.assemble(&at, lambda, Want::Tangent, None, sums).map_err(Failure::Eval)?;
        if sums.k != self.factored {
            // The remains of a failed factorisation are not to be used.
            self.factored.clear();
            factor.move_to(&next.x);
            factor.factorise(&sums.k).map_err(Failure::Linear)?;
            self.factored.clone_from(&sums.k);
        }
        // A slack constraint is dropped from H.
        let taut: Vec<usize> = (0..lambda.len()).filter(|&c| system.constraints[c].kind().holds(lambda[c])).collect();
        let rows: Vec<Vec<f64>> = taut.iter().map(|&c| sums.gradient[c].clone()).collect();
        let Schur { z, s, .. } = Schur::new(factor, sums, system, &taut, &rows).map_err(Failure::Linear)?;
        let (n, m) = (system.dofs.free.len(), taut.len());
        let lu = nalgebra::DMatrix::from_row_slice(m, m, &s).lu();
        let still = vec![0.0; next.x.len()];
        for ((change, terms), residual) in self.changes.iter_mut().zip(&self.by).zip(&mut self.residuals) {
            let past = change.clone();
            step.integrator.kinematics(&past, step.dt, &still, &mut change.v, &mut change.a);
            let State { v, a, .. } = &*change;
            let direction = Perturbation { x: &still, v, a, old: &past.x, history: &past.history };
            residual.fill(0.0);
            add_residual_derivative(system, &at, &direction, terms, residual).map_err(Failure::Eval)?;
            let mut y = system.restrict(residual);
            y.iter_mut().for_each(|y| *y = -*y);
            tangent::solve(factor, sums, &mut y).map_err(Failure::Linear)?;
            change.lambda.fill(0.0);
            if m > 0 {
                let along = nalgebra::DVector::from_fn(m, |i, _| dot(&rows[i], &y));
                let solved = lu.solve(&along).ok_or(Failure::Linear(LinearError::Singular))?;
                for ((&c, z), value) in taut.iter().zip(z.chunks_exact(n)).zip(&solved) {
                    change.lambda[c] = *value;
                    y.iter_mut().zip(z).for_each(|(y, z)| *y -= z * value);
                }
            }
            system.expand(&y, &mut change.x);
            step.integrator.kinematics(&past, step.dt, &change.x, &mut change.v, &mut change.a);
            let State { x, v, a, .. } = &*change;
            let direction = Perturbation { x, v, a, old: &past.x, history: &past.history };
            let mut history = past.history.clone();
            add_history_derivative(system, &at, &direction, terms, &mut history).map_err(Failure::Eval)?;
            change.history = history;
            step.integrator.finish(&past, step.dt, change);
        }
        Ok(())
    }

    /// Per θ: \[unknowns\] ∂/∂θ of the residual at prescribed dofs, the reaction, at the end of the last step; not used
    /// elsewhere.
    pub fn reactions(&self, step: &Step, next: &State) -> Result<Vec<Vec<f64>>, Failure> {
        let mut reactions = self.residuals.clone();
        let directions: Vec<(&[f64], &[f64])> = self.changes.iter().map(|c| (&c.x[..], &c.lambda[..])).collect();
        let at = step.at(next);
        add_reactions(self.system, &at, &next.lambda, &directions, &mut reactions).map_err(Failure::Eval)?;
        Ok(reactions)
    }
}
