//! How far to go along a direction: the directional derivative of the energy, G(s) = r(x + s du)·du, is to fall.
//!
//! Source: Crisfield, *Non-linear Finite Element Analysis of Solids and Structures 1*, 1991, ch. 9.5, with bounds of its own. Limits: a
//! tangent with a skew part has no energy along its direction and takes [`residual_search`](super::residual_search).

use super::newton::{HALVINGS, Newton, NewtonDirection};
use super::{Failure, Step};
use crate::math::linear::dot;
use crate::system::{State, Want};

/// |G| after a step that is accepted, as a share of |G(0)|.
const RATIO: f64 = 0.8;

impl Newton {
    /// Goes along the direction as far as the directional derivative of the energy allows. True for a full step.
    pub(super) fn advance(
        &mut self,
        step: &Step,
        next: &mut State,
        targets: &[(usize, f64)],
        direction: NewtonDirection,
    ) -> Result<bool, Failure> {
        let system = step.system;
        let free = system.restrict(&direction.x);
        // Multipliers and the second field go all the way: what is left is a minimum in the displacements, and
        // G(s) = r(x + s du, λ', p')·du its derivative along the step.
        let displacements = system.dofs.displacements as usize;
        let along = |r: &[f64]| {
            let moving = system.dofs.free.iter().filter(|dof| **dof < system.dofs.displacements);
            moving.map(|&dof| r[dof as usize] * direction.x[dof as usize]).sum::<f64>()
        };
        let mut start = next.x.clone();
        for (x0, dp) in start[displacements..].iter_mut().zip(&direction.x[displacements..]) {
            *x0 += dp;
        }
        let slope = if displacements < start.len() {
            next.x.copy_from_slice(&start);
            next.lambda.copy_from_slice(&direction.lambda);
            self.evaluate(step, next, Want::Residual, None)?;
            along(&self.sums.r)
        } else {
            // r changes by (λ' − λ) h.
            let change = |c: usize| direction.lambda[c] - next.lambda[c];
            let rows = self.sums.gradient.iter().enumerate();
            along(&self.sums.r) + rows.map(|(c, h)| change(c) * dot(h, &free)).sum::<f64>()
        };
        next.lambda.copy_from_slice(&direction.lambda);
        let line_search = self.settings.line_search && !step.integrator.is_linearised();
        let mut length = self.longest(system, &start, &direction.x)?;
        let mut best = None;
        for _ in 0..HALVINGS {
            next.x.copy_from_slice(&start);
            let moving = next.x[..displacements].iter_mut().zip(&direction.x);
            moving.for_each(|(x, d)| *x += length * d);
            if length == 1.0 {
                targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
            }
            match self.evaluate(step, next, Want::Residual, None) {
                Ok(()) => {
                    let g = along(&self.sums.r);
                    if !line_search || g.abs() <= RATIO * slope.abs() || slope >= 0.0 {
                        return Ok(length == 1.0);
                    }
                    if g <= 0.0 && length < 1.0 {
                        // Still descending beyond a shortened step: good enough.
                        return Ok(false);
                    }
                    if g < 0.0 {
                        return Ok(true);
                    }
                    best = Some(length);
                    // Secant for G = 0, kept away from the ends.
                    length *= (slope / (slope - g)).clamp(0.1, 0.6);
                }
                Err(failure @ Failure::Eval(_)) => {
                    best = None;
                    length *= 0.5;
                    if length < 0.5f64.powi(HALVINGS as i32) {
                        return Err(failure);
                    }
                }
                Err(other) => return Err(other),
            }
        }
        // The last evaluation stands: accepted if it was defined, for lack of a better one.
        if best.is_some() {
            return Ok(false);
        }
        self.evaluate(step, next, Want::Residual, None).map(|()| false)
    }
}
