//! One nonlinear solve: Newton with a line search on the directional derivative, multipliers by the Schur complement.

use super::lagged_factor::LaggedFactor;
use super::multipliers::{self, Schur, larger};
use super::{Failure, Step, tangent};
use crate::math::linear::{Factor, LinearError, Method, dot, norm};
use crate::math::tensor::Vec3;
use crate::system::{Assembled, Cone, ConstraintValues, State, System, Want};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Tolerances of the nonlinear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings {
    /// ‖r‖ ≤ tolerance · (largest effect's Σ‖r_e‖), |g| ≤ tolerance · (length or volume of the row)
    pub tolerance: f64,
    pub max_iterations: usize,
    pub line_search: bool,
    /// Keep a factorisation while it serves, from step to step too; without it every iteration has its own
    pub reuse_factor: bool,
    /// A factorisation that costs at least so many back-substitutions is kept from step to step
    pub reuse_threshold: f64,
    /// Where a step fails, try it with tangents of blocks made positive semidefinite
    pub projection: bool,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            max_iterations: 30,
            line_search: true,
            reuse_factor: true,
            reuse_threshold: 4.0,
            projection: false,
        }
    }
}

/// A converged solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub iterations: usize,
    /// Negative eigenvalues of the constrained tangent at the last factorisation; 0 at a stable equilibrium, and where the
    /// tangent is not symmetric. None where they were not counted: conjugate gradients met none on their way
    pub unstable_modes: Option<usize>,
    /// The tangent was shifted towards positive definiteness on the way
    pub regularised: bool,
    /// Negative eigenvalues of blocks of the tangent were taken away on the way
    pub projected: bool,
}

/// Nonlinear solver with its factorisation and sums, reused from step to step.
pub struct Newton {
    pub settings: NewtonSettings,
    pub factor: Factor,
    pub sums: Assembled,
    pub assembly_time: Duration,
    /// ‖diag K‖ of the last tangent \[N/m\], for the rounding of forces
    pub stiffness: f64,
    /// How linear systems are solved
    pub method: Method,
    /// Length of the body \[m\], for the rounding floor of the residual
    length: f64,
    /// \[constraints\] g at the start of the step, where a law of a row looks back
    old: Vec<f64>,
    /// \[nodes\] X, by which a factor turns with the body; or empty
    pub points: Vec<Vec3>,
    pub(super) stale: LaggedFactor,
}

/// NewtonDirection of one iteration.
pub(super) struct NewtonDirection {
    /// \[3 × nodes\]
    pub x: Vec<f64>,
    /// \[constraints\] multipliers after the step
    pub lambda: Vec<f64>,
}

impl NewtonDirection {
    /// With du \[equations\], and the prescribed increment where there is one.
    pub fn new(system: &System, increment: Option<&[f64]>, du: &[f64], lambda: Vec<f64>) -> Self {
        let mut x = increment.map_or_else(|| vec![0.0; system.dofs.equation.len()], <[f64]>::to_vec);
        for (&dof, du) in system.dofs.free.iter().zip(du) {
            x[dof as usize] = *du;
        }
        Self { x, lambda }
    }
}

/// Share of a Newton step below which what limits it does not let the body move at all \[–\].
const JAMMED: f64 = 1e-10;
/// Share of the size of the body below which a gap is rounding \[–\].
const CLOSED: f64 = 1e-12;
const CHORD_CONTRACTION: f64 = 0.2;
pub(super) const HALVINGS: usize = 12;
/// Share of the largest diagonal entry that the shift counts as the stiffness of a direction without any \[–\].
const SOFTEST: f64 = 1e-9;

impl Newton {
    pub fn new(system: &System, settings: NewtonSettings, length: f64) -> Self {
        Self::by(Method::default(), system, settings, length)
    }

