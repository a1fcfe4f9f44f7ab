//! The contacts of a run as its record keeps them.

use crate::effect::contact::Counts;
use crate::scene::parts::contact::record::NamedContact;
use crate::scene::{Run, Scene};
use serde::{Deserialize, Serialize};

/// Counts and times of one contact over a run.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct ContactRecord {
    pub name: String,
    /// Points of the surface
    pub points: usize,
    /// Points times evaluations
    pub seen: usize,
    /// Distances computed
    pub tested: usize,
    /// Points that were near enough to count
    pub active: usize,
    /// Time to find them \[s\]
    pub search_s: f64,
    /// Time to find how far steps may go \[s\]
    pub detection_s: f64,
}

pub(super) fn contacts(scene: &Scene, run: &Run) -> Vec<ContactRecord> {
    let record = |(contact, (name, counts)): (&NamedContact, &(String, Counts))| ContactRecord {
        name: name.clone(),
        points: contact.point_count(),
        seen: counts.points,
        tested: counts.tested,
        active: counts.active,
        search_s: counts.search.as_secs_f64(),
        detection_s: counts.detection.as_secs_f64(),
    };
    scene.contacts.iter().zip(&run.contacts).map(record).collect()
}
