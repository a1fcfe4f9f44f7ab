//! Free motion, then one correction: the loop of simulators that look at the obstacles between their steps.
//!
//! One step of the time grid is one search for contact, which makes every point's obstacle a plane ([`Touch`]), and a number of
//! integration steps. Each is one linearised step of implicit Euler without contact, K du = −r with the rows, and one correction by the
//! forces p at the planes that it would cross (Duriez, Dubois, Kheddar & Andriot, IEEE Trans. Vis. Comput. Graph. 12, 2006, §4):
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n ⟂ p_n ≥ 0      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! solved by [`gauss_seidel`](super::gauss_seidel), with the law of friction of the equilibrium.
//!
//! For comparison. Neither equilibrium nor distances hold to a tolerance at the end of a step, and planes are as old as the search: the
//! error is of first order in both steps, and nothing warns of it. There is nothing to cut, so a step that fails ends the run.

use super::gauss_seidel::Contacts;
use super::multipliers::Schur;
use super::newton::{Direction, remaining};
use super::{Failure, Newton, Solved, Span, Status, Step, Stepper, tangent};
use crate::math::linear::dot;
use crate::math::tensor::Vec3;
use crate::system::{State, System, Touch, Want};

/// A gap that is closed, as a share of the largest motion of the step [–].
const CLOSED: f64 = 1e-10;

impl Stepper<'_> {
    /// One step of the time grid: one search for contact, and `count` integration steps.
    pub(super) fn advance_freely(
        &mut self,
        span: Span,
        count: usize,
        state: &mut State,
        goal: f64,
        accepted: &mut impl FnMut(&State, &State, &Newton, bool) -> bool,
    ) -> Status {
        let seen = Seen { touches: self.system.touch_planes(&state.x), x: state.x.clone() };
        let origin = state.t;
        for k in 1..=count {
            if self.is_over() {
                return Status::TimeBudget { t: state.t };
            }
            let t = if k == count { goal } else { origin + (goal - origin) * k as f64 / count as f64 };
            let step = Step { system: self.system, integrator: span.integrator, past: state, dt: t - state.t };
            let mut next = State { t, ..state.clone() };
            let solved = match self.newton.move_and_correct(&step, &seen, &mut next) {
                Ok(solved) => solved,
                Err(why) => return Status::stopped(state.t, why),
            };
            span.integrator.finish(state, step.dt, &mut next);
            let past = std::mem::replace(state, next);
            self.count(&solved);
            self.remember(state);
            if !accepted(&past, state, &self.newton, k == count) {
                return Status::Interrupted { t: state.t };
            }
        }
        Status::Converged
    }
}

/// What the search for contact saw.
struct Seen {
    touches: Vec<Touch>,
    /// Displacement then
    x: Vec<f64>,
}

impl Newton {
    /// From `past` to the end of the step: free motion, then one correction.
    fn move_and_correct(&mut self, step: &Step, seen: &Seen, next: &mut State) -> Result<Solved, Failure> {
        let system = step.system;
        let targets = step.targets(next);
        let mut solved = Solved { iterations: 1, unstable_modes: 0, regularised: false, projected: false };
        self.look_back(step)?;
        let mut forces = vec![0.0; seen.touches.len()];
        system.press(&mut next.x, &forces);
        let increment = remaining(&targets, next);
        self.evaluate(step, next, Want::Tangent, increment.as_deref())?;
        let schur = self.factorise(step, None, &mut solved)?;
        let mut y = self.right_side(system, increment.is_some());
        tangent::solve(&mut self.factor, &self.sums, &mut y).map_err(Failure::Linear)?;
        let mut contacts = Contacts::default();
        let direction = loop {
            let direction = self.direction_under(system, next, increment.as_deref(), (&y, &schur), &mut contacts)?;
            let size = direction.x[..system.dofs.displacements as usize].iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            let way: Vec<f64> = next.x.iter().zip(&direction.x).zip(&seen.x).map(|((x, d), s)| x + d - s).collect();
            let crossed = |touch: &Touch| touch.gap + touch.normal.dot(&touch.motion(&way)) < -CLOSED * size;
            let known = |k: usize| contacts.points.iter().any(|p| p.place == k);
            let fresh = |k: &usize| crossed(&seen.touches[*k]) && !known(*k);
            let fresh: Vec<usize> = (0..seen.touches.len()).filter(fresh).collect();
            let before = contacts.points.len();
            for k in fresh {
                let touch = &seen.touches[k];
                // Without du on the free dofs.
                let carried = increment.as_ref().map_or(Vec3::zeros(), |d| touch.motion(d));
                let gap = touch.gap + touch.normal.dot(&(touch.motion(&next.x) - touch.motion(&seen.x) + carried));
                contacts.add(system, k, touch, (gap, carried, step.dt));
            }
            if contacts.points.len() == before {
                break direction;
            }
            let mut columns = contacts.columns(y.len());
            tangent::solve(&mut self.factor, &self.sums, &mut columns).map_err(Failure::Linear)?;
            contacts.respond(&columns, &y, &schur, &self.sums.gradient);
        };
        next.x.iter_mut().zip(&direction.x).for_each(|(x, d)| *x += d);
        targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
        next.lambda.copy_from_slice(&direction.lambda);
        contacts.points.iter().for_each(|point| forces[point.place] = contacts.p[point.first]);
        system.press(&mut next.x, &forces);
        self.evaluate(step, next, Want::Residual, None)?;
        self.iterations = solved.iterations;
        self.advance_history(step, next)?;
        Ok(solved)
    }

    /// du = y − Z_c (λ' − λ) + Z p, with p and λ' that agree.
    fn direction_under(
        &self,
        system: &System,
        state: &State,
        increment: Option<&[f64]>,
        (y, schur): (&[f64], &Schur),
        contacts: &mut Contacts,
    ) -> Result<Direction, Failure> {
        let m = state.lambda.len();
        let free: Vec<f64> = (0..m).map(|c| -self.sums.carried[c] - dot(&self.sums.gradient[c], y)).collect();
        let multipliers = |p: &[f64], cross: &[Vec<f64>]| {
            if m == 0 {
                return Ok(Vec::new());
            }
            let shift = |c: usize| free[c] - cross.iter().zip(p).map(|(cross, p)| cross[c] * p).sum::<f64>();
            let shift: Vec<f64> = (0..m).map(shift).collect();
            schur.multipliers(system, &self.rows(state), &shift).map(|found| found.0).ok_or(Failure::Complementarity)
        };
        let lambda = contacts.settle(multipliers, &state.lambda)?;
        let mut du = y.to_vec();
        for (z, (new, old)) in schur.z.chunks_exact(y.len()).zip(lambda.iter().zip(&state.lambda)) {
            du.iter_mut().zip(z).for_each(|(du, z)| *du -= z * (new - old));
        }
        for (z, p) in contacts.z.iter().zip(&contacts.p) {
            du.iter_mut().zip(z).for_each(|(du, z)| *du += z * p);
        }
        Ok(Direction::new(system, increment, &du, lambda))
    }
}
