//! Surfaces of a mesh, and surfaces from files.

pub mod attach;
pub mod boundary;
pub mod closed_surface;
pub mod distance;
pub mod divided;
pub mod flat;
pub mod interface;
pub mod pieces;
pub mod rim;
pub mod row_of_sides;
pub mod smooth_surface;