    /// With linear systems solved by one way or the other.
    pub fn by(method: Method, system: &System, settings: NewtonSettings, length: f64) -> Self {
        Self {
            settings,
            factor: Factor::by(method.clone(), system.pattern.clone(), system.scalar_equations() == 0),
            sums: Assembled { descending: true, ..system.workspace() },
            assembly_time: Duration::ZERO,
            stiffness: 0.0,
            method,
            length,
            old: vec![0.0; system.constraints.len()],
            points: Vec::new(),
            stale: LaggedFactor::default(),
        }
    }

    /// Iterates from `next.x`, `next.lambda` (the guess) to equilibrium at `next.t`; fills x, v, a and λ of `next` and brings
    /// its history, that of the last state, to the end of the step. On failure `next` is garbage.
    pub fn solve(&mut self, step: &Step, next: &mut State) -> Result<Solution, Failure> {
        let system = step.system;
        if self.corrects(step) {
            let mut trial = next.clone();
            if let Some(solved) = self.correct_repeatedly(step, &mut trial) {
                *next = trial;
                return Ok(solved);
            }
        }
        let targets = step.targets(next);
        let mut solved = self.unsolved();
        let mut fresh = false;
        let mut last = f64::INFINITY;
        let mut below = false;
        let mut schur = Schur::default();
        let keeps = self.keeps_factors(system) && !step.integrator.is_linearised();
        self.look_back(step)?;
        self.evaluate(step, next, Want::Residual, None)?;
        loop {
            let increment = remaining(&targets, next);
            let error = self.error(system, next, self.rounding());
            if !error.is_finite() {
                return Err(Failure::NotConverged { residual: error, node: 0 });
            }
            let small = increment.is_none() && error <= self.settings.tolerance;
            let last_chance = solved.iterations == self.settings.max_iterations;
            // Under the rounding of a stiff part the error of a soft one does not show: one more iteration takes it away.
            let done = small && (below || last_chance || self.error(system, next, 0.0) <= self.settings.tolerance);
            below = small;
            if done || solved.iterations > 0 && step.integrator.is_linearised() {
                self.advance_history(step, next)?;
                self.judge_factor();
                return Ok(solved);
            }
            if last_chance {
                return Err(Failure::NotConverged { residual: error, node: self.worst_node(system) });
            }
            let old = if keeps {
                self.evaluate(step, next, Want::Tangent, increment.as_deref())?;
                self.stiffness = norm(&self.sums.pattern.diagonal(&self.sums.k));
                let first = solved.iterations == 0;
                let direction = |newton: &mut Self| {
                    newton.direction_by_old_factor(system, next, increment.as_deref(), (error, first))
                };
                let stands = self.has_factor(step.rates(), first);
                let old = stands.then(|| direction(self)).flatten();
                if old.is_none() && self.renew_hierarchy(step, next) { direction(self) } else { old }
            } else {
                None
            };
            let direction = match old {
                Some(direction) => direction,
                None => {
                    let falls = error < CHORD_CONTRACTION * last;
                    let reuse = self.settings.reuse_factor && !keeps && fresh && increment.is_none() && falls;
                    if !reuse {
                        if !keeps {
                            self.evaluate(step, next, Want::Tangent, increment.as_deref())?;
                            self.stiffness = norm(&self.sums.pattern.diagonal(&self.sums.k));
                        }
                        schur = self.factorise(step, next, keeps, &mut solved)?;
                        fresh = true;
                    }
                    self.direction(system, next, increment.as_deref(), &schur)?
                }
            };
            last = error;
            let symmetric = self.sums.skew.is_empty();
            let search = if symmetric { Self::advance } else { Self::advance_by_residual };
            if !search(self, step, next, &targets, direction)? {
                // A damped step: the next tangent must be fresh.
                last = 0.0;
            }
            solved.iterations += 1;
        }
    }

    /// What the laws of the rows need of the last state, and sums without the room that it asked for.
    pub(super) fn look_back(&mut self, step: &Step) -> Result<(), Failure> {
        if step.system.constraints.iter().any(|c| c.cone() == Cone::Linked) {
            self.old = step.system.gaps(step.past).map_err(Failure::Eval)?;
        }
        self.sums.reset_pattern(&step.system.pattern);
        Ok(())
    }

