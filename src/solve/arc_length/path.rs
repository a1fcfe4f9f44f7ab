//! Arc length: the time t of the loads is an unknown, and the length of the step in the displacements is prescribed.
//!
//! ```text
//! r(x, t) = 0,  ‖x − x₀‖² = Δs²,  Δx ← Δx + K⁻¹(−r) + θ ẋ,  ẋ = −K⁻¹ ∂r/∂t,  θ from ‖Δx‖ = Δs
//! ```
//!
//! Crisfield (Comput. Struct. 13, 1981), the cylindrical form; of the two roots θ, the one that continues the last direction. K is not shifted, so
//! that unstable equilibria are also followed. The step aims at four iterations: Δs ← Δs √(4/iterations) (Ramm 1981). Constraints are included as
//! long as they remain taut or slack during a step. Where one becomes active or inactive, the path has a corner: that step is made under prescribed
//! loads, so that Newton's method decides which constraints are active, and the path continues in the direction of its time.
//!
//! Limits: statics without evolving history; branches that cross the path are not followed, nor a path that turns back where a constraint changes.

use crate::math::linear::LinearError;
use crate::math::signal::Known;
use crate::math::vector::{dot, norm};
use crate::solve::diagnosis::rigid_motions::hold;
use crate::solve::linear::tangent;
use crate::solve::newton::convergence::{AtRounding, Convergence};
use crate::solve::nonlinear_solver::NonlinearSolver;
use crate::solve::{Failure, Integrator, Solution, Step};
use crate::system::{ConstraintKind, State, System, Want};
use nalgebra::{DMatrix, DVector};

/// Time over which loads are differentiated, relative to the nominal step \[–\].
const DELTA: f64 = 1e-4;
/// Number of iterations at which the step length aims.
const WANTED: f64 = 4.0;
/// Largest length of a step, in multiples of the first one, unless it is short compared with the path so far.
const LONGEST: f64 = 10.0;
/// Share of the path so far that a step may always have \[–\].
const SHARE: f64 = 0.1;

/// A step that moves the body by more than this multiple of what the tangent before it predicts may be a jump.
const NEAR: f64 = 2.0;

/// The condition that ends a step.
#[derive(Clone, Copy, PartialEq)]
enum PathStepEnd {
    /// The length ‖Δx‖ \[m\]
    Arc(f64),
    /// The time t \[s\]
    Time(f64),
}

/// A state at which the loads are largest or smallest along the path.
#[derive(Clone, Debug, PartialEq)]
pub struct TurningPoint {
    /// Time of the loads \[s\]
    pub t: f64,
    /// Whether the loads increase before it and decrease after it
    pub highest: bool,
    /// The node that moves most there
    pub node: u32,
    /// The inputs of the signals there
    pub inputs: Vec<Known>,
}

/// A converged point of the path.
pub(super) struct PathPoint {
    pub state: State,
    pub solution: Solution,
}

/// Follows the path of static equilibria x(s), t(s).
pub(super) struct PathTracer<'a> {
    system: &'a System,
    /// Step of the difference ∂r/∂t \[s\], taken backwards if it would pass `end` \[s\]
    delta: f64,
    end: f64,
    /// Displacement of the last step \[equations\]; empty at the start and after a corner
    last: Vec<f64>,
    /// Sign of the change of time in the last step
    forward: f64,
    /// Δs of the next step, of the first step, and of the longest step at the start \[m\]
    length: f64,
    first: f64,
    longest: f64,
    /// Number of negative eigenvalues of the constrained tangent at the start of the path
    pub start_modes: Option<usize>,
    /// Arc length and state of the last points, newest last
    trail: Vec<(f64, State)>,
}

/// The response of the linearised system.
struct Response {
    /// −K⁻¹ r and −K⁻¹ ∂r/∂t \[equations\], with the constraints held
    residual: Vec<f64>,
    rate: Vec<f64>,
    /// Changes of the multipliers
    lambda: [Vec<f64>; 2],
}

