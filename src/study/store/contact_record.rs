//! The contacts of a run, as stored in its record.

use crate::effect::contact::Counts;
use crate::scene::parts::contact::record::NamedContact;
use crate::scene::{Run, Scene};
use serde::{Deserialize, Serialize};

/// Counts and times of one contact over a run.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct ContactRecord {
    pub name: String,
    /// Number of points of the surface
    pub points: usize,
    /// Sum of the numbers of points over all evaluations
    pub seen: usize,
    /// Number of distances computed
    pub tested: usize,
    /// Number of points that were close enough to count
    pub active: usize,
    /// Time of the search for close points \[s\]
    pub search_s: f64,
    /// Time of the detection of how far steps may go \[s\]
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
