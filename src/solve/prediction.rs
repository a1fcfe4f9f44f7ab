//! Initial values of a step, extrapolated from the last accepted states.

use super::Integrator;
use crate::system::{Caches, State, Strain, System};

/// Highest degree of the extrapolation.
const MAX_DEGREE: usize = 6;

/// An accepted state that is used in the extrapolation.
#[derive(Clone, Debug, PartialEq)]
pub struct PastPoint {
    /// Time \[s\]
    pub t: f64,
    pub x: Vec<f64>,
    pub lambda: Vec<f64>,
}

/// The last accepted states, and the degree of the polynomial through them that predicts best.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Newest first
    pub recent: Vec<PastPoint>,
    pub degree: usize,
}

impl Default for Prediction {
    fn default() -> Self {
        Self { recent: Vec::new(), degree: 1 }
    }
}

impl Prediction {
    /// Adds an accepted state, and chooses the degree that would have predicted it best.
    pub(super) fn remember(&mut self, state: &State) {
        self.degree = (1..=MAX_DEGREE.min(self.recent.len().saturating_sub(1)))
            .map(|degree| (self.misprediction(degree, state), degree))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(1, |best| best.1);
        self.recent.insert(0, PastPoint { t: state.t, x: state.x.clone(), lambda: state.lambda.clone() });
        self.recent.truncate(MAX_DEGREE + 1);
    }

    /// Sets x and λ of `next` to the prediction for its time; returns false if there are too few states.
    ///
    /// Statics: the polynomial through the last states. Dynamics: x + Δt v + ½Δt² a, with linearly extrapolated multipliers.
    pub(super) fn predict(
        &self,
        system: &System,
        integrator: Integrator,
        state: &State,
        next: &mut State,
        caches: &mut Caches,
    ) -> bool {
        if self.recent.len() < 2 {
            return false;
        }
        let degree = if integrator.is_static() { self.degree } else { 1 };
        next.x.fill(0.0);
        next.lambda.fill(0.0);
        for (w, past) in lagrange(&self.recent[..=degree], next.t).into_iter().zip(&self.recent) {
            next.x.iter_mut().zip(&past.x).for_each(|(n, x)| *n += w * x);
            next.lambda.iter_mut().zip(&past.lambda).for_each(|(n, l)| *n += w * l);
        }
        if !integrator.is_static() {
            let dt = next.t - state.t;
            for (i, x) in next.x.iter_mut().enumerate() {
                *x = state.x[i] + dt * (state.v[i] + 0.5 * dt * state.a[i]);
            }
        }
        let linear: Vec<f64> = next.x.iter().zip(&state.x).map(|(n, x)| n - x).collect();
        let turned = |share: f64| {
            let mut motion: Vec<f64> = linear.iter().map(|d| share * d).collect();
            let turns = system.turn(&state.x, &mut motion, Strain::Kept);
            (motion, turns)
        };
        let mut admitted = |motion: &[f64]| system.max_step(&state.x, motion, caches).map_or(1.0, |(_, l)| l.share);
        let (mut motion, turns) = turned(1.0);
        let share = admitted(&motion);
        if share < 1.0 {
            motion = turned(share).0;
        }
        if share < 1.0 && turns {
            // The end of a smaller rotation is not on the line to the end of a larger one
            let share = admitted(&motion);
            motion.iter_mut().for_each(|d| *d *= share);
        }
        if share < 1.0 || turns {
            next.x.iter_mut().zip(&state.x).zip(&motion).for_each(|((n, x), d)| *n = x + d);
        }
        for (c, lambda) in next.lambda.iter_mut().enumerate() {
            *lambda = system.constraints[c].kind().admit(*lambda);
        }
        true
    }

    /// ‖x − x_p‖², where x_p is the prediction of x by this degree from the states before it.
    fn misprediction(&self, degree: usize, state: &State) -> f64 {
        let weights = lagrange(&self.recent[..=degree], state.t);
        let error = |i: usize| weights.iter().zip(&self.recent).map(|(w, r)| w * r.x[i]).sum::<f64>() - state.x[i];
        (0..state.x.len()).map(|i| error(i).powi(2)).sum()
    }
}

/// Lagrange weights at `t` of the polynomial through these states.
fn lagrange(states: &[PastPoint], t: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| (t - states[j].t) / (states[i].t - states[j].t);
    (0..states.len()).map(|i| (0..states.len()).filter(|&j| j != i).map(|j| factor(i, j)).product()).collect()
}
