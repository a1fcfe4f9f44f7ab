//! Contacts of a scene: their specification, construction and record.

mod build;
mod motion;
pub mod record;
pub mod spec;
mod surfaces;

pub(in crate::scene) use build::build_contacts;
pub use record::NamedContact;
pub use spec::{ContactSpec, MotionSpec, ResponseSpec};
