//! Impacts of rigid bodies with BDF2: the rule would carry the velocity before an impact along, and throw the body back with up to 1.6 times
//! its energy. It begins anew there, with implicit Euler, which loses energy in every impact, and goes on from the states after it.
//!
//! An impact is a step that changes the acceleration of the body by the velocity that it has, or a share of it:
//!
//! ```text
//! Δt max |aₙ₊₁ − aₙ| > ABRUPT · max(max |vₙ₊₁|, max |vₙ|)
//! ```
//!
//! over the nodes that carry the body. A smooth motion of the circular frequency ω has (ω Δt)² there, also where its velocity passes through zero.
//! What a body that deforms carries along is that of its points in contact, a share that falls with the mesh size; it is left to the rule.
//!
//! Source: restarts of multistep methods at discontinuities, Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I* (1993), §II.6.

use super::{Integrator, Step};
use crate::system::State;

/// Share of the velocity of a body that an impact changes at least \[–\]. Below it, at most its square of the energy is that of the motion across.
const ABRUPT: f64 = 0.2;
/// Motion that such a change makes in a step, as a share of the length of the body \[–\]; below it the body rests.
const STILL: f64 = 1e-6;

/// Whether a rigid body has hit something in the step to `next`, by a rule that remembers steps, in a body of this length \[m\]; not in the first step of a
/// stage.
pub(super) fn is_impact(step: &Step, next: &State, length: f64) -> bool {
    let Step { system, integrator, past, dt } = *step;
    if integrator != Integrator::Bdf2 || past.dt == 0.0 {
        return false;
    }
    let is_hit = |nodes: &[u32]| {
        let dofs = || nodes.iter().flat_map(|&node| 3 * node as usize..3 * node as usize + 3);
        let largest = |of: &dyn Fn(usize) -> f64| dofs().fold(0.0, |most: f64, i| most.max(of(i).abs()));
        let change = dt * largest(&|i| next.a[i] - past.a[i]);
        let speed = largest(&|i| next.v[i]).max(largest(&|i| past.v[i]));
        change > ABRUPT * speed && dt * change > STILL * length
    };
    system.turning_bodies().any(is_hit)
}
