//! Physical contributions: one file per effect or constraint.

pub mod cable;
pub mod cavity;
mod cell;
pub mod damping;
pub mod elastic;
pub mod gravity;
pub mod inertia;
pub mod mass;
pub mod mean_dilatation;
pub mod mixed;

pub use cable::{Cable, CableLength, CableTension, Guide};
pub use cavity::{Cavity, CavityPressure, CavityVolume};
pub use cell::CellPoints;
pub use damping::{MassDamping, ViscousDamping};
pub use elastic::Elastic;
pub use gravity::Gravity;
pub use inertia::Inertia;
pub use mass::{Lumping, Mass};
pub use mean_dilatation::MeanDilatation;
pub use mixed::{MixedElastic, pressure_hosts};
