//! Direct differentiation of the states of a run with respect to parameters θ, step by step. At the end of a step r(x, v, a, xₙ, hₙ; θ) + λ h(x; θ) =
//! 0 and g(x; θ) = target(θ) − c(x; θ), where v and a are linear in x and in the past (xₙ, vₙ, aₙ, qₙ). With the motion x_p′ of the prescribed dofs,
//! this gives
//!
//! K x′ + Σ h λ′ = −(r_θ + λ h_θ + K x_p′ + ∂r/∂v v̂′ + ∂r/∂a â′ + ∂r/∂xₙ xₙ′ + ∂r/∂hₙ hₙ′),
//!
//! h·(x′ + x_p′) − C λ′ = g_θ for a taut constraint of compliance C, λ′ = 0 for a slack one, λ′ = ∂λ_max/∂θ at the largest multiplier,
//!
//! with K and h = ∂c/∂x at the converged state and v̂′, â′ the change at fixed x. With Z = K⁻¹H and S = HᵀZ + C of the taut constraints, y = −K⁻¹(…),
//! S λ′ = Hᵀ(y + x_p′) − g_θ and x′ = y − Z λ′. The integrator maps derivatives of states as it maps states, and effects with history advance h′ to
//! the end of the step ([`Past`](crate::system::PastDerivative)).
//!
//! Sources: Tortorelli & Michaleris, *Inverse Problems in Engineering* 1, 1994; Kleiber, *Parameter Sensitivity in Nonlinear Mechanics*, 1997; Choi &
//! Kim, *Structural Sensitivity Analysis and Optimization 2*, 2005. Limits: converged states; step times that do not depend on θ; at a constraint
//! that is just taut (λ = 0 and g = 0) there are two one-sided derivatives, and that of the slack side is returned.

pub(super) mod adjoint;

use super::linear::multipliers::Schur;
use super::linear::tangent;
use super::second_field::SecondField;
use super::start::{Start, before};
use super::{Failure, SpanStart, Step};
use crate::math::linear::{Factor, LinearError, Method};
use crate::math::vector::dot;
use crate::system::{
    Assembled, At, ConstraintKind, EquationChange, Perturbation, Rates, State, System, SystemParameter, Want,
    WantedRows, add_history_derivative, add_products, add_residual_derivative, constraint_changes, keep_prescribed,
};

/// Size, relative to the largest velocity, above which a jump of velocities is not rounding \[–\].
const VISIBLE: f64 = 1e-9;

/// Computes derivatives of the states of a run, with a factorisation and sums separate from those of the run.
///
/// A parameter by differences has two derivatives, the second of which shows the error of the first; they are consecutive in `changes`
/// ([`SystemParameter::derivatives`]).
pub struct Differentiator<'a> {
    system: &'a System,
    parameters: Vec<SystemParameter<'a>>,
    pub factor: Factor,
    method: Method,
    sums: Assembled,
    /// The K that was factorised
    factored: Vec<f64>,
    /// \[derivatives\] ∂/∂θ of the last state
    pub changes: Vec<State>,
    /// \[derivatives\]\[unknowns\] ∂/∂θ of the residual of the last state at fixed x
    residuals: Vec<Vec<f64>>,
}

impl<'a> Differentiator<'a> {
    /// Builds a differentiator that starts with the derivatives `changes` of the first state. `method` chooses between direct and iterative linear
    /// solvers.
    pub fn new(method: Method, system: &'a System, parameters: Vec<SystemParameter<'a>>, changes: Vec<State>) -> Self {
        let factor = Factor::by(method.clone(), system.pattern.clone(), system.definiteness());
        let residuals = vec![vec![0.0; system.dofs.equation.len()]; changes.len()];
        Self { system, parameters, factor, method, sums: system.workspace(), factored: Vec::new(), changes, residuals }
    }

