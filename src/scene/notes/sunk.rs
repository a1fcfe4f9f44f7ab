//! Facets that have penetrated an obstacle between their contact points during a run.

use crate::mesh::TetMesh;
use crate::scene::parts::contact::NamedContact;

/// The deepest point of the facets of a contact inside its obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct SunkenFacet {
    pub contact: String,
    /// Time of the state \[s\]
    pub t: f64,
    /// Depth \[m\]
    pub depth: f64,
    /// Position in space \[m\]
    pub at: [f64; 3],
}

/// The deepest facet of every contact that is too deep in one of these states; a state is its time and displacements.
pub(in crate::scene) fn sunken(
    mesh: &TetMesh,
    contacts: &[NamedContact],
    states: &[(f64, &[f64])],
) -> Vec<SunkenFacet> {
    let of = |contact: &NamedContact| {
        let of_state = |&(t, x): &(f64, &[f64])| {
            let (at, depth) = contact.sunken(mesh, x)?;
            Some(SunkenFacet { contact: contact.name.clone(), t, depth, at: at.into() })
        };
        states.iter().filter_map(of_state).max_by(|a, b| a.depth.total_cmp(&b.depth))
    };
    contacts.iter().filter_map(of).collect()
}
