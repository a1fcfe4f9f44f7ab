//! The start of a span: whether its rule goes on with what it remembers, and the rates that given motions have there.
//!
//! The accelerations of a motion s(t) that is given are s̈(t₀⁺): from 0 on, the rules would need steps to find them, and reactions, the mass times these
//! accelerations, would be wrong until then, at any Δt; by an undamped rule they would be for ever.

use super::TimeSpan;
use crate::math::signal::Clock;
use crate::system::{State, System};

/// A span that begins, and the one before it.
#[derive(Clone, Copy, Debug)]
pub struct SpanStart<'a> {
    pub span: &'a TimeSpan,
    pub before: Option<&'a TimeSpan>,
}

impl SpanStart<'_> {
    /// Whether the span continues the one before, as if both were one: it has the same rule and the same nominal step, with which that one ended. After a shorter
    /// last step a rule of several steps would carry the errors of that step on, and an undamped one its velocity for ever.
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

    /// \[2 × prescribed dofs\] rates of the motions that a system is given: velocities, in addition to those that are kept, and accelerations. After a dynamic span
    /// none is kept, as implicit Euler is half a step late with them. An undamped rule has an addition of second order ([`Integrator::offset`](super::Integrator)).
    pub(super) fn given_rates(&self, system: &System, now: Clock) -> Vec<f64> {
        let TimeSpan { integrator, dt, .. } = *self.span;
        // None of a formula that is not defined where its derivatives look for it
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

    /// Gives a state, or a derivative of one, these rates; its other dofs get no acceleration. Without mass no step keeps a velocity.
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
