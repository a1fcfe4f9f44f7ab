//! Globalisation: the step length along the direction of an iteration.
//!
//! With a symmetric tangent, the directional derivative of the energy, G(s) = r(x + s du)·du, has to decrease in magnitude (Crisfield, *Non-linear
//! Finite Element Analysis of Solids and Structures 1*, 1991, ch. 9.5, with different bounds).
//!
//! With a skew part of the tangent there is no energy along the direction. In this case x + s du is accepted if ‖(K + A)⁻¹ r(x + s du)‖ ≤ 100 ‖du‖,
//! the correction that the same tangent would give next (the natural level function of Deuflhard, *Newton Methods for Nonlinear Problems*, 2004,
//! §3.3). This stops only a diverging step: a slender body that bends is first stretched, so that its residual grows, and the next iteration removes
//! that. A monotonicity test would double the iterations on a strip of L/h = 50.
//!
//! In both cases, effects limit the step (no cell inverts, no point passes an obstacle), and the step is halved where a trial state is undefined.
//! Multipliers and the second field take the full step.

use super::settings::NewtonSettings;
use crate::math::linear::Factor;
use crate::math::vector::dot;
use crate::solve::equations::Equations;
use crate::solve::linear::problem::NewtonDirection;
use crate::solve::linear::tangent;
use crate::solve::{Failure, Step};
use crate::system::{State, Strain, System, Want};

/// Largest number of trial steps in a line search.
const TRIALS: usize = 12;
/// Largest |G| after an accepted step, relative to |G(0)|.
const RATIO: f64 = 0.8;
/// ‖(K + A)⁻¹ r‖/‖du‖ above which a step is shortened \[–\]
const GROWTH: f64 = 100.0;

/// The search along the directions of one step.
pub(super) struct LineSearch<'a> {
    pub step: &'a Step<'a>,
    pub settings: NewtonSettings,
    /// Prescribed dofs with their values at the end of the step
    pub targets: &'a [(usize, f64)],
}

