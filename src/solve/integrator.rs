//! Time integrators as affine maps x ↦ (v, a): all forces and constraints are evaluated at the end of the step.

use crate::math::statistics::larger;
use crate::system::{Rates, State};
use serde::{Deserialize, Serialize};

/// Rule that gives velocity and acceleration from the displacement at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Integrator {
    /// No rates: a sequence of equilibria; t only orders the loads
    Static,
    /// A sequence of equilibria with the time of the loads as an unknown, which continues past limit points; at most `max_steps` steps
    ArcLength { max_steps: usize },
    /// v = (x − xₙ)/Δt, a = (v − vₙ)/Δt; first order, with numerical damping. `linearised`: one Newton iteration per step, accepted as it is, for
    /// comparison with simulators that work in this way
    ImplicitEuler { linearised: bool },
    /// Implicit Euler with contact corrections, `corrected_steps`, for comparison: `integration_steps` steps in each step of the time grid
    FreeMotion { integration_steps: usize },
    /// Backward differentiation of second order with variable steps, applied to x and to v. The first step is implicit Euler, with the initial
    /// accelerations of prescribed motions; at impacts of rigid bodies the rule is restarted by an implicit Euler step
    Bdf2,
    /// Generalised-α in the form of Arnold & Brüls (2007), eqs. 6–9: with the algorithmic acceleration q, (1 − α_m) qₙ₊₁ + α_m qₙ = (1 − α_f) aₙ₊₁ +
    /// α_f aₙ, and equilibrium and constraints hold exactly at tₙ₊₁. Coefficients of Chung & Hulbert (1993) from the spectral radius ρ∞
    GeneralisedAlpha { rho: f64 },
    /// Newmark (1959): α_m = α_f = 0
    Newmark { beta: f64, gamma: f64 },
}

struct Alpha {
    am: f64,
    af: f64,
    beta: f64,
    gamma: f64,
}

/// Name of an integrator as written in papers, from its name in files; `None` if it is unknown.
pub fn integrator_title(name: &str) -> Option<&'static str> {
    let title = match name {
        "static" => "static",
        "arc_length" => "arc length",
        "implicit_euler" => "implicit Euler",
        "implicit_euler_linearised" => "implicit Euler (linearised)",
        "implicit_euler_corrected" => "implicit Euler (free motion and one contact correction)",
        "bdf2" => "BDF2",
        "generalised_alpha" => "generalised-α",
        "newmark" => "Newmark",
        _ => return None,
    };
    Some(title)
}

/// Order of convergence of an integrator in the time step, from its name in files, for Newmark's with γ = ½; `None` for static ones.
pub fn integrator_order(name: &str) -> Option<u8> {
    match name {
        "static" | "arc_length" => None,
        "implicit_euler" | "implicit_euler_linearised" | "implicit_euler_corrected" => Some(1),
        _ => Some(2),
    }
}

impl Integrator {
    pub fn is_static(self) -> bool {
        matches!(self, Self::Static | Self::ArcLength { .. })
    }

    /// Order of convergence in the time step; `None` for static integrators.
    pub fn order(self) -> Option<u8> {
        match self {
            Self::Newmark { gamma, .. } if gamma != 0.5 => Some(1),
            _ => integrator_order(self.name()),
        }
    }

