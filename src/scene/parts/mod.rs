//! Parts of a scene; each has a file or folder with its specification, its construction and its record.
//!
//! Effects, constraints, probes and selectors of regions come in kinds; the `mod.rs` of their folder is the registry.

pub mod constraints;
pub mod contact;
pub mod effects;
mod patch;
pub mod probes;
pub mod rigid;
pub mod selectors;
pub mod skin;
