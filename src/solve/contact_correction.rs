//! Contact by free motion and a correction: once a step ([`corrected_steps`](super::corrected_steps)), or until the step is an
//! equilibrium.
//!
//! A search for contact makes every contact point's obstacle a plane ([`ContactPoint`]). Then one linearised step without contact,
//! K du = −r with the constraints, and one correction by the forces p at the planes that it would cross (Duriez, Dubois, Kheddar &
//! Andriot, IEEE Trans. Vis. Comput. Graph. 12, 2006, §4):
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n ⟂ p_n ≥ 0      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! solved by [`gauss_seidel`](super::gauss_seidel), with the law of friction of the equilibrium.
//!
//! Repeated, each time with the planes of its own state, corrections converge to the equilibrium. Where points slide they do so faster than
//! Newton's method, whose symmetric tangent leaves ∂N/∂x out. Limits: the curvature of the obstacle is left out, which makes the
//! convergence linear, with the factor p/(R K).

use super::convergence::{AtRounding, Convergence};
use super::gauss_seidel::Contacts;
use super::linear_problem::{LinearProblem, NewtonDirection};
use super::multipliers::Schur;
use super::nonlinear_solver::NonlinearSolver;
use super::{Failure, Solution, Step, tangent};
use crate::math::tensor::Vec3;
use crate::system::{ContactPoint, State, System, Want};

/// A gap that is closed, as a share of the largest motion of the step \[–\].
const CLOSED: f64 = 1e-10;
/// Most points under pressure for which corrections are taken instead of Newton's method: W is dense.
const MANY: usize = 500;

/// Obstacles as planes, one for each contact point, as they were when contact was searched.
#[derive(Default)]
pub(super) struct ContactPlanes {
    points: Vec<ContactPoint>,
    /// Displacement at the search
    x: Vec<f64>,
}

impl ContactPlanes {
    pub fn new(solver: &mut NonlinearSolver, system: &System, x: &[f64], dt: f64) -> Self {
        Self { points: system.contact_points(x, dt, &mut solver.equations.sums.caches), x: x.to_vec() }
    }

    /// Indices of the points that are under pressure.
    fn pressed(&self) -> Vec<usize> {
        (0..self.points.len()).filter(|&k| self.points[k].force > 0.0).collect()
    }
}

/// From the last state to the end of the step: free motion, then one correction.
pub(super) fn move_and_correct(
    solver: &mut NonlinearSolver,
    step: &Step,
    planes: &ContactPlanes,
    next: &mut State,
) -> Result<Solution, Failure> {
    let mut solution = Solution { iterations: 1, ..solver.no_solution_yet() };
    solver.equations.begin(step)?;
    correct(solver, step, planes, next, &step.targets(next), &mut solution)?;
    solver.equations.advance_history(step, next)?;
    Ok(solution)
}

/// Whether the equilibrium is to be found by corrections: they take friction into account as it is, Newton's method with a tangent
/// that lacks a part.
pub(super) fn uses_corrections(solver: &NonlinearSolver, step: &Step) -> bool {
    let is_plain = !solver.equations.sums.projected && !step.integrator.is_linearised();
    step.system.has_frictional_points() && solver.settings.reuse_factor && is_plain
}

/// Corrections from `next` until it is an equilibrium, each with the planes of its own state; none where they do not lead to one.
pub(super) fn correct_repeatedly(solver: &mut NonlinearSolver, step: &Step, next: &mut State) -> Option<Solution> {
    let targets = step.targets(next);
    let mut solution = solver.no_solution_yet();
    let mut convergence = Convergence::new(&solver.settings, step.integrator, AtRounding::Accept);
    solver.equations.begin(step).ok()?;
    while !solution.regularised && !convergence.is_last(solution.iterations) {
        let dt = step.at(next).dt;
        let planes = ContactPlanes::new(solver, step.system, &next.x, dt);
        if planes.pressed().len() > MANY {
            return None;
        }
        correct(solver, step, &planes, next, &targets, &mut solution).ok()?;
        solution.iterations += 1;
        let error = solver.equations.error(step.system, next, solver.settings.tolerance);
        if convergence.accepts(error, true, solution.iterations) {
            solver.equations.advance_history(step, next).ok()?;
            return Some(solution);
        }
        if !error.above_rounding.is_finite() {
            return None;
        }
    }
    None
}