    pub(super) fn evaluate(
        &mut self,
        step: &Step,
        next: &mut State,
        want: Want,
        increment: Option<&[f64]>,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let State { x, v, a, .. } = next;
        step.integrator.kinematics(step.past, step.dt, x, v, a);
        let result = step.system.assemble(&step.at(next), &next.lambda, want, increment, &mut self.sums);
        self.assembly_time += start.elapsed();
        result.map_err(Failure::Eval)
    }

    /// Takes the histories over into `next`, the solution of the step.
    pub(super) fn advance_history(&mut self, step: &Step, next: &mut State) -> Result<(), Failure> {
        let start = Instant::now();
        let mut history = std::mem::take(&mut next.history);
        let result = step.system.advance(&step.at(next), &mut history, &mut self.sums.costs);
        next.history = history;
        self.assembly_time += start.elapsed();
        result.map_err(Failure::Eval)
    }

    /// Forces that are rounding of F \[N\]: 4ε ‖diag K‖ L.
    pub(super) fn rounding(&self) -> f64 {
        self.rounding_of(self.stiffness)
    }

    /// The same where the tangent was assembled last.
    pub(super) fn rounding_here(&self) -> f64 {
        self.rounding_of(norm(&self.sums.pattern.diagonal(&self.sums.k)))
    }

    fn rounding_of(&self, stiffness: f64) -> f64 {
        4.0 * f64::EPSILON * stiffness * self.length
    }

    /// Largest of the scaled errors: ≤ tolerance means converged. Forces are compared with the largest effect's Σ‖r_e‖ or,
    /// if that is larger, with what makes `floor` \[N\] small enough.
    pub(super) fn error(&self, system: &System, state: &State, floor: f64) -> f64 {
        let residual = norm(&system.restrict(&self.sums.r));
        let scale = self.sums.scale.max(floor / self.settings.tolerance);
        let error = if residual == 0.0 { 0.0 } else { residual / scale };
        larger(error, multipliers::error(system, &self.rows(state)))
    }

    /// The rows at `state`, to which the sums belong.
    pub(super) fn rows<'a>(&'a self, state: &'a State) -> ConstraintValues<'a> {
        ConstraintValues {
            now: state.clock(),
            g: &self.sums.g,
            lambda: &state.lambda,
            old: &self.old,
            force: self.sums.scale,
        }
    }

    pub(super) fn worst_node(&self, system: &System) -> u32 {
        let largest = |a: &&u32, b: &&u32| self.sums.r[**a as usize].abs().total_cmp(&self.sums.r[**b as usize].abs());
        system.dofs.free.iter().max_by(largest).map_or(0, |dof| dof / 3)
    }

    /// The factor for the pattern of the last tangent: the order of elimination is that of the system as long as nothing meets.
    pub(super) fn fit_factor(&mut self, system: &System) {
        let in_order = Arc::ptr_eq(&self.sums.pattern, &system.pattern);
        self.factor.take_pattern(&self.sums.pattern, in_order);
    }

    /// Of all rows, with the current factorisation.
    pub(super) fn schur(&mut self, system: &System) -> Result<Schur, Failure> {
        let rows: Vec<usize> = (0..system.constraints.len()).collect();
        Schur::new(&mut self.factor, &self.sums, system, &rows, &self.sums.gradient).map_err(Failure::Linear)
    }

