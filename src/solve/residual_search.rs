//! Line search where the tangent has a skew part: no energy falls along the step, so what is left of the residual decides.
//!
//! Taken is x + s du with ‖(K + A)⁻¹ r(x + s du)‖ ≤ 100 ‖du‖, the correction that the same tangent would ask for next (the
//! natural level function of Deuflhard, Newton Methods for Nonlinear Problems, 2004, §3.3). It stops a step that blows up, and
//! no other: a slender body that bends is stretched on the way, its residual grows, and the next iteration takes that away.
//! A monotone test costs twice the iterations on a strip of L/h = 50.

use super::newton::{HALVINGS, Newton, NewtonDirection};
use super::{Failure, Step, tangent};
use crate::system::{State, System, Want};

/// ‖(K + A)⁻¹ r‖/‖du‖ beyond which a step is shortened \[–\]
const GROWTH: f64 = 100.0;

impl Newton {
    /// Goes along the direction as far as the residual allows. True for a full step.
    pub(super) fn advance_by_residual(
        &mut self,
        step: &Step,
        next: &mut State,
        targets: &[(usize, f64)],
        direction: NewtonDirection,
    ) -> Result<bool, Failure> {
        let system = step.system;
        let whole = size(system, &system.restrict(&direction.x));
        let start = next.x.clone();
        let line_search = self.settings.line_search && !step.integrator.is_linearised();
        next.lambda.copy_from_slice(&direction.lambda);
        let mut length = self.longest(system, &start, &direction.x)?;
        for trial in 1..=HALVINGS {
            // Multipliers and the second field go all the way.
            for (i, (x, (from, d))) in next.x.iter_mut().zip(start.iter().zip(&direction.x)).enumerate() {
                *x = from + if i < system.dofs.displacements as usize { length * d } else { *d };
            }
            if length == 1.0 {
                targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
            }
            match self.evaluate(step, next, Want::Residual, None) {
                Ok(()) => {
                    let converged = self.error(system, next, self.rounding()) <= self.settings.tolerance;
                    if !line_search || converged || trial == HALVINGS {
                        return Ok(length == 1.0);
                    }
                    let mut left = system.restrict(&self.sums.r);
                    tangent::solve(&mut self.factor, &self.sums, &mut left).map_err(Failure::Linear)?;
                    if size(system, &left) <= GROWTH * whole {
                        return Ok(length == 1.0);
                    }
                }
                Err(failure) if trial == HALVINGS => return Err(failure),
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
