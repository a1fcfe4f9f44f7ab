//! Scenes and quantities that have no estimate from one run, with the reason and the remedy.

use crate::scene::error::hint;
use crate::scene::{Scene, SceneError};
use crate::solve::Integrator;

/// Reason why a run has no error estimate.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    #[error(
        "stage {stage} is {integrator}: the error of a run in time is not estimated from one run; take a family of meshes, or \
         integrator = {{ kind = \"static\" }}"
    )]
    NotStatic { stage: usize, integrator: &'static str },
    #[error(
        "{part} depends on the path of loading, which the estimate from one state does not follow; take a family of meshes, or remove it"
    )]
    Path { part: String },
    #[error("{why}, so the answer has no limit as h → 0, and no error")]
    NoLimit { why: String },
    #[error(
        "the scene has a mesh, laws, effects or recorders from Rust that are not known for the enriched mesh: {why}"
    )]
    Additions { why: String },
    #[error("{name} is not estimated, only what is a function of the state; {}", hint(name, known))]
    Column { name: String, known: Vec<String> },
    #[error(
        "the estimator has {states} states of a run with {rows} rows; hand each of them to `add`, from the start of the run on"
    )]
    OtherRun { states: usize, rows: usize },
    #[error("the enriched mesh makes a scene that is refused: {0}")]
    Enriched(#[from] SceneError),
    #[error("the enriched mesh has no solution at t = {t} s ({status}); take a family of meshes")]
    NotSolved { t: f64, status: &'static str },
}

/// Refuses a scene whose states are not functions of the loads at the same time.
pub(super) fn check(scene: &Scene) -> Result<(), EstimateError> {
    let stages = scene.spans.iter().enumerate();
    if let Some((k, span)) = stages.clone().find(|(_, span)| span.integrator != Integrator::Static) {
        return Err(EstimateError::NotStatic { stage: k + 1, integrator: span.integrator.name() });
    }
    if let Some(part) = path_dependence(scene) {
        return Err(EstimateError::Path { part });
    }
    match &scene.no_limit {
        Some(why) => Err(EstimateError::NoLimit { why: why.clone() }),
        None => Ok(()),
    }
}

/// A part of the scene by which static states depend on the path of loading, if there is one.
pub fn path_dependence(scene: &Scene) -> Option<String> {
    if let Some(effect) = scene.system.effects.iter().find(|e| e.capabilities().history.is_some()) {
        return Some(format!("the effect {}", effect.name()));
    }
    if let Some(cable) = scene.cables.iter().find(|c| c.friction) {
        return Some(format!("the friction of the {}", cable.name));
    }
    let contact = scene.contacts.iter().find(|c| c.slides() || c.points().is_none())?;
    Some(format!("the contact {}", contact.name))
}
