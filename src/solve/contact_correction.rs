//! Free motion, then a correction by contact: once a step, as simulators that look at the obstacles between their steps have it, or until
//! the step is an equilibrium.
//!
//! One step of the time grid is one search for contact, which makes every point's obstacle a plane ([`ContactPoint`]), and a number of
//! integration steps. Each is one linearised step of implicit Euler without contact, K du = −r with the rows, and one correction by the
//! forces p at the planes that it would cross (Duriez, Dubois, Kheddar & Andriot, IEEE Trans. Vis. Comput. Graph. 12, 2006, §4):
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n ⟂ p_n ≥ 0      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! solved by [`gauss_seidel`](super::gauss_seidel), with the law of friction of the equilibrium.
//!
//! Once a step it is for comparison. Neither equilibrium nor distances hold to a tolerance at the end of a step, and planes are as old as the
//! search: the error is of first order in both steps, and nothing warns of it. There is nothing to cut, so a step that fails ends the run.
//!
//! Repeated, each time with the planes of its own state, corrections converge to the equilibrium. Where points slide they do so faster than
//! Newton's method, whose symmetric tangent leaves ∂N/∂x out. Limits: the curvature of the obstacle is left out, which makes the
//! convergence linear, with the factor p/(R K).

use super::gauss_seidel::Contacts;
use super::multipliers::Schur;
use super::newton::{NewtonDirection, remaining};
use super::step_solver::StepSolver;
use super::step_strategy::{SolvedStep, Stability, StepOutcome, StepStrategy};
use super::{Failure, Integrator, Newton, Solution, Status, Step, TimeSpan, TurningPoint, tangent};
use crate::math::linear::{dot, norm};
use crate::math::tensor::Vec3;
use crate::system::{ContactPoint, State, System, Want};

/// A gap that is closed, as a share of the largest motion of the step \[–\].
const CLOSED: f64 = 1e-10;
/// Points that press from which Newton's method is left to itself: W is dense.
const MANY: usize = 500;

/// Steps of one correction each, a given number of them after each search for contact.
pub(super) struct CorrectedSteps {
    integrator: Integrator,
    count: usize,
    /// Steps since the search
    done: usize,
    /// Start and end of the step of the time grid \[s\]
    origin: f64,
    goal: f64,
    planes: ContactPlanes,
}

impl CorrectedSteps {
    pub fn new(span: TimeSpan, count: usize) -> Self {
        let planes = ContactPlanes::default();
        Self { integrator: span.integrator, count, done: 0, origin: 0.0, goal: 0.0, planes }
    }
}

impl<'a> StepStrategy<'a> for CorrectedSteps {
    fn begin(&mut self, steps: &mut StepSolver<'a>, state: &State, goal: f64) -> Result<(), Status> {
        (self.done, self.origin, self.goal) = (0, state.t, goal);
        let dt = (goal - state.t) / self.count as f64;
        self.planes = ContactPlanes {
            points: steps.system.contact_points(&state.x, dt, &mut steps.newton.sums.caches),
            x: state.x.clone(),
        };
        Ok(())
    }

    fn step(&mut self, steps: &mut StepSolver<'a>, state: &State) -> StepOutcome {
        let k = self.done + 1;
        let on_grid = k == self.count;
        let t =
            if on_grid { self.goal } else { self.origin + (self.goal - self.origin) * k as f64 / self.count as f64 };
        let step = Step { system: steps.system, integrator: self.integrator, past: state, dt: t - state.t };
        let mut next = State { t, ..state.clone() };
        match steps.newton.move_and_correct(&step, &self.planes, &mut next) {
            Err(why) => StepOutcome::Failed(Status::stopped(state.t, why)),
            Ok(solution) => {
                self.integrator.finish(state, step.dt, &mut next);
                StepOutcome::Solved(Box::new(SolvedStep { next, solution, on_grid, coarse: false }))
            }
        }
    }

    fn accepted(
        &mut self,
        _: &mut StepSolver<'a>,
        _: &State,
        _: &State,
        _: &Solution,
    ) -> (Stability, Option<TurningPoint>) {
        self.done += 1;
        (Stability::NotJudged, None)
    }

    fn is_done(&self) -> bool {
        self.done == self.count
    }
}

/// Obstacles as planes, one for each contact point, as they were when contact was searched.
#[derive(Default)]
struct ContactPlanes {
    points: Vec<ContactPoint>,
    /// Displacement then
    x: Vec<f64>,
}

impl Newton {
    /// From `past` to the end of the step: free motion, then one correction.
    fn move_and_correct(&mut self, step: &Step, planes: &ContactPlanes, next: &mut State) -> Result<Solution, Failure> {
        let mut solved = Solution { iterations: 1, ..self.unsolved() };
        self.look_back(step)?;
        self.correct(step, planes, next, &step.targets(next), &mut solved)?;
        self.advance_history(step, next)?;
        Ok(solved)
    }