/// Finds the equilibrium under the loads of the time of `state`, by Newton's method from there.
fn settled(solver: &mut NonlinearSolver, system: &System, state: &State) -> Result<State, Failure> {
    let mut next = state.clone();
    solver.solve(&Step { system, integrator: Integrator::Static, past: state, dt: 1.0 }, &mut next)?;
    Ok(next)
}

impl<'a> PathTracer<'a> {
    /// Builds a path that starts at a state and leads towards `end`; its first step has the length that the loads of `dt` cause there. The path
    /// starts at the equilibrium under the loads of the time of the state, which may act in full before anything moves.
    pub fn new(
        solver: &mut NonlinearSolver,
        system: &'a System,
        state: &State,
        end: f64,
        dt: f64,
    ) -> Result<Self, Failure> {
        let trail = vec![(0.0, state.clone())];
        let mut tracer = Self {
            system,
            delta: DELTA * dt,
            end,
            last: Vec::new(),
            forward: 1.0,
            length: 0.0,
            first: 0.0,
            longest: 0.0,
            start_modes: None,
            trail,
        };
        let (mut response, mut modes) = tracer.linearise(solver, state, &mut state.clone())?;
        if tracer.size(&response.residual) > SHARE * dt * tracer.size(&response.rate) {
            let start = settled(solver, system, state)?;
            (response, modes) = tracer.linearise(solver, &start, &mut start.clone())?;
            tracer.trail = vec![(0.0, start)];
        }
        tracer.start_modes = modes;
        tracer.length = dt * tracer.size(&response.rate);
        tracer.longest = LONGEST * tracer.length;
        if tracer.length == 0.0 && system.constraints.iter().any(|row| row.kind() != ConstraintKind::Equality) {
            // Nothing moves the body as long as all constraints are slack: the first step is not an arc, whatever its length
            tracer.length = 1.0;
        }
        tracer.first = tracer.length;
        if tracer.length > 0.0 && tracer.length.is_finite() {
            return Ok(tracer);
        }
        Err(Failure::Unloaded)
    }

    /// Whether a state is about as far away as the loads of the first step would move the body at constant stiffness. A jump over a limit point goes
    /// much farther.
    pub fn is_near(&self, next: &State) -> bool {
        let from = &self.trail.last().expect("the start").1;
        self.size(&self.difference(&from.x, &next.x)) <= NEAR * self.length
    }

    /// Makes one step of the current length, but not beyond the end; it passes a corner if it does not converge because of one.
    pub fn step(&mut self, solver: &mut NonlinearSolver) -> Result<PathPoint, Failure> {
        let point = match self.arc(solver) {
            Err(why) if !why.is_of_memory() => self.corner(solver).ok_or(why)?,
            arc => arc?,
        };
        let grown = self.length * (WANTED / point.solution.iterations as f64).sqrt().clamp(0.5, 2.0);
        let from = &self.trail.last().expect("the start").1;
        self.last = self.difference(&from.x, &point.state.x);
        self.forward = (point.state.t - from.t).signum();
        let arc = self.trail.last().expect("the start").0 + norm(&self.last);
        if self.taut(from) != self.taut(&point.state) {
            (self.last, self.trail) = (Vec::new(), Vec::new());
        }
        self.trail.push((arc, point.state.clone()));
        if self.trail.len() > 3 {
            self.trail.remove(0);
        }
        self.length = grown.min(self.longest.max(SHARE * arc));
        Ok(point)
    }

    /// Makes a step of the current length, during which all constraints keep their status.
    fn arc(&self, solver: &mut NonlinearSolver) -> Result<PathPoint, Failure> {
        let point = self.reach(solver, PathStepEnd::Arc(self.length))?;
        if point.state.t >= self.end { self.reach(solver, PathStepEnd::Time(self.end)) } else { Ok(point) }
    }

