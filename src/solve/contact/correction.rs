//! Contact by a free motion and a correction: once per step ([`corrected_steps`](super::corrected_steps)), or repeated until the step is in
//! equilibrium.
//!
//! A search for contact replaces the obstacle of every contact point by a plane ([`ContactPoint`]). It is followed by one linearised step without
//! contact, K du = −r with the constraints, and by one correction with the forces p at the planes that this step would cross (Duriez, Dubois, Kheddar
//! & Andriot, IEEE Trans. Vis. Comput. Graph. 12, 2006, §4):
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n ⟂ p_n ≥ 0 or p_n = −A φ′(g_n)      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! This is solved by [`gauss_seidel`](super::gauss_seidel), with the laws of the equilibrium: a multiplier is unilateral; barrier and penalty have a
//! potential φ.
//!
//! Repeated corrections, each with the planes of its own state, converge to the equilibrium. Where points slide they converge faster than Newton's
//! method, whose symmetric tangent leaves ∂N/∂x out. Limits: the curvature of the obstacle is neglected, which makes the convergence linear, with the
//! factor p/(R K).

use super::gauss_seidel::Contacts;
use crate::math::tensor::Vec3;
use crate::solve::linear::multipliers::Schur;
use crate::solve::linear::problem::{LinearProblem, NewtonDirection};
use crate::solve::linear::tangent;
use crate::solve::newton::convergence::{AtRounding, Convergence};
use crate::solve::nonlinear_solver::NonlinearSolver;
use crate::solve::{Failure, Solution, Step};
use crate::system::{Caches, ContactPoint, State, Strain, System, Want};

/// Gap that counts as closed, relative to the largest motion of the step \[–\].
const CLOSED: f64 = 1e-10;
/// Largest number of points for which corrections are used instead of Newton's method, including those that come under pressure: W is dense.
const MANY: usize = 500;
/// Largest work on the forces of a correction that is repeated, in iterations of Newton's method, or in multiplications where these iterations are cheaper
/// \[–\].
const PATIENCE: f64 = 10.0;
const CHEAP: f64 = 3e7;
/// Multiplications of an evaluation per entry of the tangent, about \[–\].
const EVALUATION: f64 = 100.0;
/// A factorisation is reused for another correction if the last one reduced the error by this factor \[–\].
const CHORD_CONTRACTION: f64 = 1e-2;
/// Share of the error that may remain after a correction with a shifted tangent \[–\].
const SHIFTED: f64 = 0.5;
/// Distance beyond its reach within which points with a potential are included, in multiples of the motion of the step so far \[–\].
const MARGIN: f64 = 2.0;

/// Obstacles replaced by planes, one for each contact point, as found by the search for contact.
#[derive(Default)]
pub(super) struct ContactPlanes<'a> {
    points: Vec<ContactPoint<'a>>,
    /// Number of points of each effect
    counts: Vec<usize>,
    /// Displacement at the search
    x: Vec<f64>,
}

impl<'a> ContactPlanes<'a> {
    /// Finds the planes of the points that are within `margin` \[m\] of their reach, at displacement x in a step from `old`.
    pub fn new(solver: &mut NonlinearSolver, system: &'a System, [x, old]: [&[f64]; 2], dt: f64, margin: f64) -> Self {
        let of_effects = system.contact_points([x, old], dt, margin, &mut solver.equations.sums.caches);
        let counts = of_effects.iter().map(Vec::len).collect();
        Self { points: of_effects.into_iter().flatten().collect(), counts, x: x.to_vec() }
    }

    /// Changes x so that the forces of the points become `forces` \[N\].
    fn set_forces(&self, system: &System, x: &mut [f64], forces: &[f64], caches: &mut Caches) {
        let mut rest = forces;
        let of_effects = self.counts.iter().map(|count| rest.split_off(..*count).expect("a force for each point"));
        system.set_contact_forces(x, of_effects, caches);
    }

    /// Indices of the points that are under pressure.
    fn pressed(&self) -> Vec<usize> {
        (0..self.points.len()).filter(|&k| self.points[k].force > 0.0).collect()
    }
}

/// Moves from the last state to the end of the step by a free motion and one correction.
pub(super) fn move_and_correct(
    solver: &mut NonlinearSolver,
    step: &Step,
    planes: &ContactPlanes,
    next: &mut State,
) -> Result<Solution, Failure> {
    let mut solution = Solution { iterations: 1, ..solver.no_solution_yet() };
    let targets = step.targets(next);
    solver.equations.begin(step, &targets, next)?;
    let correction = correct(solver, step, planes, None, next, (&targets, &mut None), &mut solution)?;
    let correction = correction.expect("any number of points is taken");
    correction.advance(solver, step, planes, next, (&targets, 1.0))?;
    solver.equations.advance_history(step, next)?;
    Ok(solution)
}

/// Whether the equilibrium is found by contact corrections. They treat friction exactly; the tangent of Newton's method leaves a part of it out.
pub(in crate::solve) fn uses_corrections(solver: &NonlinearSolver, step: &Step) -> bool {
    let is_plain = !solver.equations.sums.projected && !step.integrator.is_linearised();
    step.system.has_frictional_points() && solver.settings.reuse_factor && is_plain
}

