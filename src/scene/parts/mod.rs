//! Parts of a scene: one file per kind, with its specification, its construction and what is recorded of it.

pub mod cable;
pub mod cavity;
pub mod contact;
pub mod drive;
pub(super) mod edge_springs;
pub(super) mod elastic;
pub(super) mod gravity;
pub(super) mod inertia;
pub(super) mod point_force;
pub mod probes;
pub mod rigid;
pub(super) mod stiffness_damping;
pub(super) mod traction;
pub(super) mod viscoelastic;
pub(super) mod viscous_damping;