    /// Sets the second field in the derivatives of the first state so that it is consistent with the derivatives of the displacements.
    ///
    /// # Errors
    ///
    /// An effect is not defined at the state, or nothing determines the second field.
    pub fn set_second_field(&mut self, state: &State) -> Result<(), Failure> {
        let system = self.system;
        let rests = |x: &[f64]| x.iter().all(|value| *value == 0.0);
        if rests(&state.x) && self.changes.iter().all(|change| rests(&change.x)) {
            return Ok(());
        }
        let Some(mut rows) = SecondField::new(system, state)? else { return Ok(()) };
        let at = state.at();
        let own = equation_changes(&mut self.parameters, system, &at, &state.lambda)?;
        for (change, EquationChange { residual, .. }) in self.changes.iter_mut().zip(own) {
            change.x[system.dofs.displacements as usize..].fill(0.0);
            let sum = change_of_residual(system, &rows.sums, (&at, &state.lambda), change, residual)?;
            rows.add_correction(system, &sum, &mut change.x)?;
        }
        Ok(())
    }

    /// Sets the history of the derivatives of the first state for effects that start away from rest, as of a step of zero length from rest.
    ///
    /// # Errors
    ///
    /// An effect is not defined at the state.
    pub fn set_history(&mut self, state: &State) -> Result<(), Failure> {
        let Self { system, parameters, changes, .. } = self;
        let none = vec![0.0; state.history.len()];
        let at = At { history: &none, ..state.at() };
        let mut rest = &mut changes[..];
        for parameter in parameters {
            let (of_parameter, others) = rest.split_at_mut(parameter.derivatives());
            let mut new: Vec<Vec<f64>> = vec![none.clone(); of_parameter.len()];
            for (new, State { x, v, a, .. }) in new.iter_mut().zip(&*of_parameter) {
                let direction = Perturbation { x, v, a, old: x, history: &none };
                add_history_derivative(system, &at, &direction, new).map_err(Failure::Eval)?;
            }
            parameter.add_history(system, &at, &mut new.iter_mut().collect::<Vec<_>>()).map_err(Failure::Eval)?;
            // Other effects begin with zeros
            let begun = (0..system.effects.len()).map(|e| system.history_of(e));
            for own in begun.filter(|own| state.history[own.clone()].iter().any(|value| *value != 0.0)) {
                let parts = of_parameter.iter_mut().zip(&new);
                parts.for_each(|(change, new)| change.history[own.clone()].copy_from_slice(&new[own.clone()]));
            }
            rest = others;
        }
        Ok(())
    }

    /// Starts a stage at `state`, whose acceleration is the initial one: M a′ equals minus the remaining change of r.
    pub fn begin(&mut self, start: &SpanStart, state: &State) -> Result<(), Failure> {
        if start.goes_on() {
            return Ok(());
        }
        let (system, integrator) = (self.system, start.span.integrator);
        let rates = |system: &System| start.given_rates(system, state.clock());
        let given = self.parameters.iter().flat_map(|p| p.of_system(2 * system.prescribed.len(), &rates));
        self.changes.iter_mut().zip(given).for_each(|(change, given)| start.give(system, &given, change));
        if integrator.needs_initial_acceleration() {
            let mut mass = Start::new(self.method.clone(), system, state, &state.a)?;
            let at = before(state, &state.a, Rates::default());
            let own = equation_changes(&mut self.parameters, system, &at, &state.lambda)?;
            for (change, EquationChange { residual, .. }) in self.changes.iter_mut().zip(own) {
                let sum = change_of_residual(system, &mass.sums, (&at, &state.lambda), change, residual)?;
                change.a = mass.solve(system, Some(sum), std::mem::take(&mut change.a))?;
            }
        }
        self.changes.iter_mut().for_each(|change| integrator.begin(change));
        Ok(())
    }

