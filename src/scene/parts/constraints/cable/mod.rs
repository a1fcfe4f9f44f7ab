//! Constraint `cable`: its specification, files of guides, construction and record.

mod build;
mod guides;
mod places;
mod record;
mod spec;

pub(in crate::scene) use build::{build_cables, check_shortening};
pub(in crate::scene) use places::note_places;
pub use record::{CableEvent, Condition, NamedCable};
pub(in crate::scene) use record::{CableLog, pulling};
pub use spec::{CableDriveSpec, CableSpec, GuideFile, GuidesSpec, PullPointSpec, RingSpec};
