//! Tetrahedral meshes with named regions.
//!
//! | Subject | Where |
//! |---|---|
//! | The mesh, its cells and their integration | [`TetMesh`], [`element`], [`quadrature`], [`Order`] |
//! | Files | `file` |
//! | Meshes by gmsh or CGAL | [`generate`] |
//! | Meshes made without a mesher, and modified meshes | `made` |
//! | Surfaces of a mesh, and surfaces from files | `surface` |
//! | Points, balls and regions of space in a mesh | [`embed`], [`ball`], [`select`] |
//! | Limits of a mesh: poor cells, thin walls, gaps, overlaps | [`quality`] |

pub mod ball;
pub mod cell_order;
pub mod element;
pub mod embed;
pub mod error;
mod file;
pub mod generate;
mod geometry;
mod locator;
mod made;
mod order;
pub mod polyline;
pub mod quadrature;
pub mod quality;
pub mod select;
mod surface;
mod tet_mesh;

pub use error::MeshError;
pub use file::assemble::{Changes, Reading};
pub use file::read::{read, read_as};
pub use file::{census, format, grid_file, surface_file, validate, vtu};
pub use made::{curved, disturb, enrich, graded, parts, structured};
pub use order::Order;
pub use quality::{gap, hinge, notch, overlap, wall};
pub use surface::{
    attach, boundary, closed_surface, distance, divided, flat, interface, pieces, rim, row_of_sides, smooth_surface,
};
pub use tet_mesh::{Region, TetMesh};
