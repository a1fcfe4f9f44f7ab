//! Friction that is at its limit at all points of a contact.

use crate::scene::build::Scene;
use crate::scene::parts::contact::NamedContact;
use crate::system::State;

/// A note for each contact in a static stage whose friction is at its limit at all of its points at a state: if nothing else holds the body, there is no
/// equilibrium beyond it.
pub fn friction_at_limit(scene: &Scene, state: &State) -> Vec<String> {
    let stage = scene.spans.iter().rfind(|span| span.start <= state.t);
    if stage.is_none_or(|stage| !stage.integrator.is_static()) {
        return Vec::new();
    }
    let at_limit = scene.contacts.iter().filter_map(|contact| Some((contact, contact.at_limit_of_friction(state)?)));
    let words = |(contact, points): (&NamedContact, usize)| {
        format!(
            "{}: at t = {:.6} s friction is at its limit at all points that press ({points}): where nothing else holds the body there is no equilibrium beyond it, whatever \
             the mesh; hold the body, or let it slide in a dynamic stage",
            contact.name, state.t
        )
    };
    at_limit.map(words).collect()
}