    /// Factorises K, shifts it where the constrained tangent has negative eigenvalues, and forms S = H K⁻¹ Hᵀ.
    pub(super) fn factorise(
        &mut self,
        step: &Step,
        next: &State,
        keep: bool,
        solved: &mut Solution,
    ) -> Result<Schur, Failure> {
        let system = step.system;
        let mut shift = 0.0;
        self.fit_factor(system);
        self.factor.move_to(&next.x);
        let own = self.sums.pattern.diagonal(&self.sums.k);
        let alone: Vec<f64> = (0..own.len()).map(|j| self.sums.k[self.sums.pattern.on_diagonal(j)]).collect();
        let largest = own.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        loop {
            let factorised = self.factor.factorise(&self.sums.k).map_err(Failure::Linear);
            match factorised.and_then(|()| self.schur(system)) {
                Ok(schur) => {
                    let unstable = self.negative(system, &schur);
                    if shift == 0.0 {
                        solved.unstable_modes = unstable;
                    }
                    if unstable.is_none_or(|n| n == 0) || shift > 1e3 {
                        if keep && shift == 0.0 && !self.factor.fell_back() {
                            self.keep_factor(system, self.sums.k.clone(), &next.x, step.rates());
                        }
                        return Ok(schur);
                    }
                }
                Err(failure @ Failure::Linear(LinearError::TooLarge { .. })) => return Err(failure),
                Err(failure) if shift > 1e3 => return Err(failure),
                Err(_) => {}
            }
            // Shift by a growing fraction of the diagonal: a step between Newton's and steepest descent.
            let larger = if shift == 0.0 { 1e-3 } else { 10.0 * shift };
            for (j, own) in own.iter().enumerate() {
                let k = self.sums.pattern.on_diagonal(j);
                let away = if system.dofs.is_scalar(j) { -larger } else { larger };
                self.sums.k[k] = alone[j] + away * own.abs().max(SOFTEST * largest);
            }
            shift = larger;
            solved.regularised = true;
        }
    }

    /// du = K⁻¹(−r − lift) + Z (λ' − λ)·(−1), with λ' from the laws of the linearised rows.
    fn direction(
        &mut self,
        system: &System,
        state: &State,
        increment: Option<&[f64]>,
        schur: &Schur,
    ) -> Result<NewtonDirection, Failure> {
        let m = state.lambda.len();
        let mut y = self.right_side(system, increment.is_some());
        tangent::solve(&mut self.factor, &self.sums, &mut y).map_err(Failure::Linear)?;
        // r contains λ h with h = ∂c/∂x, so du = y − Σ z (λ' − λ); g' = g − h·du − (what the prescribed motion carries along).
        let mut lambda = vec![0.0; m];
        if m > 0 {
            let shift: Vec<f64> =
                (0..m).map(|c| -self.sums.increment_gap[c] - dot(&self.sums.gradient[c], &y)).collect();
            (lambda, _) = schur.multipliers(system, &self.rows(state), &shift).ok_or(Failure::Complementarity)?;
            for (z, (new, old)) in schur.z.chunks_exact(y.len()).zip(lambda.iter().zip(&state.lambda)) {
                let change = new - old;
                y.iter_mut().zip(z).for_each(|(y, z)| *y -= z * change);
            }
        }
        Ok(NewtonDirection::new(system, increment, &y, lambda))
    }

    /// −r − lift \[equations\]
    pub(super) fn right_side(&self, system: &System, lifted: bool) -> Vec<f64> {
        let mut y = system.restrict(&self.sums.r);
        y.iter_mut().zip(&self.sums.increment_force).for_each(|(y, lift)| *y = -*y - if lifted { *lift } else { 0.0 });
        y
    }

    /// The part of the motion dx from x that no effect forbids.
    pub(super) fn longest(&mut self, system: &System, x: &[f64], dx: &[f64]) -> Result<f64, Failure> {
        match system.max_step(x, dx, &mut self.sums.caches) {
            None => Ok(1.0),
            Some((effect, limit)) if limit.share < JAMMED || limit.gap < CLOSED * self.length => {
                Err(Failure::Jammed { effect: effect.into(), node: limit.node, gap: limit.gap })
            }
            Some((_, limit)) => Ok(limit.share),
        }
    }
}

/// What is left of the prescribed motion, \[3 × nodes\], or nothing.
pub(super) fn remaining(targets: &[(usize, f64)], state: &State) -> Option<Vec<f64>> {
    if targets.iter().all(|&(dof, value)| state.x[dof] == value) {
        return None;
    }
    let mut increment = vec![0.0; state.x.len()];
    targets.iter().for_each(|&(dof, value)| increment[dof] = value - state.x[dof]);
    Some(increment)
}
