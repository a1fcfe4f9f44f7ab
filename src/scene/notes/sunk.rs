//! Facets that a run has brought into an obstacle between their contact points.

use crate::mesh::TetMesh;
use crate::scene::parts::contact::NamedContact;

/// The deepest place of the facets of a contact inside of its obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct SunkenFacet {
    pub contact: String,
    /// Time of the state \[s\]
    pub t: f64,
    /// Depth \[m\]
    pub depth: f64,
    /// Where it is in space \[m\]
    pub at: [f64; 3],
}

/// Those of the contacts that are too deep in some of these states, each given by its time and its displacements.
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
