//! Reduced models: scenes with few unknowns, fast enough for controllers, that know how far they are from the full model.
//!
//! | Step | File |
//! |---|---|
//! | Fields and forces at the points of the body | [`body_points`], [`fields_at_points`], [`points_at`] |
//! | Modes of displacement and pressure | [`basis`] |
//! | The points from which forces are summed | [`sampling`] |
//! | Constants of laws that are inputs | [`constants`], on [`running_laws`] |
//! | Loads, cables and quantities in the coordinates | [`forces`], [`quantities`], [`polynomial`], [`inputs`] |
//! | Adjoint solutions for the error estimate | [`adjoint_space`] |
//! | All of it | [`train`] |
//! | States that are wanted next | [`greedy`] |
//! | The model, and its file | [`model`], [`mod@file`] |
//! | Inputs for given values | [`inverse`] |
//! | The full model behind it | [`full_model`], [`fallback`] |
//! | A model that runs | [`twin`], on [`equations`], [`points`], [`running_cable`] and [`residual`] |

pub mod adjoint_space;
pub mod basis;
pub mod body_points;
pub mod constants;
mod dense;
pub mod dynamics;
pub mod equations;
pub mod error;
pub mod fallback;
pub mod fields_at_points;
pub mod file;
pub mod forces;
pub mod full_model;
mod full_state;
pub mod greedy;
pub mod inputs;
pub mod inverse;
mod lanes;
pub mod model;
pub mod motion;
mod parted_law;
pub mod points;
pub mod points_at;
pub mod polynomial;
pub mod quantities;
pub mod rate_points;
pub mod residual;
pub mod running_cable;
pub mod running_laws;
pub mod sampling;
pub mod train;
pub mod transient;
pub mod twin;

use crate::scene::Scene;

pub use constants::ConstantInputs;
pub use equations::Position;
pub use error::{ModelFileError, ReductionError};
pub use fallback::Fallback;
pub use full_model::FullModel;
pub use full_state::FullState;
pub use inputs::Input;
pub use model::ReducedModel;
pub use train::{Training, errors};
pub use transient::{TransientTraining, errors_in_time};
pub use twin::{StepError, StepReport, Twin, TwinState};

/// Refuses a scene that has no reduced model of these recorded columns, as training on its runs would.
pub fn check(scene: &Scene, columns: &[String]) -> Result<(), ReductionError> {
    match scene.spans.iter().all(|span| span.integrator.is_static()) {
        true => forces::check(scene)?,
        false => drop(transient::check_in_time(scene)?),
    }
    let known = quantities::names(scene);
    match columns.iter().find(|name| !known.contains(name)) {
        Some(name) => Err(ReductionError::Quantity { name: name.clone(), known: known.join(", ") }),
        None => Ok(()),
    }
}