impl LineSearch<'_> {
    /// Moves `next` along the direction as far as the search allows; returns whether it took the full step.
    pub fn advance(
        &self,
        equations: &mut Equations,
        factor: &mut Factor,
        next: &mut State,
        direction: &NewtonDirection,
    ) -> Result<bool, Failure> {
        if equations.sums.skew.is_empty() {
            self.advance_by_energy(equations, next, direction)
        } else {
            self.advance_by_residual(equations, factor, next, direction)
        }
    }

    /// Whether the step length is searched for; otherwise a step is shortened only where it must be.
    fn searches(&self) -> bool {
        self.settings.line_search && !self.step.integrator.is_linearised()
    }

    /// The motion from x by this share of a direction, with stiff bodies rotated.
    fn motion(&self, x: &[f64], direction: &[f64], share: f64) -> Vec<f64> {
        let mut motion: Vec<f64> = direction.iter().map(|d| share * d).collect();
        if !self.step.integrator.is_linearised() {
            self.step.system.turn(x, &mut motion, Strain::Linear);
        }
        motion
    }

    /// Searches for a step length by the directional derivative of the energy.
    fn advance_by_energy(
        &self,
        equations: &mut Equations,
        next: &mut State,
        direction: &NewtonDirection,
    ) -> Result<bool, Failure> {
        let (step, system) = (self.step, self.step.system);
        let free = system.restrict(&direction.x);
        // After the full step of multipliers and second field, a minimisation over the displacements remains, and G(s) = r(x + s du, λ', p')·du is
        // the derivative along the step
        let displacements = system.dofs.displacements as usize;
        let along = |r: &[f64]| {
            let moving = system.dofs.free.iter().filter(|dof| **dof < system.dofs.displacements);
            moving.map(|&dof| r[dof as usize] * direction.x[dof as usize]).sum::<f64>()
        };
        let mut start = next.x.clone();
        for (x0, dp) in start[displacements..].iter_mut().zip(&direction.x[displacements..]) {
            *x0 += dp;
        }
        let derivative = if displacements < start.len() {
            next.x.copy_from_slice(&start);
            next.lambda.copy_from_slice(&direction.lambda);
            equations.evaluate(step, next, Want::Residual, None)?;
            along(&equations.sums.r)
        } else {
            // r changes by (λ' − λ) h
            let change = |c: usize| direction.lambda[c] - next.lambda[c];
            let rows = equations.sums.gradient.iter().enumerate();
            along(&equations.sums.r) + rows.map(|(c, h)| change(c) * dot(h, &free)).sum::<f64>()
        };
        next.lambda.copy_from_slice(&direction.lambda);
        let line_search = self.searches();
        let mut length = equations.longest(system, &start, &self.motion(&start, &direction.x, 1.0))?;
        let mut best = None;
        // The contact barrier rises within a small part of a step that it limits: there G = 0 is bracketed
        let brackets = length < 1.0;
        let (mut before, mut beyond) = ((0.0, derivative), None);
        for _ in 0..TRIALS {
            next.x.copy_from_slice(&start);
            let motion = self.motion(&start, &direction.x, length);
            next.x[..displacements].iter_mut().zip(&motion).for_each(|(x, d)| *x += d);
            if length == 1.0 {
                self.targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
            }
            match equations.evaluate(step, next, Want::Residual, None) {
                Ok(()) => {
                    let g = along(&equations.sums.r);
                    if !line_search || g.abs() <= RATIO * derivative.abs() || derivative >= 0.0 {
                        return Ok(length == 1.0);
                    }
                    match (g < 0.0, beyond) {
                        // Still descending at the end of the longest step
                        (true, None) => return Ok(length == 1.0),
                        (true, Some(_)) if !brackets => return Ok(false),
                        (true, Some(_)) => before = (length, g),
                        (false, _) => beyond = Some((length, g)),
                    }
                    best = Some(length);
                    let (end, g) = beyond.expect("a length beyond has been found");
                    // Secant for G = 0, kept away from the ends
                    let share = (before.1 / (before.1 - g)).clamp(0.1, 0.6);
                    length = before.0 + (end - before.0) * share;
                }
                Err(failure @ Failure::Eval(_)) => {
                    best = None;
                    length *= 0.5;
                    if length < 0.5f64.powi(TRIALS as i32) {
                        return Err(failure);
                    }
                }
                Err(other) => return Err(other),
            }
        }
        // The last evaluation is accepted if it was defined, for lack of a better one
        if best.is_some() {
            return Ok(false);
        }
        equations.evaluate(step, next, Want::Residual, None).map(|()| false)
    }
    /// Searches for a step length by the natural level function of the residual.
    fn advance_by_residual(
        &self,
        equations: &mut Equations,
        factor: &mut Factor,
        next: &mut State,
        direction: &NewtonDirection,
    ) -> Result<bool, Failure> {
        let (step, system) = (self.step, self.step.system);
        let whole = size(system, &system.restrict(&direction.x));
        let start = next.x.clone();
        let line_search = self.searches();
        next.lambda.copy_from_slice(&direction.lambda);
        let mut length = equations.longest(system, &start, &self.motion(&start, &direction.x, 1.0))?;
        for trial in 1..=TRIALS {
            let motion = self.motion(&start, &direction.x, length);
            for (i, x) in next.x.iter_mut().enumerate() {
                *x = start[i] + if i < system.dofs.displacements as usize { motion[i] } else { direction.x[i] };
            }
            if length == 1.0 {
                self.targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
            }
            match equations.evaluate(step, next, Want::Residual, None) {
                Ok(()) => {
                    let error = equations.error(system, next, self.settings.tolerance).above_rounding;
                    let converged = error <= self.settings.tolerance;
                    if !line_search || converged || trial == TRIALS {
                        return Ok(length == 1.0);
                    }
                    let mut left = system.restrict(&equations.sums.r);
                    tangent::solve(factor, &equations.sums, &mut left).map_err(Failure::Linear)?;
                    if size(system, &left) <= GROWTH * whole {
                        return Ok(length == 1.0);
                    }
                }
                Err(failure) if trial == TRIALS => return Err(failure),
                Err(Failure::Eval(_)) => {}
                Err(other) => return Err(other),
            }
            length *= 0.5;
        }
        unreachable!("the last trial returns")
    }
}

/// ‖v‖ of the displacements in v \[equations\].
fn size(system: &System, v: &[f64]) -> f64 {
    let moving = v.iter().enumerate().filter(|(e, _)| !system.dofs.is_scalar(*e));
    moving.map(|(_, v)| v * v).sum::<f64>().sqrt()
}
