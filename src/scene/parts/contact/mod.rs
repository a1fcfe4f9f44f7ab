//! Contacts of a scene: their specification, construction and record.

mod build;
mod inside;
mod motion;
mod notes;
pub mod record;
mod scales;
pub mod spec;
mod sunk;
mod surfaces;

pub(in crate::scene) use build::build_contacts;
pub use record::NamedContact;
pub use scales::ContactScales;
pub use spec::{ContactSpec, MotionSpec, ResponseSpec};