/// One linearised step without contact, and its correction. `next` becomes the state, the sums its residual.
fn correct(
    solver: &mut NonlinearSolver,
    step: &Step,
    planes: &ContactPlanes,
    next: &mut State,
    targets: &[(usize, f64)],
    solution: &mut Solution,
) -> Result<(), Failure> {
    let system = step.system;
    let NonlinearSolver { equations, linear, .. } = solver;
    let mut forces = vec![0.0; planes.points.len()];
    system.set_contact_forces(&mut next.x, &forces, &mut equations.sums.caches);
    let increment = step.remaining(targets, next);
    equations.linearise(step, next, increment.as_deref())?;
    let schur = linear.factorise(step, next, equations, false, solution)?;
    let problem = LinearProblem { step, equations, state: next, increment: increment.as_deref() };
    let mut y = problem.right_side();
    tangent::solve(&mut linear.factor, &equations.sums, &mut y).map_err(Failure::Linear)?;
    let mut contacts = Contacts::default();
    // Points under pressure, then those that would cross.
    let mut fresh = planes.pressed();
    let mut looked_at = vec![false; forces.len()];
    let direction = loop {
        for &k in &fresh {
            let point = &planes.points[k];
            looked_at[k] = true;
            // Without du on the free dofs.
            let carried = increment.as_ref().map_or(Vec3::zeros(), |d| point.motion(d));
            let since = |then: &[f64]| point.motion(&next.x) - point.motion(then) + carried;
            let gap = point.gap + point.normal.dot(&since(&planes.x));
            contacts.add(system, k, point, (gap, since(&step.past.x)));
        }
        let mut columns = contacts.columns(y.len());
        tangent::solve(&mut linear.factor, &equations.sums, &mut columns).map_err(Failure::Linear)?;
        contacts.respond(&columns, &y, &schur, &equations.sums.gradient);
        let direction = direction_under_contact(&problem, &y, &schur, &mut contacts)?;
        let size = direction.x[..system.dofs.displacements as usize].iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let motion: Vec<f64> = next.x.iter().zip(&direction.x).zip(&planes.x).map(|((x, d), s)| x + d - s).collect();
        let crossed = |point: &ContactPoint| point.gap + point.normal.dot(&point.motion(&motion)) < -CLOSED * size;
        fresh = (0..forces.len()).filter(|&k| !looked_at[k] && crossed(&planes.points[k])).collect();
        if fresh.is_empty() {
            break direction;
        }
    };
    next.x.iter_mut().zip(&direction.x).for_each(|(x, d)| *x += d);
    targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
    next.lambda.copy_from_slice(&direction.lambda);
    contacts.points.iter().for_each(|point| forces[point.place] = contacts.p[point.first]);
    system.set_contact_forces(&mut next.x, &forces, &mut equations.sums.caches);
    equations.evaluate(step, next, Want::Residual, None)
}

/// du = y − Z_c (λ' − λ) + Z p, with p and λ' that agree.
fn direction_under_contact(
    problem: &LinearProblem,
    y: &[f64],
    schur: &Schur,
    contacts: &mut Contacts,
) -> Result<NewtonDirection, Failure> {
    let (m, old) = (problem.state.lambda.len(), &problem.state.lambda);
    let free = problem.shift(y);
    let rows = problem.equations.rows(problem.state);
    let multipliers = |p: &[f64], cross: &[Vec<f64>]| {
        if m == 0 {
            return Ok(Vec::new());
        }
        let shift = |c: usize| free[c] - cross.iter().zip(p).map(|(cross, p)| cross[c] * p).sum::<f64>();
        let shift: Vec<f64> = (0..m).map(shift).collect();
        schur.multipliers(problem.system(), &rows, &shift).map(|found| found.0).ok_or(Failure::Complementarity)
    };
    let lambda = contacts.settle(multipliers, old)?;
    let mut du = y.to_vec();
    for (z, (new, old)) in schur.z.chunks_exact(y.len()).zip(lambda.iter().zip(old)) {
        du.iter_mut().zip(z).for_each(|(du, z)| *du -= z * (new - old));
    }
    for (z, p) in contacts.z.iter().zip(&contacts.p) {
        du.iter_mut().zip(z).for_each(|(du, z)| *du += z * p);
    }
    Ok(problem.direction(&du, lambda))
}
