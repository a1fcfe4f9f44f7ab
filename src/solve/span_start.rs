//! The start of a span: whether the integrator continues with its memory, and the initial rates of prescribed motions.
//!
//! The initial accelerations of a prescribed motion s(t) are s̈(t₀⁺). Starting from 0, the integrators would need several steps to find them, and the
//! reactions, mass times acceleration, would be wrong until then at any Δt; with an undamped rule they would stay wrong indefinitely.

use super::TimeSpan;
use crate::math::signal::Clock;
use crate::system::{State, System};

/// A span that starts, and the span before it.
#[derive(Clone, Copy, Debug)]
pub struct SpanStart<'a> {
    pub span: &'a TimeSpan,
    pub before: Option<&'a TimeSpan>,
}

impl SpanStart<'_> {
    /// Whether the span continues the one before it as if both were one: it has the same integrator and the same nominal step, and the other span
    /// ended with a whole step. After a shorter last step, a multi-step rule would carry the errors of that step along, and an undamped one would
    /// keep its velocity error indefinitely.
    pub fn goes_on(&self) -> bool {
        let Self { span, before } = self;
        let is_same = |before: &TimeSpan| {
            before.integrator == span.integrator && before.dt == span.dt && before.ends_with_whole_step()
        };
        !span.integrator.is_static() && before.is_some_and(is_same)
    }

    /// Whether the span before had velocities.
    fn has_moved(&self) -> bool {
        self.before.is_some_and(|before| !before.integrator.is_static())
    }

    /// \[2 × prescribed dofs\] initial rates of the prescribed motions of a system: velocities, which are added to those of the state, and
    /// accelerations. After a dynamic span the velocities replace those of the state, because with implicit Euler these lag behind by half a step.
    /// For an undamped rule a second-order term is added ([`Integrator::offset`](super::Integrator)).
    pub(super) fn given_rates(&self, system: &System, now: Clock) -> Vec<f64> {
        let TimeSpan { integrator, dt, .. } = *self.span;
        // Zero for a formula that is not defined where its derivatives evaluate it
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let velocities = system.prescribed.iter().map(|p| {
            let kept = if self.has_moved() { p.signal.rate_before(now) } else { 0.0 };
            if integrator.offset() == 0.0 {
                return finite(kept);
            }
            let [a, b, c] = [0.0, 1.0, 2.0].map(|k| p.signal.acceleration(Clock { t: now.t + k * dt, ..now }));
            finite(kept) + finite(0.5 * integrator.offset() * dt * (4.0 * b - 3.0 * a - c))
        });
        velocities.chain(system.prescribed.iter().map(|p| finite(p.signal.acceleration(now)))).collect()
    }

    /// Sets these rates in a state, or in a derivative of one; its other dofs get no acceleration. Without mass no step depends on velocities.
    pub(super) fn give(&self, system: &System, rates: &[f64], state: &mut State) {
        state.a.fill(0.0);
        if self.span.integrator.is_static() || !system.has_mass() {
            return;
        }
        let (velocities, accelerations) = rates.split_at(system.prescribed.len());
        let mut added = vec![0.0; state.v.len()];
        for ((p, v), a) in system.prescribed.iter().zip(velocities).zip(accelerations) {
            let dof = p.dof as usize;
            added[dof] = if self.has_moved() { v - state.v[dof] } else { *v };
            state.a[dof] = *a;
        }
        system.ties.complete(&mut added);
        state.v.iter_mut().zip(&added).for_each(|(v, added)| *v += added);
        system.ties.complete(&mut state.a);
    }
}