    /// Advances the derivatives over a step that ended at the converged state `next`. In statics without history no step depends on the previous one,
    /// so that steps may be skipped.
    pub fn step(&mut self, step: &Step, next: &State) -> Result<(), Failure> {
        let (at, lambda) = (step.at(next), &next.lambda);
        if landed(step, next) {
            return Err(Failure::Landing);
        }
        if step.past.memory.is_empty() {
            // The integrator was restarted
            self.changes.iter_mut().for_each(|change| change.memory.clear());
        }
        if self.rests(&at, next)? {
            // At rest nothing changes, and the body need not yet be held by constraints that act later
            self.residuals.iter_mut().for_each(|residual| residual.fill(0.0));
            for change in &mut self.changes {
                let past = change.clone();
                change.lambda.fill(0.0);
                step.integrator.finish(&past, step.dt, change);
            }
            return Ok(());
        }
        let Self { system, factor, sums, .. } = self;
        system.assemble(&at, lambda, Want::Tangent, None, sums).map_err(Failure::Eval)?;
        if sums.k != self.factored {
            // A failed factorisation must not be reused
            self.factored.clear();
            factor.move_to(&next.x);
            factor.factorise(&sums.k).map_err(Failure::Linear)?;
            self.factored.clone_from(&sums.k);
        }
        let own = equation_changes(&mut self.parameters, system, &at, lambda)?;
        let pasts = self.changes.clone();
        let solver = TautSystem::new(system, factor, sums, lambda)?;
        solver.solve(step, (next, &at), own, (&pasts, &mut self.changes, &mut self.residuals))?;
        let mut changes: Vec<(&mut State, &State)> = self.changes.iter_mut().zip(&pasts).collect();
        for (change, past) in &mut changes {
            let State { x, v, a, .. } = &**change;
            let direction = Perturbation { x, v, a, old: &past.x, history: &past.history };
            let mut history = past.history.clone();
            add_history_derivative(system, &at, &direction, &mut history).map_err(Failure::Eval)?;
            change.history = history;
        }
        let mut rest = &mut changes[..];
        for parameter in &mut self.parameters {
            let (of_parameter, others) = rest.split_at_mut(parameter.derivatives());
            let mut new: Vec<&mut Vec<f64>> = of_parameter.iter_mut().map(|(c, _)| &mut c.history).collect();
            parameter.add_history(system, &at, &mut new).map_err(Failure::Eval)?;
            rest = others;
        }
        changes.into_iter().for_each(|(change, past)| step.integrator.finish(past, step.dt, change));
        Ok(())
    }

