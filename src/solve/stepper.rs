//! From step to step: predict, solve, then accept, cut or stop. A step that did not converge is never accepted, nor one whose
//! time error is too large as long as it can be cut.

use super::{Failure, Integrator, Kept, Newton, Solved, Status, Step, TurningPoint};
use crate::math::tensor::Vec3;
use crate::system::{State, System};
use std::time::Instant;

/// Step control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// A step is halved at most this often before the run stops
    pub cuts: u32,
    /// Start each step from the extrapolation of the last ones
    pub extrapolate: bool,
    /// Largest error \[m\] that a dynamic step may make by itself; without it all steps are the nominal ones
    pub time_error: Option<f64>,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self { cuts: 10, extrapolate: true, time_error: None }
    }
}

/// Counts over a run.
#[derive(Clone, Copy, Debug, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Totals {
    pub steps: usize,
    pub iterations: usize,
    pub cuts: usize,
    /// Steps that were solved, and repeated in parts since their time error was too large
    pub repeated: usize,
    /// Steps whose time error was too large, and that could not be cut any more
    pub coarse: usize,
    /// Steps whose tangent had to be shifted towards positive definiteness
    pub regularised: usize,
    /// Steps that came through with projected blocks only
    pub projected: usize,
    /// Accepted states whose tangent had negative eigenvalues: beyond a bifurcation or a limit point
    pub unstable: usize,
    /// Accepted states where negative eigenvalues were not counted: the iterative path meets them by chance only
    #[serde(default)]
    pub uncounted: usize,
}

/// What the path of equilibria showed.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Findings {
    /// Arc length: where the loads were largest or least
    pub turning_points: Vec<TurningPoint>,
    /// Static stages: time \[s\] and number of negative eigenvalues of the constrained tangent, wherever the number changes
    pub unstable: Vec<(f64, usize)>,
}

/// A stretch of time with one integrator and one nominal step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub integrator: Integrator,
    pub start: f64,
    pub end: f64,
    /// Nominal step \[s\]; the grid start + k·dt is hit whatever was cut
    pub dt: f64,
}

impl Span {
    /// Nominal steps.
    pub fn steps(&self) -> usize {
        ((self.end - self.start) / self.dt - 1e-9).ceil().max(1.0) as usize
    }

    /// Point `k` of the time grid, the start being point 0.
    pub fn point(&self, k: usize) -> f64 {
        if k == self.steps() { self.end } else { self.start + k as f64 * self.dt }
    }
}

/// Time, x and λ of an accepted state.
pub type Past = (f64, Vec<f64>, Vec<f64>);

/// What is remembered from step to step beside the state.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Memory {
    /// The last accepted states, newest first
    pub recent: Vec<Past>,
    /// Degree of the polynomial that predicts best
    pub degree: usize,
    /// How often the nominal step was halved for its time error
    pub level: u32,
    /// ‖diag K‖ of the last tangent \[N/m\]
    pub stiffness: f64,
    pub kept: Kept,
    pub totals: Totals,
}

/// Highest degree of the extrapolation.
const MAX_DEGREE: usize = 6;

/// Drives [`Newton`] over a [`Span`].
pub struct Stepper<'a> {
    pub system: &'a System,
    pub newton: Newton,
    pub settings: StepSettings,
    pub totals: Totals,
    pub findings: Findings,
    /// \[nodes\] X, to name rigid motions by; or empty
    pub points: &'a [Vec3],
    /// The run stops when this is over
    pub deadline: Option<Instant>,
    /// Time, x and λ of the last accepted states, newest first, for extrapolation
    recent: Vec<Past>,
    /// Degree of the polynomial that predicts best
    degree: usize,
    /// How often the nominal step is halved for its time error
    level: u32,
}

/// Share of the allowed time error up to which the next step is expected to come out.
const SAFE: f64 = 0.8;

impl<'a> Stepper<'a> {
    pub fn new(system: &'a System, newton: Newton, settings: StepSettings) -> Self {
        let (totals, findings) = (Totals::default(), Findings::default());
        let (recent, degree, level) = (Vec::new(), 1, 0);
        Self { system, newton, settings, totals, findings, points: &[], deadline: None, recent, degree, level }
    }

    /// Runs from `state` to the end of the span. `accepted(past, state, newton, on_grid)` is called after every accepted
    /// step; it returns false to stop.
    pub fn run(
        &mut self,
        span: Span,
        state: &mut State,
        mut accepted: impl FnMut(&State, &State, &Newton, bool) -> bool,
    ) -> Status {
        self.begin(span.integrator, state);
        if let Integrator::ArcLength { max_steps } = span.integrator {
            return self.trace(span, max_steps, state, &mut accepted);
        }
        for k in 1..=span.steps() {
            let status = self.advance(span, state, span.point(k), &mut accepted);
            if status != Status::Converged {
                return status;
            }
        }
        Status::Converged
    }

    /// Makes `state` the first one of a span.
    pub fn begin(&mut self, integrator: Integrator, state: &mut State) {
        integrator.begin(state);
        self.recent.clear();
        self.level = 0;
        self.remember(state);
    }

