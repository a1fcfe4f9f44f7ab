//! Parts of a scene: one file per kind, with its specification, its construction and what is recorded of it.

pub mod probes;