    /// Name of the integrator in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::ArcLength { .. } => "arc_length",
            Self::ImplicitEuler { linearised: false } => "implicit_euler",
            Self::ImplicitEuler { linearised: true } => "implicit_euler_linearised",
            Self::FreeMotion { .. } => "implicit_euler_corrected",
            Self::Bdf2 => "bdf2",
            Self::GeneralisedAlpha { .. } => "generalised_alpha",
            Self::Newmark { .. } => "newmark",
        }
    }

    /// Whether each step is one linearised iteration, not iterated to convergence.
    pub fn is_linearised(self) -> bool {
        matches!(self, Self::ImplicitEuler { linearised: true } | Self::FreeMotion { .. })
    }

    /// Whether the step is one iteration with the tangent at its start. Friction is then linearised as sticking; linearised at a point that has slid,
    /// its force would not depend on the motion.
    pub fn is_one_iteration(self) -> bool {
        matches!(self, Self::ImplicitEuler { linearised: true })
    }

    /// Whether the acceleration at the start is needed, as by the Newmark family.
    pub fn needs_initial_acceleration(self) -> bool {
        self.alpha().is_some()
    }

    /// Whether the rule is undamped at high frequencies, so that equality constraints make it oscillate (Cardona & Géradin 1989).
    pub fn rings_with_constraints(self) -> bool {
        match self {
            Self::Newmark { gamma, .. } => gamma <= 0.5,
            Self::GeneralisedAlpha { rho } => rho >= 1.0,
            _ => false,
        }
    }

    fn alpha(self) -> Option<Alpha> {
        match self {
            Self::GeneralisedAlpha { rho } => {
                let (am, af) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
                let gamma = 0.5 + af - am;
                Some(Alpha { am, af, beta: 0.25 * (0.5 + gamma).powi(2), gamma })
            }
            Self::Newmark { beta, gamma } => Some(Alpha { am: 0.0, af: 0.0, beta, gamma }),
            _ => None,
        }
    }

    /// Sets the memory of the integrator at its first state, `state`: the accelerations, if the rule starts with any; unknown ones are zero for BDF2
    /// and implicit Euler.
    pub fn begin(self, state: &mut State) {
        state.dt = 0.0;
        state.memory = if self.is_static() { Vec::new() } else { state.a.clone() };
        if self.is_static() {
            state.v.fill(0.0);
            state.a.fill(0.0);
        }
    }

    /// Whether a multi-step rule starts at this state, without an earlier step to continue from.
    pub(super) fn begins_at(self, state: &State) -> bool {
        self == Self::Bdf2 && state.memory.len() != 2 * state.x.len()
    }

    /// The coefficient c in the velocity v = ṡ + c Δt² s⃛ that an undamped rule preserves for a prescribed motion x = s(t). Started with ṡ itself,
    /// such a rule oscillates about that velocity indefinitely, and its acceleration oscillates with an amplitude that grows by ⅓ Δt |s⃛| in every
    /// step. Other rules forget their initial values, with c = 0.
    pub(super) fn offset(self) -> f64 {
        match self.alpha() {
            Some(Alpha { beta, .. }) if self.rings_with_constraints() => 1.0 / 6.0 - beta,
            _ => 0.0,
        }
    }

    /// Clears the earlier steps from a state, so that a multi-step rule restarts there.
    pub(super) fn forget(self, state: &mut State) {
        if self == Self::Bdf2 {
            state.memory.clear();
        }
    }

    /// ∂v/∂x and ∂a/∂x for a step of length `dt` from `past`.
    pub fn rates(self, past: &State, dt: f64) -> Rates {
        if let Some(Alpha { am, af, beta, gamma }) = self.alpha() {
            return Rates { cv: gamma / (beta * dt), ca: (1.0 - am) / ((1.0 - af) * beta * dt * dt) };
        }
        match self {
            Self::Static | Self::ArcLength { .. } => Rates::default(),
            Self::Bdf2 if !self.begins_at(past) => {
                let w = dt / past.dt;
                let c = (1.0 + 2.0 * w) / (1.0 + w) / dt;
                Rates { cv: c, ca: c * c }
            }
            _ => Rates { cv: 1.0 / dt, ca: 1.0 / (dt * dt) },
        }
    }

    /// Computes v and a at the end of a step that reaches displacement `x`.
    pub fn kinematics(self, past: &State, dt: f64, x: &[f64], v: &mut [f64], a: &mut [f64]) {
        let n = x.len();
        if let Some(Alpha { am, af, beta, gamma }) = self.alpha() {
            for i in 0..n {
                let q0 = past.memory[i];
                let q = (x[i] - past.x[i] - dt * past.v[i] - dt * dt * (0.5 - beta) * q0) / (beta * dt * dt);
                v[i] = past.v[i] + dt * ((1.0 - gamma) * q0 + gamma * q);
                a[i] = ((1.0 - am) * q + am * q0 - af * past.a[i]) / (1.0 - af);
            }
            return;
        }
        match self {
            Self::Static | Self::ArcLength { .. } => {
                v.fill(0.0);
                a.fill(0.0);
            }
            Self::Bdf2 if !self.begins_at(past) => {
                let w = dt / past.dt;
                let (c, c0, c1) = ((1.0 + 2.0 * w) / (1.0 + w) / dt, (1.0 + w) / dt, w * w / (1.0 + w) / dt);
                let (x1, v1) = past.memory.split_at(n);
                for i in 0..n {
                    v[i] = c * x[i] - c0 * past.x[i] + c1 * x1[i];
                    a[i] = c * v[i] - c0 * past.v[i] + c1 * v1[i];
                }
            }
            _ => {
                // A known acceleration at the start is that of the whole step: BDF2 then has v at the end of the step, while implicit Euler keeps v
                // of its middle
                let (of_v, of_a) = if self == Self::Bdf2 { (0.5 * dt, 0.0) } else { (0.0, 0.5) };
                for i in 0..n {
                    let known = past.memory.get(i).copied().unwrap_or(0.0);
                    v[i] = (x[i] - past.x[i]) / dt + of_v * known;
                    a[i] = (v[i] - past.v[i]) / dt + of_a * known;
                }
            }
        }
    }

    /// Largest error |x − x(t)| \[m\] over `dofs` that the step from `past` to `next`, a finished state, contributed: the leading error term of the
    /// rule for exact past values, with the required derivative of x taken from the accelerations of the rule. For the Newmark family this is the
    /// estimate of Zienkiewicz & Xie (1991).
    ///
    /// Limits: Newmark with γ ≠ ½ loses accuracy through v, which this estimate does not include.
    pub fn local_error(self, past: &State, next: &State, dofs: &[u32]) -> f64 {
        let dt = next.t - past.t;
        let (share, now, before) = match self.alpha() {
            Some(Alpha { am, af, beta, .. }) => (beta + 0.5 * (am - af) - 1.0 / 6.0, &next.memory, Some(&past.memory)),
            None if self == Self::Bdf2 && !self.begins_at(past) => {
                let w = dt / past.dt;
                ((1.0 + w).powi(2) / (6.0 * w * (1.0 + 2.0 * w)), &next.a, Some(&past.a))
            }
            None => (0.5, &next.a, None),
        };
        let change = |i: usize| now[i] - before.map_or(0.0, |a| a[i]);
        share.abs() * dt * dt * dofs.iter().map(|&i| change(i as usize).abs()).fold(0.0, larger)
    }

    /// Number of cuts of a step, each a halving, that reduces its local error by `factor`.
    pub fn cuts_for(self, factor: f64) -> f64 {
        let power = match self {
            Self::ImplicitEuler { .. } | Self::FreeMotion { .. } => 2.0,
            // Of Newmark's method with any γ
            _ => 3.0,
        };
        factor.log2() / power
    }

    /// Completes an accepted state, in which x, v, a, λ and t are set; does not allocate if its memory has the capacity.
    pub fn finish(self, past: &State, dt: f64, next: &mut State) {
        next.dt = dt;
        let State { x, memory, .. } = next;
        memory.clear();
        if let Some(Alpha { beta, .. }) = self.alpha() {
            memory.extend((0..x.len()).map(|i| {
                let predicted = past.x[i] + dt * past.v[i] + dt * dt * (0.5 - beta) * past.memory[i];
                (x[i] - predicted) / (beta * dt * dt)
            }));
        } else if self == Self::Bdf2 {
            memory.extend(past.x.iter().chain(&past.v));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Integrator; 6] = [
        Integrator::ImplicitEuler { linearised: false },
        Integrator::Bdf2,
        Integrator::GeneralisedAlpha { rho: 0.8 },
        Integrator::GeneralisedAlpha { rho: 0.0 },
        Integrator::Newmark { beta: 0.25, gamma: 0.5 },
        Integrator::Newmark { beta: 0.3025, gamma: 0.6 },
    ];

    /// Errors of x and v at the end of one period of x'' = −ω² x in `steps` steps, whose lengths alternate if the rule retains its full order with
    /// variable steps.
    fn oscillator(integrator: Integrator, steps: usize) -> f64 {
        let variation = if integrator == Integrator::Bdf2 { 0.2 } else { 0.0 };
        let omega = std::f64::consts::TAU;
        let mut state = State { x: vec![1.0], v: vec![0.0], a: vec![-omega * omega], ..State::rest(0, 0) };
        integrator.begin(&mut state);
        let dts = (0..steps).map(|k| (1.0 + if k % 2 == 0 { variation } else { -variation }) / steps as f64);
        for dt in dts {
            // With a = ca·x + â, solve ca·x + â + ω²x = 0
            let rates = integrator.rates(&state, dt);
            let (mut v, mut a) = (vec![0.0], vec![0.0]);
            integrator.kinematics(&state, dt, &[0.0], &mut v, &mut a);
            let x = -a[0] / (rates.ca + omega * omega);
            integrator.kinematics(&state, dt, &[x], &mut v, &mut a);
            let mut next = State { x: vec![x], v, a, ..state.clone() };
            integrator.finish(&state, dt, &mut next);
            state = next;
        }
        (state.x[0] - 1.0).abs() + state.v[0].abs() / omega
    }

    #[test]
    fn rates_are_the_derivatives_of_the_kinematics() {
        for integrator in ALL {
            let mut past = State { x: vec![0.3], v: vec![-1.0], a: vec![2.0], ..State::rest(0, 0) };
            integrator.begin(&mut past);
            if integrator == Integrator::Bdf2 {
                past.memory = vec![0.1, 0.7];
                past.dt = 0.02;
            }
            let at = |x: f64| {
                let (mut v, mut a) = (vec![0.0], vec![0.0]);
                integrator.kinematics(&past, 0.01, &[x], &mut v, &mut a);
                (v[0], a[0])
            };
            let (low, high) = (at(1.0), at(2.0));
            let rates = integrator.rates(&past, 0.01);
            // Affine maps: the difference over a unit step is exact up to rounding of numbers of size ca
            assert!((high.0 - low.0 - rates.cv).abs() < 1e-11 * rates.ca, "{integrator:?}");
            assert!((high.1 - low.1 - rates.ca).abs() < 1e-11 * rates.ca, "{integrator:?}");
        }
    }

    /// One step of x'' = −ω² x from exact values, with q where the rule has it, at α_f − α_m of a step away.
    #[test]
    fn the_local_error_is_that_of_one_step_from_exact_values() {
        let (omega, t0, dt, before) = (std::f64::consts::TAU, 0.3, 1e-3, 0.8e-3);
        let x = |t: f64| (omega * t).cos();
        let v = |t: f64| -omega * (omega * t).sin();
        let a = |t: f64| -omega * omega * x(t);
        for integrator in ALL {
            let shift = integrator.alpha().map_or(0.0, |alpha| alpha.am - alpha.af);
            let memory = match integrator {
                Integrator::Bdf2 => vec![x(t0 - before), v(t0 - before)],
                Integrator::ImplicitEuler { .. } => Vec::new(),
                _ => vec![a(t0 + shift * dt)],
            };
            let past = State {
                x: vec![x(t0)],
                v: vec![v(t0)],
                a: vec![a(t0)],
                t: t0,
                dt: before,
                memory,
                ..State::rest(0, 0)
            };
            let rates = integrator.rates(&past, dt);
            let (mut v, mut a) = (vec![0.0], vec![0.0]);
            integrator.kinematics(&past, dt, &[0.0], &mut v, &mut a);
            let end = -a[0] / (rates.ca + omega * omega);
            integrator.kinematics(&past, dt, &[end], &mut v, &mut a);
            let mut next = State { x: vec![end], v, a, t: t0 + dt, ..past.clone() };
            integrator.finish(&past, dt, &mut next);
            let (estimate, error) = (integrator.local_error(&past, &next, &[0]), (end - x(t0 + dt)).abs());
            // The next term of the series is ω dt = 0.006 of the leading one, times a constant of the rule
            assert!((estimate / error - 1.0).abs() < 0.05, "{integrator:?}: {estimate:.4e} for {error:.4e}");
            // NaN accelerations have no error that could be within a bound
            let unknown = State { a: vec![f64::NAN], memory: vec![f64::NAN; next.memory.len()], ..next };
            assert!(integrator.local_error(&past, &unknown, &[0]).is_nan(), "{integrator:?}");
        }
    }

    #[test]
    fn order_of_accuracy() {
        for integrator in ALL {
            let expected = integrator.order().map_or(f64::NAN, f64::from);
            let order = (oscillator(integrator, 800) / oscillator(integrator, 1600)).log2();
            // The next term of the error series is at most 1/400 of the first, so that 0.1 leaves a margin
            assert!((order - expected).abs() < 0.1, "{integrator:?}: order {order}");
        }
    }
}
