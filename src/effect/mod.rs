//! Physical contributions: one file per effect or constraint.

pub mod cable;
pub mod cavity;
mod cell;
pub mod damping;
pub mod edge_dampers;
pub mod edge_springs;
mod edges;
pub mod elastic;
pub mod gravity;
pub mod inertia;
pub mod locking;
pub mod mass;
pub mod mean_dilatation;
pub mod mixed;
mod mixed_along;
mod remembered;
pub mod stiffness_damping;
pub mod viscoelastic;

pub use cable::{Cable, CableLength, CableTension, Guide};
pub use cavity::{Cavity, CavityPressure, CavityVolume};
pub use cell::CellPoints;
pub use damping::{MassDamping, ViscousDamping};
pub use edge_dampers::EdgeDampers;
pub use edge_springs::EdgeSprings;
pub use elastic::Elastic;
pub use gravity::Gravity;
pub use inertia::Inertia;
pub use locking::Stressed;
pub use mass::{Lumping, Mass};
pub use mean_dilatation::MeanDilatation;
pub use mixed::{MixedElastic, pressure_hosts};
pub use stiffness_damping::{Stiffness, StiffnessDamping};
pub use viscoelastic::Viscoelastic;