    /// Makes a step under prescribed loads as long as that of the arc, in which constraints become active or inactive; `None` if none does, or if the
    /// body moves farther than the tangents before and after the step predict. The next steps have the same length by the tangent after the corner.
    fn corner(&mut self, solver: &mut NonlinearSolver) -> Option<PathPoint> {
        let from = self.trail.last().expect("the start").1.clone();
        let speed = |solver: &mut NonlinearSolver, state: &State| {
            let (response, unstable_modes) = self.linearise(solver, state, &mut state.clone()).ok()?;
            Some((self.size(&response.rate), unstable_modes))
        };
        let nominal = self.delta / DELTA;
        let before = speed(solver, &from).map_or(0.0, |(speed, _)| speed);
        let dt = if before > 0.0 { (self.length / before).min(nominal) } else { nominal * self.length / self.first };
        let t = (from.t + self.forward * dt).min(self.end);
        let mut next = State { t, ..from.clone() };
        let step = Step { system: self.system, integrator: Integrator::Static, past: &from, dt: t - from.t };
        let solution = solver.solve(&step, &mut next).ok()?;
        if self.taut(&from) == self.taut(&next) {
            return None;
        }
        let (after, unstable_modes) = speed(solver, &next)?;
        if self.size(&self.difference(&from.x, &next.x)) > NEAR * before.max(after) * (t - from.t).abs() {
            return None;
        }
        self.length = after * dt;
        self.longest = self.longest.max(LONGEST * after * nominal);
        Some(PathPoint { state: next, solution: Solution { unstable_modes, ..solution } })
    }

    /// Cuts the next step, which halves its length.
    pub fn cut(&mut self) {
        self.length *= 0.5;
    }

    /// Makes one step, which is cut at most `cuts` times.
    pub fn step_with_cuts(&mut self, solver: &mut NonlinearSolver, cuts: u32) -> Result<PathPoint, Failure> {
        for _ in 0..cuts {
            match self.step(solver) {
                Ok(point) => return Ok(point),
                Err(_) => self.cut(),
            }
        }
        self.step(solver)
    }

    /// Finds the turning point between the last three points, if there is one: the vertex of the parabola through them, with an equilibrium solved
    /// for there.
    pub fn turning_point(&self, solver: &mut NonlinearSolver) -> Option<TurningPoint> {
        let [(s0, a), (s1, b), (s2, c)] = &self.trail[..] else { return None };
        let (before, after) = (b.t - a.t, c.t - b.t);
        if before * after >= 0.0 {
            return None;
        }
        let (low, high) = (before / (s1 - s0), after / (s2 - s1));
        // t′ at the middles of the two steps, linear in between
        let top = 0.5 * (s0 + s1) + 0.5 * (s2 - s0) * low / (low - high);
        let direction = self.difference(&a.x, &b.x);
        let from = Self { last: direction, trail: vec![(*s0, a.clone())], ..*self };
        let solved = from.reach(solver, PathStepEnd::Arc(top - s0)).ok();
        let highest = before > 0.0;
        let better = |t: f64| if highest { t.max(b.t) } else { t.min(b.t) };
        let change = self.difference(&a.x, &c.x);
        let most = (0..change.len()).max_by(|i, j| change[*i].abs().total_cmp(&change[*j].abs()))?;
        let t = better(solved.map_or(b.t, |point| point.state.t));
        let inputs = b.inputs.clone();
        Some(TurningPoint { t, highest, node: self.system.dofs.free[most] / 3, inputs })
    }

    /// Whether the loads no longer change beyond the last point: after half a step of the first length and after a whole one they are the same.
    pub fn is_unloaded(&self, solver: &mut NonlinearSolver) -> bool {
        let from = &self.trail.last().expect("the start").1;
        let far = (from.t + self.delta / DELTA).min(self.end);
        let near = 0.5 * (from.t + far);
        let mut force = |t: f64| {
            let evaluated = self.evaluate(solver, from, &mut State { t, ..from.clone() }, Want::Residual);
            evaluated.is_ok().then(|| (solver.equations.sums.r.clone(), solver.equations.sums.g.clone()))
        };
        let (near, far) = (force(near), force(far));
        near.is_some() && near == far
    }