    /// One step of the time grid of a span, from `state` to `goal`, in parts where it must be cut.
    pub fn advance(
        &mut self,
        span: Span,
        state: &mut State,
        goal: f64,
        accepted: &mut impl FnMut(&State, &State, &Newton, bool) -> bool,
    ) -> Status {
        if let Integrator::FreeMotion { integration_steps } = span.integrator {
            return self.advance_freely(span, integration_steps, state, goal, accepted);
        }
        let (mut level, mut done) = (self.level, 0u64);
        let origin = state.t;
        // done / 2^level of the nominal step lies behind.
        while done < 1u64 << level {
            let whole = 1u64 << level;
            let t = if done + 1 == whole { goal } else { origin + (goal - origin) * (done + 1) as f64 / whole as f64 };
            if self.is_over() {
                return Status::TimeBudget { t: state.t };
            }
            match self.step(span.integrator, state, t) {
                Ok((next, solved)) => {
                    let excess = self.time_error(span.integrator, state, &next);
                    if excess > 1.0 && level < self.settings.cuts {
                        let halvings = span.integrator.halvings(excess / SAFE).ceil().min(64.0) as u32;
                        let halvings = halvings.clamp(1, self.settings.cuts - level);
                        self.totals.repeated += 1;
                        level += halvings;
                        done <<= halvings;
                        continue;
                    }
                    self.totals.coarse += usize::from(excess > 1.0);
                    if let Some(status) = self.jumped(span, state, &next, &solved) {
                        return status;
                    }
                    let past = std::mem::replace(state, next);
                    self.count(&solved);
                    self.remember(state);
                    done += 1;
                    if !accepted(&past, state, &self.newton, done == whole) {
                        return Status::Interrupted { t: state.t };
                    }
                    let last = goal == span.end && done == whole;
                    self.judge_stability(span.integrator, &past, state, &solved, last);
                    // Grow again after two steps in a row, by what the time error allows.
                    let mut allowed = span.integrator.halvings(SAFE / excess);
                    while level > 0 && done % 2 == 0 && allowed >= 1.0 {
                        level -= 1;
                        done /= 2;
                        allowed -= 1.0;
                    }
                }
                Err(why) => {
                    let first = level == 0 && done == 0;
                    if first && let Some(status) = self.hopeless(span.integrator, state, goal) {
                        return status;
                    }
                    if level == self.settings.cuts {
                        return self.diagnose(span, state, t, why);
                    }
                    self.totals.cuts += 1;
                    level += 1;
                    done *= 2;
                }
            }
        }
        self.level = level;
        Status::Converged
    }

    /// Time error of a step by itself, as a multiple of the allowed one; 0 where none is asked for.
    fn time_error(&self, integrator: Integrator, past: &State, next: &State) -> f64 {
        let Some(allowed) = self.settings.time_error.filter(|_| !integrator.is_static()) else { return 0.0 };
        let dofs = &self.system.dofs;
        let moving: Vec<u32> = dofs.free.iter().copied().filter(|&dof| dof < dofs.displacements).collect();
        integrator.local_error(past, next, &moving) / allowed
    }

    /// What the next step needs beside the state to come out with the same bits.
    pub fn memory(&self) -> Memory {
        Memory {
            recent: self.recent.clone(),
            degree: self.degree,
            level: self.level,
            stiffness: self.newton.stiffness,
            kept: self.newton.kept(),
            totals: self.totals,
        }
    }

    /// Goes on where another stepper was.
    pub fn resume(&mut self, memory: Memory) {
        let Memory { recent, degree, level, stiffness, kept, totals } = memory;
        (self.recent, self.degree, self.level, self.totals) = (recent, degree, level, totals);
        self.newton.stiffness = stiffness;
        self.newton.resume_factor(kept, self.system);
    }

    pub(super) fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// A static step over a load that pushes the body where nothing holds it: no smaller step helps.
    fn hopeless(&mut self, integrator: Integrator, state: &State, goal: f64) -> Option<Status> {
        if !integrator.is_static() || self.points.is_empty() {
            return None;
        }
        let step = Step { system: self.system, integrator, past: state, dt: goal - state.t };
        let motions = self.newton.free_motions(&step, state, self.points);
        let pushed = self.newton.pushes(&step, &State { t: goal, ..state.clone() }, &motions);
        pushed.then_some(Status::Singular { t: state.t, motions })
    }

    /// Why no step from `state`, not even the one to `t`, could be solved.
    fn diagnose(&mut self, span: Span, state: &State, t: f64, why: Failure) -> Status {
        if span.integrator.is_static() && !matches!(why, Failure::Jammed { .. }) {
            let step = Step { system: self.system, integrator: span.integrator, past: state, dt: t - state.t };
            let motions = self.newton.free_motions(&step, state, self.points);
            if !motions.is_empty() {
                return Status::Singular { t: state.t, motions };
            }
            if let Some(TurningPoint { t: limit, node, .. }) = self.limit(state, t) {
                let touching = self.system.has_contact();
                return Status::NoEquilibrium { t: state.t, limit, node, touching };
            }
        }
        Status::stopped(state.t, why)
    }

