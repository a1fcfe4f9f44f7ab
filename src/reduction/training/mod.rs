//! Training: from runs of the full model to a reduced model.

pub mod adjoint_space;
pub mod basis;
pub mod body_points;
pub mod fields_at_points;
pub mod full_model;
pub(super) mod full_state;
pub mod greedy;
pub mod points_at;
pub mod sampling;
mod steps_of_runs;
pub mod train;
pub mod transient;