    /// Whether state and derivatives are those of a body at rest.
    fn rests(&mut self, at: &At, next: &State) -> Result<bool, Failure> {
        let rests = |state: &State| {
            let State { x, v, a, history, .. } = state;
            [x, v, a, history].iter().all(|values| values.iter().all(|value| *value == 0.0))
        };
        if !rests(next) || !self.changes.iter().all(rests) {
            return Ok(false);
        }
        let Self { system, parameters, .. } = self;
        for parameter in parameters {
            if !parameter.is_idle_at_rest(system, at, &next.lambda).map_err(Failure::Eval)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// \[derivatives\]\[unknowns\] ∂/∂θ of the reactions, the residual at prescribed dofs, at the end of the last step; zero elsewhere.
    pub fn reactions(&self, step: &Step, next: &State) -> Result<Vec<Vec<f64>>, Failure> {
        let mut reactions = self.residuals.clone();
        let directions: Vec<(&[f64], &[f64])> = self.changes.iter().map(|c| (&c.x[..], &c.lambda[..])).collect();
        add_products(self.system, &step.at(next), &next.lambda, WantedRows::Prescribed, &directions, &mut reactions)
            .map_err(Failure::Eval)?;
        reactions.iter_mut().for_each(|r| keep_prescribed(self.system, r));
        Ok(reactions)
    }
}

/// Whether the step to `next` started with velocities different from those of the state before it, because points landed.
fn landed(step: &Step, next: &State) -> bool {
    if !step.integrator.needs_initial_acceleration() || step.system.with_contact_points().next().is_none() {
        return false;
    }
    let (mut v, mut a) = (next.v.clone(), next.a.clone());
    step.integrator.kinematics(step.past, step.dt, &next.x, &mut v, &mut a);
    let jump: Vec<f64> = v.iter().zip(&next.v).map(|(v, of_next)| v - of_next).collect();
    step.system.largest_displacement(&jump) > VISIBLE * step.system.largest_displacement(&v)
}

/// The changes of the equations due to all parameters, one for each derivative.
fn equation_changes(
    parameters: &mut [SystemParameter],
    system: &System,
    at: &At,
    lambda: &[f64],
) -> Result<Vec<EquationChange>, Failure> {
    let mut out = Vec::new();
    for parameter in parameters {
        out.extend(parameter.change(system, at, lambda).map_err(Failure::Eval)?);
    }
    Ok(out)
}

/// \[equations\] the change of the residual at the start of a stage: that due to the change of the state, whose acceleration is that of the
/// prescribed dofs, plus the change `residual` at a fixed state \[unknowns\]. `sums` are those of the state, with the tangent.
fn change_of_residual(
    system: &System,
    sums: &Assembled,
    (at, lambda): (&At, &[f64]),
    change: &State,
    mut residual: Vec<f64>,
) -> Result<Vec<f64>, Failure> {
    let State { x, v, a, history, lambda: rates, .. } = change;
    let direction = Perturbation { x, v, a, old: x, history };
    add_residual_derivative(system, at, &direction, &mut residual).map_err(Failure::Eval)?;
    let held = held(system, x);
    let along = [(&held[..], &vec![0.0; rates.len()][..])];
    let mut of_held = [residual];
    add_products(system, at, lambda, WantedRows::Free, &along, &mut of_held).map_err(Failure::Eval)?;
    let [residual] = of_held;
    let free = system.restrict(x);
    let mut sum = vec![0.0; free.len()];
    sums.pattern.multiply(&sums.k, &free, &mut sum);
    sums.skew.add_product(&free, &mut sum);
    sum.iter_mut().zip(system.restrict(&residual)).for_each(|(s, r)| *s += r);
    for (h, rate) in sums.gradient.iter().zip(rates) {
        sum.iter_mut().zip(h).for_each(|(s, h)| *s += rate * h);
    }
    Ok(sum)
}

/// \[unknowns\] the part of a change on dofs without equations.
fn held(system: &System, x: &[f64]) -> Vec<f64> {
    let mut held = x.to_vec();
    system.dofs.free.iter().for_each(|&dof| held[dof as usize] = 0.0);
    held
}

/// The factorised equations of a step with its taut constraints.
struct TautSystem<'s> {
    system: &'s System,
    factor: &'s mut Factor,
    sums: &'s Assembled,
    /// Indices of the taut constraints; slack ones are left out of H
    taut: Vec<usize>,
    z: Vec<f64>,
    lu: nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
}

/// Derivatives before the step, derivatives at its end, and derivatives of the residuals at its end.
type Derivatives<'d> = (&'d [State], &'d mut [State], &'d mut [Vec<f64>]);

impl<'s> TautSystem<'s> {
    fn new(system: &'s System, factor: &'s mut Factor, sums: &'s Assembled, lambda: &[f64]) -> Result<Self, Failure> {
        let taut: Vec<usize> = (0..lambda.len()).filter(|&c| system.constraints[c].kind().holds(lambda[c])).collect();
        let rows: Vec<Vec<f64>> = taut.iter().map(|&c| sums.gradient[c].clone()).collect();
        let Schur { z, s, .. } = Schur::new(factor, sums, system, &taut, &rows).map_err(Failure::Linear)?;
        let lu = nalgebra::DMatrix::from_row_slice(taut.len(), taut.len(), &s).lu();
        Ok(Self { system, factor, sums, taut, z, lu })
    }