/// Applies corrections to `next` until it is in equilibrium, each with the planes of its own state; `None` if they do not converge.
pub(in crate::solve) fn correct_repeatedly(
    solver: &mut NonlinearSolver,
    step: &Step,
    next: &mut State,
) -> Option<Solution> {
    let (system, targets) = (step.system, step.targets(next));
    let mut solution = solver.no_solution_yet();
    let mut convergence = Convergence::new(&solver.settings, step.integrator, AtRounding::Accept);
    let mut planes = planes_near(solver, step, next);
    if planes.points.is_empty() {
        return None;
    }
    solver.equations.begin(step, &targets, next).ok()?;
    solver.equations.evaluate(step, next, Want::Residual, None).ok()?;
    let error =
        |solver: &NonlinearSolver, next: &State| solver.equations.error(system, next, solver.settings.tolerance);
    let (mut kept, mut last_error) = (None, error(solver, next).above_rounding);
    solver.report(step, next, 0, last_error);
    while !convergence.is_last(solution.iterations) {
        solver.equations.limit.spend_iteration();
        let shifted = solver.linear.shifted;
        let correction =
            correct(solver, step, &planes, Some(MANY), next, (&targets, &mut kept), &mut solution).ok()??;
        let share = solver.equations.longest(system, &next.x, &correction.motion(step, next, 1.0)).ok()?;
        correction.advance(solver, step, &planes, next, (&targets, share)).ok()?;
        solution.iterations += 1;
        solver.iterations += 1;
        let error = error(solver, next);
        solver.report(step, next, solution.iterations, error.above_rounding);
        // A tangent that is shifted because the body is held by contact alone does not converge to the equilibrium
        let is_shifted = solver.linear.shifted > shifted;
        if !error.above_rounding.is_finite() || is_shifted && error.above_rounding > SHIFTED * last_error {
            return None;
        }
        // The next direction is expected to be smaller in proportion to the error
        let left = (error.above_rounding / last_error).min(1.0) * system.largest_displacement(&correction.direction.x);
        let left = left / solver.equations.visible(system.largest_displacement(&next.x));
        if convergence.accepts(error, share == 1.0, solution.iterations)
            && convergence.is_accurate(Some(left), error, solver.linear.is_shifted_since(shifted), solution.iterations)
        {
            solver.equations.advance_history(step, next).ok()?;
            return Some(Solution { correction: Some(left), ..solution });
        }
        if share < 1.0 || is_shifted || error.above_rounding > CHORD_CONTRACTION * last_error {
            kept = None;
        }
        last_error = error.above_rounding;
        planes = planes_near(solver, step, next);
    }
    None
}

/// The planes at `next` of the points that may come into contact within the step.
fn planes_near<'a>(solver: &mut NonlinearSolver, step: &Step<'a>, next: &State) -> ContactPlanes<'a> {
    let motion = next.x.iter().zip(&step.past.x).fold(0.0, |m: f64, (new, old)| m.max((new - old).abs()));
    ContactPlanes::new(solver, step.system, [&next.x, &step.past.x], step.at(next).dt, MARGIN * motion)
}

/// One linearised step without contact, and its correction.
struct Correction {
    direction: NewtonDirection,
    /// Normal force of each point \[N\]
    forces: Vec<f64>,
}

impl Correction {
    /// The motion from `next` by this share of the correction, with stiff bodies rotated.
    fn motion(&self, step: &Step, next: &State, share: f64) -> Vec<f64> {
        let mut motion: Vec<f64> = self.direction.x.iter().map(|d| share * d).collect();
        if !step.integrator.is_linearised() {
            step.system.turn(&next.x, &mut motion, Strain::Linear);
        }
        motion
    }

    /// Moves `next` by this share of the correction, and evaluates the residual there; the `targets` of prescribed dofs are reached if the share is
    /// 1.
    fn advance(
        &self,
        solver: &mut NonlinearSolver,
        step: &Step,
        planes: &ContactPlanes,
        next: &mut State,
        (targets, share): (&[(usize, f64)], f64),
    ) -> Result<(), Failure> {
        let equations = &mut solver.equations;
        let motion = self.motion(step, next, share);
        next.x.iter_mut().zip(&motion).for_each(|(x, d)| *x += d);
        if share == 1.0 {
            targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
        }
        next.lambda.copy_from_slice(&self.direction.lambda);
        planes.set_forces(step.system, &mut next.x, &self.forces, &mut equations.sums.caches);
        equations.evaluate(step, next, Want::Residual, None)
    }
}