    /// Is the equilibrium to be found by corrections? They see friction as it is, and Newton's method with a tangent that lacks a part.
    pub(super) fn corrects(&self, step: &Step) -> bool {
        step.system.has_frictional_points()
            && self.settings.reuse_factor
            && !self.sums.projected
            && !step.integrator.is_linearised()
    }

    /// Corrections from `next` until it is an equilibrium, each with the planes of its own state; None where they do not lead there.
    pub(super) fn correct_repeatedly(&mut self, step: &Step, next: &mut State) -> Option<Solution> {
        let targets = step.targets(next);
        let mut solved = self.unsolved();
        self.look_back(step).ok()?;
        while !solved.regularised && solved.iterations < self.settings.max_iterations {
            let dt = step.at(next).dt;
            let planes = ContactPlanes {
                points: step.system.contact_points(&next.x, dt, &mut self.sums.caches),
                x: next.x.clone(),
            };
            if planes.points.iter().filter(|touch| touch.force > 0.0).count() > MANY {
                return None;
            }
            self.correct(step, &planes, next, &targets, &mut solved).ok()?;
            solved.iterations += 1;
            let error = self.error(step.system, next, self.rounding());
            if error <= self.settings.tolerance {
                self.advance_history(step, next).ok()?;
                return Some(solved);
            }
            if !error.is_finite() {
                return None;
            }
        }
        None
    }

    /// One linearised step without contact, and its correction. `next` becomes the state, the sums its residual.
    fn correct(
        &mut self,
        step: &Step,
        planes: &ContactPlanes,
        next: &mut State,
        targets: &[(usize, f64)],
        solved: &mut Solution,
    ) -> Result<(), Failure> {
        let system = step.system;
        let mut forces = vec![0.0; planes.points.len()];
        system.set_contact_forces(&mut next.x, &forces, &mut self.sums.caches);
        let increment = remaining(targets, next);
        self.evaluate(step, next, Want::Tangent, increment.as_deref())?;
        self.stiffness = norm(&self.sums.pattern.diagonal(&self.sums.k));
        let schur = self.factorise(step, next, false, solved)?;
        let mut y = self.right_side(system, increment.is_some());
        tangent::solve(&mut self.factor, &self.sums, &mut y).map_err(Failure::Linear)?;
        let mut contacts = Contacts::default();
        // Points that press already, then those that would cross.
        let mut fresh: Vec<usize> = (0..forces.len()).filter(|&k| planes.points[k].force > 0.0).collect();
        let mut looked_at = vec![false; forces.len()];
        let direction = loop {
            for &k in &fresh {
                let touch = &planes.points[k];
                looked_at[k] = true;
                // Without du on the free dofs.
                let carried = increment.as_ref().map_or(Vec3::zeros(), |d| touch.motion(d));
                let since = |then: &[f64]| touch.motion(&next.x) - touch.motion(then) + carried;
                let gap = touch.gap + touch.normal.dot(&since(&planes.x));
                contacts.add(system, k, touch, (gap, since(&step.past.x)));
            }
            let mut columns = contacts.columns(y.len());
            tangent::solve(&mut self.factor, &self.sums, &mut columns).map_err(Failure::Linear)?;
            contacts.respond(&columns, &y, &schur, &self.sums.gradient);
            let direction = self.direction_under(system, next, increment.as_deref(), (&y, &schur), &mut contacts)?;
            let size = direction.x[..system.dofs.displacements as usize].iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            let way: Vec<f64> = next.x.iter().zip(&direction.x).zip(&planes.x).map(|((x, d), s)| x + d - s).collect();
            let crossed = |touch: &ContactPoint| touch.gap + touch.normal.dot(&touch.motion(&way)) < -CLOSED * size;
            fresh = (0..forces.len()).filter(|&k| !looked_at[k] && crossed(&planes.points[k])).collect();
            if fresh.is_empty() {
                break direction;
            }
        };
        next.x.iter_mut().zip(&direction.x).for_each(|(x, d)| *x += d);
        targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
        next.lambda.copy_from_slice(&direction.lambda);
        contacts.points.iter().for_each(|point| forces[point.place] = contacts.p[point.first]);
        system.set_contact_forces(&mut next.x, &forces, &mut self.sums.caches);
        self.evaluate(step, next, Want::Residual, None)
    }

    /// du = y − Z_c (λ' − λ) + Z p, with p and λ' that agree.
    fn direction_under(
        &self,
        system: &System,
        state: &State,
        increment: Option<&[f64]>,
        (y, schur): (&[f64], &Schur),
        contacts: &mut Contacts,
    ) -> Result<NewtonDirection, Failure> {
        let m = state.lambda.len();
        let free: Vec<f64> = (0..m).map(|c| -self.sums.increment_gap[c] - dot(&self.sums.gradient[c], y)).collect();
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
        Ok(NewtonDirection::new(system, increment, &du, lambda))
    }
}