    /// Solves by Newton's method from the last point to `end`.
    fn reach(&self, solver: &mut NonlinearSolver, end: PathStepEnd) -> Result<PathPoint, Failure> {
        let start = &self.trail.last().expect("the start").1;
        let mut next = start.clone();
        let (mut increment, mut iterations) = (vec![0.0; self.system.dofs.free.len()], 0);
        let rows = self.taut(start);
        let mut convergence = Convergence::new(&solver.settings, Integrator::Static, AtRounding::Accept);
        loop {
            let (response, unstable_modes) = self.linearise(solver, start, &mut next)?;
            let theta = match end {
                PathStepEnd::Time(t) => t - next.t,
                PathStepEnd::Arc(length) => self.root(&increment, &response, length)?,
            };
            for (i, (u, v)) in response.residual.iter().zip(&response.rate).enumerate() {
                increment[i] += u + theta * v;
                next.x[self.system.dofs.free[i] as usize] += u + theta * v;
            }
            self.system.ties.complete(&mut next.x);
            for (k, &c) in rows.iter().enumerate() {
                next.lambda[c] += response.lambda[0][k] + theta * response.lambda[1][k];
            }
            next.t = if let PathStepEnd::Time(t) = end { t } else { next.t + theta };
            iterations += 1;
            self.evaluate(solver, start, &mut next, Want::Residual)?;
            let error = solver.equations.error_at_tangent(self.system, &next, solver.settings.tolerance);
            if convergence.accepts(error, true, iterations) {
                solver.equations.advance_history(&self.at(start), &mut next)?;
                let solution = Solution { iterations, unstable_modes, ..Solution::default() };
                return Ok(PathPoint { state: next, solution });
            }
            if convergence.is_last(iterations) || !error.above_rounding.is_finite() {
                return Err(solver.not_converged(self.system, error.above_rounding));
            }
        }
    }