    /// Computes x′, v′, a′ and λ′ at the end of the step from the changes of the equations.
    fn solve(
        self,
        step: &Step,
        (next, at): (&State, &At),
        own: Vec<EquationChange>,
        (pasts, changes, residuals): Derivatives,
    ) -> Result<(), Failure> {
        let Self { system, factor, sums, taut, z, lu } = self;
        let n = system.dofs.free.len();
        let still = vec![0.0; next.x.len()];
        let [forces, gaps] = by_motion(system, (next, at), &own)?;
        for (k, (change, past)) in changes.iter_mut().zip(pasts).enumerate() {
            let EquationChange { gaps: own_gaps, limits, motion, .. } = &own[k];
            let residual = &mut residuals[k];
            residual.clone_from(&own[k].residual);
            step.integrator.kinematics(past, step.dt, &still, &mut change.v, &mut change.a);
            let direction =
                Perturbation { x: &still, v: &change.v, a: &change.a, old: &past.x, history: &past.history };
            add_residual_derivative(system, at, &direction, residual).map_err(Failure::Eval)?;
            let mut y = system.restrict(residual);
            y.iter_mut().zip(system.restrict(&forces[k])).for_each(|(y, force)| *y += force);
            change.lambda.fill(0.0);
            for (c, constraint) in system.constraints.iter().enumerate() {
                if matches!(constraint.kind(), ConstraintKind::Bounded(most) if next.lambda[c] >= most) {
                    change.lambda[c] = limits[c];
                    y.iter_mut().zip(&sums.gradient[c]).for_each(|(y, h)| *y += h * limits[c]);
                }
            }
            y.iter_mut().for_each(|y| *y = -*y);
            tangent::solve(factor, sums, &mut y).map_err(Failure::Linear)?;
            if !taut.is_empty() {
                let along = |i: usize| dot(&sums.gradient[taut[i]], &y) + gaps[k][taut[i]] - own_gaps[taut[i]];
                let along = nalgebra::DVector::from_fn(taut.len(), |i, _| along(i));
                let solved = lu.solve(&along).ok_or(Failure::Linear(LinearError::Singular))?;
                for ((&c, z), value) in taut.iter().zip(z.chunks_exact(n)).zip(&solved) {
                    change.lambda[c] = *value;
                    y.iter_mut().zip(z).for_each(|(y, z)| *y -= z * value);
                }
            }
            system.prescribed.iter().for_each(|p| change.x[p.dof as usize] = motion[p.dof as usize]);
            system.expand(&y, &mut change.x);
            // Tied nodes also move when their weights change
            let tied = |dof: usize| system.ties.has(dof as u32 / 3) && dof < system.dofs.displacements as usize;
            (0..motion.len())
                .filter(|&dof| motion[dof] != 0.0 && tied(dof))
                .for_each(|dof| change.x[dof] += motion[dof]);
            step.integrator.kinematics(past, step.dt, &change.x, &mut change.v, &mut change.a);
        }
        Ok(())
    }
}

/// For each change of the equations: \[unknowns\] forces and \[constraints\] changes of length due to the motion of prescribed dofs.
fn by_motion(
    system: &System,
    (next, at): (&State, &At),
    own: &[EquationChange],
) -> Result<[Vec<Vec<f64>>; 2], Failure> {
    let (unknowns, constraints) = (vec![0.0; next.x.len()], vec![0.0; next.lambda.len()]);
    let (mut forces, mut gaps) = (vec![unknowns; own.len()], vec![constraints.clone(); own.len()]);
    let motions: Vec<&[f64]> = own.iter().map(|change| &change.motion[..]).collect();
    if motions.iter().all(|motion| motion.iter().all(|value| *value == 0.0)) {
        return Ok([forces, gaps]);
    }
    let directions: Vec<(&[f64], &[f64])> = motions.iter().map(|motion| (*motion, &constraints[..])).collect();
    add_products(system, at, &next.lambda, WantedRows::Free, &directions, &mut forces).map_err(Failure::Eval)?;
    if !constraints.is_empty() {
        gaps = constraint_changes(system, at, &motions).map_err(Failure::Eval)?;
    }
    Ok([forces, gaps])
}
