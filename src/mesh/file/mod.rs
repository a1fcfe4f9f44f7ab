//! Files of meshes, surfaces and fields: recognition by their content, checks, and writing.

pub(super) mod assemble;
pub mod census;
mod cursor;
pub mod format;
pub mod grid_file;
mod mid_nodes;
mod msh;
mod msh2;
mod msh_elements;
pub(super) mod read;
mod solid;
pub mod surface_file;
pub mod validate;
mod vtk;
pub mod vtu;
