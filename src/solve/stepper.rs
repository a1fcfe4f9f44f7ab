//! From step to step: predict, solve, then accept, cut or stop. A step that did not converge is never accepted.

use super::{Failure, Integrator, Newton, Solved, Step};
use crate::system::{EvalError, State, System};
use std::fmt;

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    Converged,
    /// The step fell below the smallest one
    StepTooSmall {
        t: f64,
        why: Failure,
    },
    /// A cell would invert and the law is not defined there
    Inverted {
        t: f64,
        why: Failure,
    },
    /// The tangent is singular: a rigid motion or a mechanism is free
    Singular {
        t: f64,
    },
    /// Stopped by the caller
    Interrupted {
        t: f64,
    },
}

impl Status {
    /// Name as in `summary.json`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Converged => "Converged",
            Self::StepTooSmall { .. } => "StepTooSmall",
            Self::Inverted { .. } => "Inverted",
            Self::Singular { .. } => "Singular",
            Self::Interrupted { .. } => "Interrupted",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged"),
            Self::StepTooSmall { t, why } => write!(
                f,
                "after t = {t:.6} s no step however small converges: {why}; the load may exceed what the body can carry \
                 (drive by length instead of tension), or the mesh is too coarse there"
            ),
            Self::Inverted { t, why } => write!(
                f,
                "after t = {t:.6} s no step however small avoids inversion: {why}; refine the mesh there, reduce the \
                 load, or take a law that survives inversion (stable_neo_hookean)"
            ),
            Self::Singular { t } => write!(
                f,
                "after t = {t:.6} s the tangent is singular: the body can move freely; fix a region (a facet region \
                 with three nodes not on a line holds a body)"
            ),
            Self::Interrupted { t } => write!(f, "stopped at t = {t:.6} s"),
        }
    }
}

/// Step control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// A step is halved at most this often before the run stops
    pub cuts: u32,
    /// Start each step from the extrapolation of the last ones
    pub extrapolate: bool,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self { cuts: 10, extrapolate: true }
    }
}

/// Counts over a run.
#[derive(Clone, Copy, Debug, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Totals {
    pub steps: usize,
    pub iterations: usize,
    pub cuts: usize,
    /// Steps whose tangent had to be shifted towards positive definiteness
    pub regularised: usize,
    /// Accepted states whose tangent had negative eigenvalues: beyond a bifurcation or a limit point
    pub unstable: usize,
}

/// A stretch of time with one integrator and one nominal step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub integrator: Integrator,
    pub start: f64,
    pub end: f64,
    /// Nominal step [s]; the grid start + k·dt is hit whatever was cut
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
    /// ‖diag K‖ of the last factorisation [N/m]
    pub stiffness: f64,
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
    /// Time, x and λ of the last accepted states, newest first, for extrapolation
    recent: Vec<Past>,
    /// Degree of the polynomial that predicts best
    degree: usize,
}

impl<'a> Stepper<'a> {
    pub fn new(system: &'a System, newton: Newton, settings: StepSettings) -> Self {
        Self { system, newton, settings, totals: Totals::default(), recent: Vec::new(), degree: 1 }
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
        for k in 1..=span.steps() {
            let status = self.advance(span.integrator, state, span.point(k), &mut accepted);
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
        self.remember(state);
    }

    /// One step of the time grid, from `state` to `goal`, in parts where it must be cut.
    pub fn advance(
        &mut self,
        integrator: Integrator,
        state: &mut State,
        goal: f64,
        accepted: &mut impl FnMut(&State, &State, &Newton, bool) -> bool,
    ) -> Status {
        let (mut level, mut done) = (0u32, 0u64);
        let origin = state.t;
        // done / 2^level of the nominal step lies behind.
        while done < 1u64 << level {
            let whole = 1u64 << level;
            let t = if done + 1 == whole { goal } else { origin + (goal - origin) * (done + 1) as f64 / whole as f64 };
            match self.step(integrator, state, t) {
                Ok((next, solved)) => {
                    let past = std::mem::replace(state, next);
                    self.count(&solved);
                    self.remember(state);
                    done += 1;
                    if !accepted(&past, state, &self.newton, done == whole) {
                        return Status::Interrupted { t: state.t };
                    }
                    // Grow again after two steps in a row.
                    while level > 0 && done % 2 == 0 {
                        level -= 1;
                        done /= 2;
                    }
                }
                Err(why) => {
                    if level == self.settings.cuts {
                        let step = Step { system: self.system, integrator, past: state, dt: goal - state.t };
                        let free = integrator.is_static() && self.newton.moves_freely(&step, state);
                        return if free { Status::Singular { t: state.t } } else { stopped(state.t, why) };
                    }
                    self.totals.cuts += 1;
                    level += 1;
                    done *= 2;
                }
            }
        }
        Status::Converged
    }

    /// What the next step needs beside the state to come out with the same bits.
    pub fn memory(&self) -> Memory {
        Memory {
            recent: self.recent.clone(),
            degree: self.degree,
            stiffness: self.newton.stiffness,
            totals: self.totals,
        }
    }

    /// Goes on where another stepper was.
    pub fn resume(&mut self, memory: Memory) {
        let Memory { recent, degree, stiffness, totals } = memory;
        (self.recent, self.degree, self.totals) = (recent, degree, totals);
        self.newton.stiffness = stiffness;
    }

    /// One step to time `t`: from the extrapolation, and if that fails, from the last state.
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
        let solved = result?;
        integrator.finish(state, dt, &mut next);
        Ok((next, solved))
    }

    /// Statics: the polynomial through the last states, of the degree that would have predicted the last one best.
    /// Dynamics: x + Δt v + ½Δt² a, multipliers linear.
    fn extrapolate(&self, integrator: Integrator, state: &State, next: &mut State) -> bool {
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
        for (c, lambda) in next.lambda.iter_mut().enumerate() {
            *lambda = self.system.constraints[c].cone().admit(*lambda);
        }
        true
    }

    fn remember(&mut self, state: &State) {
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

    fn count(&mut self, solved: &Solved) {
        self.totals.steps += 1;
        self.totals.iterations += solved.iterations;
        self.totals.regularised += usize::from(solved.regularised);
        self.totals.unstable += usize::from(solved.unstable_modes > 0);
    }
}

fn stopped(t: f64, why: Failure) -> Status {
    match why {
        Failure::Eval(EvalError::Inverted { .. }) => Status::Inverted { t, why },
        Failure::Linear(crate::math::linear::LinearError::Singular) => Status::Singular { t },
        _ => Status::StepTooSmall { t, why },
    }
}

/// Weights at `t` of the polynomial through these states (Lagrange).
fn lagrange(states: &[Past], t: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| (t - states[j].0) / (states[i].0 - states[j].0);
    (0..states.len()).map(|i| (0..states.len()).filter(|&j| j != i).map(|j| factor(i, j)).product()).collect()
}
