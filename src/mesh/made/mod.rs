//! Meshes made without a mesher, and modifications of meshes.

pub mod curved;
pub mod disturb;
pub mod enrich;
pub mod graded;
pub mod parts;
pub mod structured;