/// Computes the correction of `next` with the factorisation of an earlier iteration of the step, if it is `kept`, or with a new one, which is then
/// kept; `None` if there would be more than `most` points. With such a bound the work on their forces is bounded too.
fn correct(
    solver: &mut NonlinearSolver,
    step: &Step,
    planes: &ContactPlanes,
    most: Option<usize>,
    next: &mut State,
    (targets, kept): (&[(usize, f64)], &mut Option<Schur>),
    solution: &mut Solution,
) -> Result<Option<Correction>, Failure> {
    let system = step.system;
    let NonlinearSolver { equations, linear, .. } = solver;
    // First the points under pressure, then those that come under pressure
    let mut fresh = planes.pressed();
    let is_too_many = |count: usize| most.is_some_and(|most| count > most);
    if is_too_many(fresh.len()) {
        return Ok(None);
    }
    let mut forces = vec![0.0; planes.points.len()];
    planes.set_forces(system, &mut next.x, &forces, &mut equations.sums.caches);
    let increment = step.remaining(targets, next);
    equations.sums.without_contact_points = true;
    let is_chord = increment.is_none() && kept.is_some();
    let evaluated = match is_chord {
        true => equations.evaluate(step, next, Want::Residual, None),
        false => equations.linearise(step, next, increment.as_deref()),
    };
    equations.sums.without_contact_points = false;
    evaluated?;
    let schur = match kept.take().filter(|_| is_chord) {
        Some(schur) => schur,
        None => linear.factorise(step, next, equations, false, solution)?,
    };
    let problem = LinearProblem { step, equations, state: next, increment: increment.as_deref() };
    let mut y = problem.right_side();
    tangent::solve(&mut linear.factor, &equations.sums, &mut y).map_err(Failure::Linear)?;
    let newton = linear.factor.flops() + EVALUATION * equations.sums.pattern.nnz() as f64;
    let work = most.map_or(f64::INFINITY, |_| CHEAP.max(PATIENCE * newton));
    let mut contacts = Contacts::default();
    let mut looked_at = vec![false; forces.len()];
    let direction = loop {
        for &k in &fresh {
            let point = &planes.points[k];
            looked_at[k] = true;
            // Without du on the free dofs
            let since = |s: &[f64], then: &[f64]| {
                let carried = increment.as_ref().map_or(Vec3::zeros(), |d| point.motion(s, d));
                point.motion(s, &next.x) - point.motion(s, then) + carried
            };
            let gap = point.gap + point.normal.dot(&since(&point.shares, &planes.x));
            let sliding = since(&point.sliding, &step.past.x) + point.elastic_slip(&step.past.history);
            contacts.add(system, k, point, (gap, sliding));
        }
        let mut columns = contacts.columns(y.len());
        tangent::solve(&mut linear.factor, &equations.sums, &mut columns).map_err(Failure::Linear)?;
        contacts.respond(&columns, &y, &schur, &equations.sums.gradient);
        let found = direction_under_contact(&problem, &y, &schur, &mut contacts, work);
        linear.contact_forces += std::mem::take(&mut contacts.time);
        let direction = found?;
        let size = direction.x[..system.dofs.displacements as usize].iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let motion: Vec<f64> = next.x.iter().zip(&direction.x).zip(&planes.x).map(|((x, d), s)| x + d - s).collect();
        let is_pressed = |point: &ContactPoint| {
            point.gap + point.normal.dot(&point.motion(&point.shares, &motion)) < point.reach() - CLOSED * size
        };
        fresh = (0..forces.len()).filter(|&k| !looked_at[k] && is_pressed(&planes.points[k])).collect();
        if fresh.is_empty() {
            break direction;
        }
        if is_too_many(contacts.points.len() + fresh.len()) {
            return Ok(None);
        }
    };
    contacts.points.iter().for_each(|point| forces[point.place] = contacts.p[point.first]);
    *kept = Some(schur);
    Ok(Some(Correction { direction, forces }))
}

/// Computes du = y − Z_c (λ' − λ) + Z p with consistent p and λ', by at most so many multiplications.
fn direction_under_contact(
    problem: &LinearProblem,
    y: &[f64],
    schur: &Schur,
    contacts: &mut Contacts,
    most: f64,
) -> Result<NewtonDirection, Failure> {
    let (m, old) = (problem.state.lambda.len(), &problem.state.lambda);
    let free = problem.shift(y);
    let rows = problem.equations.rows(problem.state);
    let multipliers = |crossing: &[f64]| {
        if m == 0 {
            return Ok(Vec::new());
        }
        let shift: Vec<f64> = match crossing.is_empty() {
            true => free.clone(),
            false => free.iter().zip(crossing).map(|(free, crossing)| free - crossing).collect(),
        };
        schur.multipliers(problem.system(), &rows, &shift).map(|found| found.0).ok_or(Failure::Complementarity)
    };
    let lambda = contacts.settle(multipliers, old, (&problem.equations.limit, most))?;
    let mut du = y.to_vec();
    for (z, (new, old)) in schur.z.chunks_exact(y.len()).zip(lambda.iter().zip(old)) {
        du.iter_mut().zip(z).for_each(|(du, z)| *du -= z * (new - old));
    }
    for (z, p) in contacts.z.iter().zip(&contacts.p) {
        du.iter_mut().zip(z).for_each(|(du, z)| *du += z * p);
    }
    Ok(problem.direction(&du, lambda))
}
