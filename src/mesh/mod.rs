//! Tetrahedral meshes with named regions.

mod assemble;
pub mod attach;
pub mod boundary;
mod cursor;
pub mod curved;
pub mod distance;
pub mod disturb;
pub mod element;
pub mod embed;
pub mod enrich;
pub mod error;
pub mod flat;
pub mod generate;
mod geometry;
pub mod graded;
mod msh;
mod order;
pub mod overlap;
pub mod parts;
pub mod polyline;
pub mod quadrature;
pub mod quality;
mod read;
pub mod rim;
pub mod select;
pub mod structured;
pub mod surface_file;
mod tet_mesh;
pub mod validate;
mod vtk;
pub mod vtu;
pub mod wall;

pub use error::MeshError;
pub use order::Order;
pub use read::read;
pub use tet_mesh::{Region, TetMesh};
