//! Constraint `cable`: its specification, construction and record.

mod build;
mod record;
mod spec;

pub(in crate::scene) use build::build_cable;
pub use record::{CableEvent, Condition, NamedCable};
pub(in crate::scene) use record::{CableLog, pulling};
pub use spec::{CableDriveSpec, CableSpec, RingSpec};
