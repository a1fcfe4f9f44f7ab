//! Physical contributions: one file per effect or constraint.
//!
//! | Subject | File |
//! |---|---|
//! | Elasticity: in displacements, with mean dilatation, with pressures | [`elastic`], [`mean_dilatation`], [`mixed`], `mixed_along`,
//! `pressure_hosts` |
//! | Laws with memory | [`viscoelastic`], `remembered`, [`mullins`] |
//! | Fibres, and sheets on facets | [`fibres`], [`fibre_families`], [`membrane`], [`wrinkling`] |
//! | Springs and dampers on the edges of a mesh | [`edge_springs`], [`edge_dampers`], `edges` |
//! | Mass and damping | [`mass`], [`inertia`], [`mass_damping`], [`stiffness_damping`], [`viscous_damping`], `damping_work` |
//! | Loads | [`gravity`], [`dead_load`], [`cavity`], [`cavity_rim`], [`open_cavity`] |
//! | Cables | [`cable`], [`cable_friction`] |
//! | Contact | [`contact`] |
//! | Rigid bodies, and rigid parts of a body | [`affine_body`], [`rigid_insert`] |
//! | Integrals over cells, and the stress at their points | `cell`, `constitution`, `stress` |
//! | Indicators of wrong pressures or volumes | [`pressure_scatter`], [`volume_gap`] |

pub mod affine_body;
pub mod cable;
pub mod cable_friction;
pub mod cavity;
pub mod cavity_rim;
mod cell;
mod constitution;
pub mod contact;
mod damping_work;
pub mod dead_load;
pub mod edge_dampers;
pub mod edge_springs;
mod edges;
pub mod elastic;
pub mod fibre_families;
pub mod fibres;
pub mod gravity;
pub mod inertia;
pub mod mass;
pub mod mass_damping;
pub mod mean_dilatation;
pub mod membrane;
pub mod mixed;
mod mixed_along;
pub mod mullins;
pub mod open_cavity;
mod pressure_hosts;
pub mod pressure_scatter;
mod remembered;
pub mod rigid_insert;
pub mod stiffness_damping;
mod stress;
pub mod viscoelastic;
pub mod viscous_damping;
pub mod volume_gap;
pub mod wrinkling;

pub use cable::{Cable, CableLength, CableTension, Guide};
pub use cable_friction::Pull;
pub use cavity::{Cavity, CavityPressure, CavityVolume, VolumeField};
pub use cavity_rim::{CavityRim, flux_through_cones, middle_of_edges};
pub use cell::CellPoints;
pub use constitution::{Constitution, PressureField};
pub use contact::Contact;
pub use dead_load::DeadLoad;
pub use edge_dampers::EdgeDampers;
pub use edge_springs::EdgeSprings;
pub use elastic::Elastic;
pub use fibre_families::FibreFamilies;
pub use fibres::{FibrePoint, Fibres};
pub use gravity::Gravity;
pub use inertia::Inertia;
pub use mass::{Lumping, Mass};
pub use mass_damping::MassDamping;
pub use mean_dilatation::MeanDilatation;
pub use membrane::{Membrane, MembraneExtremes};
pub use mixed::{AddPressure, MixedElastic, cofactor_by_rows};
pub use mullins::Mullins;
pub use open_cavity::OpenCavityPressure;
pub use pressure_hosts::PressureHosts;
pub use stiffness_damping::{Stiffness, StiffnessDamping, Undamped};
pub use stress::{HistoryStress, PointStress, StressAtState, Stressed};
pub use viscoelastic::Viscoelastic;
pub use viscous_damping::{ViscousDamping, viscous_stress};
