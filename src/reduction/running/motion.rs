//! The motion of a running model: velocities, accelerations and the history of the points, from one step to the next, without allocation.

use super::dynamics::Dynamics;
use crate::solve::Integrator;
use crate::system::{Rates, State};

/// The state at the start of a step, and the kinematics of its end.
pub struct Motion {
    integrator: Integrator,
    dt: f64,
    /// \[coordinates × coordinates\]
    mass: Vec<f64>,
    damping: Vec<f64>,
    /// State at the start of the step: x contains the displacement coordinates, history that of the points
    past: State,
    next: State,
    /// State at the start of the last completed step
    before: State,
    rates: Rates,
    /// Whether a step has ended since the last rest
    stepped: bool,
}

impl Motion {
    /// Builds the state of rest of points with a history of `memory` values.
    pub fn new(of: &Dynamics, coordinates: usize, memory: usize) -> Self {
        let zero = vec![0.0; coordinates];
        // Capacity for the memory of any integrator, so that no step allocates
        let room = || Vec::with_capacity(2 * coordinates);
        let rest = State {
            x: zero.clone(),
            v: zero.clone(),
            a: zero,
            memory: room(),
            history: vec![0.0; memory],
            ..State::rest(0, 0)
        };
        let next = State { memory: room(), ..rest.clone() };
        let before = State { memory: room(), ..rest.clone() };
        let (mass, damping) = (of.mass.clone(), of.damping.clone());
        Self {
            integrator: of.integrator,
            dt: of.dt,
            mass,
            damping,
            past: rest,
            next,
            before,
            rates: Rates::default(),
            stepped: false,
        }
    }

    /// Returns to rest with these accelerations.
    pub fn reset(&mut self, accelerations: &[f64]) {
        let State { x, v, a, memory, history, dt, t, .. } = &mut self.past;
        [x, v, history].into_iter().for_each(|values| values.fill(0.0));
        a.copy_from_slice(accelerations);
        memory.clear();
        if self.integrator.needs_initial_acceleration() {
            memory.extend_from_slice(accelerations);
        }
        (*dt, *t) = (0.0, 0.0);
        self.stepped = false;
    }

    /// The state at the end of the last step: displacement coordinates, their rates, and the history of the points.
    pub fn state(&self) -> &State {
        &self.past
    }

    /// Returns ½ v·Mv \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        let v = &self.past.v;
        let row = |(m, v_i): (&[f64], &f64)| v_i * m.iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
        0.5 * self.mass.chunks_exact(v.len().max(1)).zip(v).map(row).sum::<f64>()
    }

    /// Restores a state of the same model.
    pub fn restore(&mut self, state: &State) {
        let Self { past, .. } = self;
        past.x.copy_from_slice(&state.x);
        past.v.copy_from_slice(&state.v);
        past.a.copy_from_slice(&state.a);
        past.history.copy_from_slice(&state.history);
        past.memory.clear();
        past.memory.extend_from_slice(&state.memory);
        (past.dt, past.t) = (state.dt, state.t);
        self.stepped = false;
    }

    /// Starts a step.
    pub fn begin(&mut self) {
        self.rates = self.integrator.rates(&self.past, self.dt);
    }

    /// Extrapolates coordinates with the velocities at the start of the step.
    pub fn predict(&self, q: &mut [f64]) {
        q.iter_mut().zip(&self.past.v).for_each(|(q, v)| *q += self.dt * v);
    }

    /// Adds M a + C v and its tangent at the displacement coordinates `q` at the end of the step; rows of K have `stride` entries, column ≤ row.
    pub fn add(&mut self, q: &[f64], stride: usize, r: &mut [f64], k: &mut [f64]) {
        self.kinematics(q);
        let Self { mass, damping, next, rates, .. } = self;
        let n = q.len();
        for i in 0..n {
            let (mass, damping) = (&mass[i * n..][..n], &damping[i * n..][..n]);
            let inertia: f64 = mass.iter().zip(&next.a).map(|(m, a)| m * a).sum();
            let drag: f64 = damping.iter().zip(&next.v).map(|(c, v)| c * v).sum();
            r[i] += inertia + drag;
            let row = k[i * stride..=i * stride + i].iter_mut().zip(mass).zip(damping);
            row.for_each(|((k, m), c)| *k += rates.ca * m + rates.cv * c);
        }
    }

    fn kinematics(&mut self, q: &[f64]) {
        let Self { integrator, dt, past, next, .. } = self;
        integrator.kinematics(past, *dt, q, &mut next.v, &mut next.a);
    }

    /// Ends a step at the displacement coordinates `q`; `advance` computes the history of the points. False if it fails; the start of the step is
    /// then kept.
    pub fn accept(&mut self, q: &[f64], advance: impl FnOnce(&[f64], &mut [f64]) -> bool) -> bool {
        self.kinematics(q);
        if !advance(&self.past.history, &mut self.next.history) {
            return false;
        }
        let Self { integrator, dt, past, next, before, .. } = self;
        next.x.copy_from_slice(q);
        next.t = past.t + *dt;
        integrator.finish(past, *dt, next);
        std::mem::swap(past, next);
        std::mem::swap(next, before);
        self.stepped = true;
        true
    }

    /// Returns to the start of the last completed step, for its derivatives; false if there is none, or if a later step failed.
    pub fn go_back(&mut self) -> bool {
        if self.stepped {
            std::mem::swap(&mut self.past, &mut self.before);
            self.begin();
        }
        self.stepped
    }

    /// Undoes [`Motion::go_back`].
    pub fn go_on(&mut self) {
        std::mem::swap(&mut self.past, &mut self.before);
    }
}
