//! Reduced models: models of a scene with few unknowns, fast enough for controllers, that estimate their distance from the full model.
//!
//! | Step | File |
//! |---|---|
//! | Fields and forces at the points of the body | [`training::body_points`], [`training::fields_at_points`], [`training::points_at`] |
//! | Modes of displacement and pressure | [`training::basis`] |
//! | The points from which forces are summed | [`training::sampling`] |
//! | Constants of laws as inputs | [`constants`], based on [`running::laws`] |
//! | Loads, cables and quantities as functions of the coordinates | [`forces`], [`quantities`], [`polynomial`], [`inputs`] |
//! | Adjoint solutions for the error estimate | [`training::adjoint_space`] |
//! | The whole training | [`training::train`] |
//! | Choice of the next training states | [`training::greedy`] |
//! | The model, and its file | [`model`], [`mod@file`] |
//! | Inputs for given values | [`running::inverse`] |
//! | The full model behind it | [`training::full_model`], [`running::fallback`] |
//! | A model that runs | [`running::twin`], based on [`running::equations`], [`points`], [`running::cable`] and [`running::residual`] |

use crate::scene::Scene;

pub mod constants;
pub mod error;
pub mod file;
pub mod forces;
pub mod inputs;
pub mod model;
pub mod points;
pub mod polynomial;
pub mod quantities;
pub mod running;
pub mod training;

pub use constants::ConstantInputs;
pub use error::{ModelFileError, ReductionError};
pub use inputs::Input;
pub use model::ReducedModel;
pub use running::equations::Position;
pub use running::fallback::Fallback;
pub use running::twin::{StepError, StepReport, Twin, TwinState};
pub use training::full_model::FullModel;
pub use training::full_state::FullState;
pub use training::train::{Training, errors};
pub use training::transient::{TransientTraining, errors_in_time};

/// Refuses a scene that has no reduced model with these recorded columns, as training on its runs would.
pub fn check(scene: &Scene, columns: &[String]) -> Result<(), ReductionError> {
    match scene.spans.iter().all(|span| span.integrator.is_static()) {
        true => forces::check(scene)?,
        false => drop(training::transient::check_in_time(scene)?),
    }
    let known = quantities::names(scene);
    match columns.iter().find(|name| !known.contains(name)) {
        Some(name) => Err(ReductionError::Quantity { name: name.clone(), known: known.join(", ") }),
        None => Ok(()),
    }
}