    /// One step to time `t`: from the extrapolation, then from the last state, then with projected tangents.
    fn step(&mut self, integrator: Integrator, state: &State, t: f64) -> Result<(State, Solved), Failure> {
        let dt = t - state.t;
        let mut next = State { t, ..state.clone() };
        // The linearised step is linearised at the last state: K(xₙ).
        let extrapolate = self.settings.extrapolate && !integrator.is_linearised();
        let extrapolated = extrapolate && self.extrapolate(integrator, state, &mut next);
        let step = Step { system: self.system, integrator, past: state, dt };
        let mut result = self.newton.solve(&step, &mut next);
        if result.is_err() && extrapolated {
            next = State { t, ..state.clone() };
            result = self.newton.solve(&step, &mut next);
        }
        if result.is_err() && self.newton.settings.projection && !integrator.is_linearised() {
            next = State { t, ..state.clone() };
            self.newton.sums.projected = true;
            result = self.newton.solve(&step, &mut next);
            self.newton.sums.projected = false;
        }
        let solved = result?;
        integrator.finish(state, dt, &mut next);
        Ok((next, solved))
    }

    /// Statics: the polynomial through the last states, of the degree that would have predicted the last one best.
    /// Dynamics: x + Δt v + ½Δt² a, multipliers linear.
    fn extrapolate(&mut self, integrator: Integrator, state: &State, next: &mut State) -> bool {
        if self.recent.len() < 2 {
            return false;
        }
        let degree = if integrator.is_static() { self.degree } else { 1 };
        next.x.fill(0.0);
        next.lambda.fill(0.0);
        for (w, (_, x, lambda)) in lagrange(&self.recent[..=degree], next.t).into_iter().zip(&self.recent) {
            next.x.iter_mut().zip(x).for_each(|(n, x)| *n += w * x);
            next.lambda.iter_mut().zip(lambda).for_each(|(n, l)| *n += w * l);
        }
        if !integrator.is_static() {
            let dt = next.t - state.t;
            for (i, x) in next.x.iter_mut().enumerate() {
                *x = state.x[i] + dt * (state.v[i] + 0.5 * dt * state.a[i]);
            }
        }
        let motion: Vec<f64> = next.x.iter().zip(&state.x).map(|(n, x)| n - x).collect();
        if let Some((_, limit)) = self.system.max_step(&state.x, &motion, &mut self.newton.sums.caches) {
            next.x.iter_mut().zip(&state.x).zip(&motion).for_each(|((n, x), d)| *n = x + limit.share * d);
        }
        for (c, lambda) in next.lambda.iter_mut().enumerate() {
            *lambda = self.system.constraints[c].cone().admit(*lambda);
        }
        true
    }

    pub(super) fn remember(&mut self, state: &State) {
        self.degree = (1..=MAX_DEGREE.min(self.recent.len().saturating_sub(1)))
            .map(|degree| (self.misprediction(degree, state), degree))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(1, |best| best.1);
        self.recent.insert(0, (state.t, state.x.clone(), state.lambda.clone()));
        self.recent.truncate(MAX_DEGREE + 1);
    }

    /// ‖x − its prediction of this degree from the states before‖².
    fn misprediction(&self, degree: usize, state: &State) -> f64 {
        let weights = lagrange(&self.recent[..=degree], state.t);
        let error = |i: usize| weights.iter().zip(&self.recent).map(|(w, r)| w * r.1[i]).sum::<f64>() - state.x[i];
        (0..state.x.len()).map(|i| error(i).powi(2)).sum()
    }

    pub(super) fn count(&mut self, solved: &Solved) {
        self.totals.steps += 1;
        self.totals.iterations += solved.iterations;
        self.totals.regularised += usize::from(solved.regularised);
        self.totals.projected += usize::from(solved.projected);
    }

    /// The negative eigenvalues of a static step are counted again where it ended if its last tangent, taken before, had some,
    /// and at the end of the stage.
    fn judge_stability(&mut self, integrator: Integrator, past: &State, state: &State, solved: &Solved, last: bool) {
        let mut modes = solved.unstable_modes;
        if integrator.is_static() && (modes.is_some_and(|n| n > 0) || last) {
            let step = Step { system: self.system, integrator, past, dt: state.t - past.t };
            modes = self.newton.unstable_modes(&step, state).or(modes);
        }
        self.note_stability(integrator, state.t, modes);
    }

    pub(super) fn note_stability(&mut self, integrator: Integrator, t: f64, modes: Option<usize>) {
        self.totals.uncounted += usize::from(modes.is_none());
        let Some(modes) = modes else { return };
        self.totals.unstable += usize::from(modes > 0);
        let known = self.findings.unstable.last().map_or(0, |last| last.1);
        if integrator.is_static() && modes != known {
            self.findings.unstable.push((t, modes));
        }
    }
}

/// Weights at `t` of the polynomial through these states (Lagrange).
fn lagrange(states: &[Past], t: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| (t - states[j].0) / (states[i].0 - states[j].0);
    (0..states.len()).map(|i| (0..states.len()).filter(|&j| j != i).map(|j| factor(i, j)).product()).collect()
}
