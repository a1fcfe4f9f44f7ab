//! Meshes made here without a mesher, and changed ones.

pub mod curved;
pub mod disturb;
pub mod enrich;
pub mod graded;
pub mod parts;
pub mod structured;
