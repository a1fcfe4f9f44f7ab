//! Contact by corrections of a free motion.

pub(super) mod check;
pub(super) mod corrected_steps;
pub(super) mod correction;
mod free_bodies;
mod gauss_seidel;
mod landing;
mod law;