    fn at<'b>(&self, past: &'b State) -> Step<'b>
    where
        'a: 'b,
    {
        Step { system: self.system, integrator: Integrator::Static, past, dt: 1.0 }
    }

    /// Evaluates the sums at `next`, after setting its prescribed dofs to their values at its time.
    fn evaluate(
        &self,
        solver: &mut NonlinearSolver,
        past: &State,
        next: &mut State,
        want: Want,
    ) -> Result<(), Failure> {
        let targets: Vec<(usize, f64)> =
            self.system.prescribed.iter().map(|p| (p.dof as usize, p.signal.at(next.t))).collect();
        let step = self.at(past);
        step.check_inputs(&targets, next)?;
        targets.iter().for_each(|&(dof, value)| next.x[dof] = value);
        solver.equations.evaluate(&step, next, want, None)
    }

    /// Solves K du + Σ h dλ = −r, h·du = g, and the corresponding equations for ∂/∂t; also returns the number of negative eigenvalues of the
    /// constrained tangent.
    fn linearise(
        &self,
        solver: &mut NonlinearSolver,
        past: &State,
        next: &mut State,
    ) -> Result<(Response, Option<usize>), Failure> {
        let delta = if next.t + self.delta <= self.end { self.delta } else { -self.delta };
        let mut later = State { t: next.t + delta, ..next.clone() };
        self.evaluate(solver, past, &mut later, Want::Residual)?;
        let (force, gap) = (self.system.restrict(&solver.equations.sums.r), solver.equations.sums.g.clone());
        self.evaluate(solver, past, next, Want::Tangent)?;
        let now = self.system.restrict(&solver.equations.sums.r);
        solver.linear.fit(self.system, &solver.equations.sums);
        solver.linear.factor.move_to(&next.x);
        hold(self.system, &mut solver.equations.sums, &solver.linear.points, &next.x);
        solver.linear.factor.factorise(&solver.equations.sums.k).map_err(Failure::Linear)?;
        let schur = solver.linear.schur(self.system, &solver.equations.sums)?;
        let n = now.len();
        let mut both: Vec<f64> = now.iter().map(|r| -r).collect();
        both.extend(force.iter().zip(&now).map(|(later, now)| (now - later) / delta));
        tangent::solve(&mut solver.linear.factor, &solver.equations.sums, &mut both).map_err(Failure::Linear)?;
        let (rows, m) = (self.taut(past), solver.equations.sums.g.len());
        let s = DMatrix::from_fn(rows.len(), rows.len(), |i, j| schur.s[rows[i] * m + rows[j]]).lu();
        let mut lambda = [Vec::new(), Vec::new()];
        for (y, (dl, rate)) in both.chunks_exact_mut(n).zip(lambda.iter_mut().zip([false, true])) {
            let target = |c: usize| {
                if rate { (gap[c] - solver.equations.sums.g[c]) / delta } else { solver.equations.sums.g[c] }
            };
            let wanted = |i: usize, _| dot(&solver.equations.sums.gradient[rows[i]], y) - target(rows[i]);
            let change = DVector::from_fn(rows.len(), wanted);
            let change = if rows.is_empty() { change } else { s.solve(&change).ok_or(SINGULAR)? };
            for (&c, dl) in rows.iter().zip(&change) {
                y.iter_mut().zip(&schur.z[c * n..(c + 1) * n]).for_each(|(y, z)| *y -= dl * z);
            }
            *dl = change.iter().copied().collect();
        }
        let rate = both.split_off(n);
        Ok((
            Response { residual: both, rate, lambda },
            solver.linear.negative(self.system, &solver.equations.sums, &schur),
        ))
    }

    /// The constraints that are included: equalities and taut ones.
    fn taut(&self, state: &State) -> Vec<usize> {
        let rows = self.system.constraints.iter().zip(&state.lambda).enumerate();
        rows.filter(|(_, (row, lambda))| row.kind().holds(**lambda)).map(|(c, _)| c).collect()
    }

    /// Returns θ with ‖Δx + du + θ ẋ‖ = Δs: forward along the last direction, and at the start with the loads.
    fn root(&self, increment: &[f64], response: &Response, length: f64) -> Result<f64, Failure> {
        let moving = |v: &[f64]| -> Vec<f64> {
            let free = v.iter().enumerate().filter(|(e, _)| !self.system.dofs.is_scalar(*e));
            free.map(|(_, v)| *v).collect()
        };
        let rate = moving(&response.rate);
        let tip: Vec<f64> = moving(increment).iter().zip(moving(&response.residual)).map(|(a, b)| a + b).collect();
        let (a, b, c) = (dot(&rate, &rate), dot(&tip, &rate), dot(&tip, &tip) - length * length);
        if a == 0.0 {
            return Err(Failure::Unloaded);
        }
        let first = increment.iter().all(|m| *m == 0.0);
        if first {
            let forward = if self.last.is_empty() { self.forward } else { dot(&rate, &moving(&self.last)).signum() };
            return Ok(forward * length / a.sqrt());
        }
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return Err(Failure::NoArc);
        }
        let roots = [1.0, -1.0].map(|sign| (-b + sign * discriminant.sqrt()) / a);
        // tip + θ ẋ is to be closest to the motion so far
        let motion = moving(increment);
        let along = |theta: f64| dot(&tip, &motion) + theta * dot(&rate, &motion);
        Ok(if along(roots[0]) >= along(roots[1]) { roots[0] } else { roots[1] })
    }

    /// Change of the free displacements from one state to the other; zero for the second field.
    fn difference(&self, from: &[f64], to: &[f64]) -> Vec<f64> {
        let dofs = &self.system.dofs;
        let change = |dof: &u32| if *dof < dofs.displacements { to[*dof as usize] - from[*dof as usize] } else { 0.0 };
        dofs.free.iter().map(change).collect()
    }

    /// ‖v‖ of the displacements in v \[equations\].
    fn size(&self, v: &[f64]) -> f64 {
        let moving = v.iter().enumerate().filter(|(e, _)| !self.system.dofs.is_scalar(*e));
        moving.map(|(_, v)| v * v).sum::<f64>().sqrt()
    }
}

const SINGULAR: Failure = Failure::Linear(LinearError::Singular);
