//! Scenes and quantities for which one run gives no estimate, with the reason and the remedy.

use crate::scene::error::hint;
use crate::scene::{Scene, SceneError};
use crate::solve::{Integrator, TimeSpan};
use crate::system::Capabilities;

/// Reason why a run has no error estimate.
#[derive(Debug, thiserror::Error)]
pub enum EstimateError {
    #[error(
        "stage {stage} is arc_length, whose states have no time of their own; take a family of meshes, or drive by length or volume"
    )]
    ArcLength { stage: usize },
    #[error(
        "{part} makes the state depend on the path, and the shares of cells are known for single states only; ask for the errors alone"
    )]
    Path { part: String },
    #[error("a rigid part has no counterpart in the enriched space; take a family of meshes")]
    Rigid,
    #[error("{why}, so the answer has no limit as h → 0, and no error")]
    NoLimit { why: String },
    #[error("{why}; a state of that kind has no bar")]
    VolumesLost { why: String },
    #[error(
        "the scene has a mesh, laws, effects or recorders from Rust that are not known for the enriched mesh: {why}"
    )]
    Additions { why: String },
    #[error("{name} is not estimated, only columns with a derivative by the state; {}", hint(name, known))]
    Column { name: String, known: Vec<String> },
    #[error(
        "the estimator has {states} states of a run with {rows} rows; hand each of them to `add`, from the start of the run on"
    )]
    OtherRun { states: usize, rows: usize },
    #[error("the enriched mesh makes a scene that is refused: {0}")]
    Enriched(#[from] SceneError),
    #[error(
        "the open cavity of the scene pushes with a force that has no potential, and shares of cells are not known for it; ask for \
         the errors alone"
    )]
    Follower,
    #[error("no adjoint solution at t = {t} s: {why}; ask for the errors without shares of cells")]
    NoAdjoint { t: f64, why: String },
    #[error(
        "{column} has no derivative at t = {t} s; ask for its error without shares of cells, or for other quantities by name"
    )]
    NoDerivative { column: String, t: f64 },
    #[error("the enriched mesh has no solution at t = {t} s ({status}); take a family of meshes")]
    NotSolved { t: f64, status: &'static str },
    #[error(
        "the enriched mesh has no solution at t = {t} s after {iterations} iterations, of which the run took {of_run}; take a family of meshes, or shorter steps"
    )]
    TooLong { t: f64, iterations: usize, of_run: usize },
    #[error(
        "the enriched equilibrium at t = {t} s is unstable, or was reached by a jump between branches, where that of the run is not: which branch the \
         body takes is not decided, and there is no bar; take shorter steps (`dt`) where loads grow by much in one, an imperfection that decides, or a family of meshes"
    )]
    Unstable { t: f64 },
    #[error("the estimate was stopped; run the scene again to have it")]
    Stopped,
}

/// Refuses a scene that has no discretisation error, or whose states have no counterparts in the enriched space.
pub(super) fn check(scene: &Scene) -> Result<(), EstimateError> {
    let by_arc_length = |span: &TimeSpan| matches!(span.integrator, Integrator::ArcLength { .. });
    if let Some(k) = scene.spans.iter().position(by_arc_length) {
        return Err(EstimateError::ArcLength { stage: k + 1 });
    }
    if !scene.system.ties.is_empty() {
        return Err(EstimateError::Rigid);
    }
    match &scene.no_limit {
        Some(why) => Err(EstimateError::NoLimit { why: why.clone() }),
        None => Ok(()),
    }
}

/// The first part of a scene that makes its states depend on the path and on the time steps, if there is one; without such a part they are functions of the
/// loads at the same time.
pub fn path_dependence(scene: &Scene) -> Option<String> {
    let is_static = |span: &TimeSpan| matches!(span.integrator, Integrator::Static | Integrator::ArcLength { .. });
    if let Some((k, span)) = scene.spans.iter().enumerate().find(|(_, span)| !is_static(span)) {
        return Some(format!("stage {} ({})", k + 1, span.integrator.name()));
    }
    let remembers = |c: Capabilities| c.history.is_some() && c.friction_of.is_none();
    if let Some(effect) = scene.system.effects.iter().find(|e| remembers(e.capabilities())) {
        return Some(format!("the effect {}", effect.name()));
    }
    if let Some(cable) = scene.cables.iter().find(|c| c.friction) {
        return Some(format!("the friction of the {}", cable.name));
    }
    if scene.controls.has_inputs() {
        return Some("a signal that is decided during the run".into());
    }
    scene.contacts.iter().find(|c| c.slides() || c.points().is_none()).map(|c| format!("the contact {}", c.name))
}

/// Refuses a scene whose states depend on the path, or whose tangents are not symmetric.
pub(super) fn check_adjoint(scene: &Scene) -> Result<(), EstimateError> {
    if let Some(part) = path_dependence(scene) {
        return Err(EstimateError::Path { part });
    }
    if scene.system.has_skew_tangent() { Err(EstimateError::Follower) } else { Ok(()) }
}
