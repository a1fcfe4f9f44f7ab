//! Reasons why a scene has no derivatives.

use super::parameter_key::{KeyError, ParameterKey};
use crate::material::LawSpecError;
use crate::scene::error::SceneError;
use crate::scene::text::overrides::OverrideError;
use crate::solve::Failure;

/// Reason why a scene has no derivatives with respect to a key.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    #[error(transparent)]
    Key(#[from] KeyError),
    #[error(transparent)]
    Path(#[from] OverrideError),
    #[error("{key} takes whole numbers or names only, so there is no derivative by it: {source}")]
    Discrete { key: ParameterKey, source: Box<SceneError> },
    #[error(
        "{key}: the mesher would make another mesh for another value, so there is no derivative by it; declare the change of shape \
         in [mesh.deform] and take a parameter of it, or take a grid"
    )]
    Mesher { key: ParameterKey },
    #[error("{key}: there is no derivative by it, because a small change of it changes more than values: {source}")]
    Differs { key: ParameterKey, source: Box<SceneError> },
    #[error(
        "{key}: there is no derivative by it, because the scene with a slightly different value is refused: {source}; take a value with some room on both sides"
    )]
    AtBound { key: ParameterKey, source: Box<SceneError> },
    #[error(
        "{key}: it is a setting of the solver, which changes errors and no equations, so there is no derivative by it; take a key of another table"
    )]
    Setting { key: ParameterKey },
    #[error(
        "{key}: the scene was made in Rust and has no text in which the key could be changed; make it with SceneBuilder::parse"
    )]
    NoText { key: ParameterKey },
    #[error("{constant}: the scene has no such law; {hint}")]
    NoLaw { constant: String, hint: String },
    #[error("{constant}: {source}")]
    Law { constant: String, source: LawSpecError },
    #[error("{constant}: no elastic effect takes this law; name the law of an [[effect]] of kind \"elastic\"")]
    Unused { constant: String },
    #[error(
        "stage {stage} is {integrator}, whose states are not converged and have no derivative; take implicit_euler"
    )]
    NotConverged { stage: usize, integrator: &'static str },
    #[error(
        "the signals are decided during the run, and their derivatives are not followed; remove events and formulas of columns"
    )]
    Decided,
    #[error("the effect {effect} reads what came before a step and has no derivative by it; remove it")]
    Past { effect: String },
    #[error(
        "the body begins away from rest with a memory of its softening, whose derivative is not followed; begin at rest, or remove the effect mullins"
    )]
    Begun,
    #[error(
        "the {cable} has friction: its tensions depend on the path of loading, which the derivatives do not follow; remove its `friction`"
    )]
    Friction { cable: String },
    #[error(
        "the contact {contact} has friction: its forces depend on the path, which the derivatives do not follow; set its `friction` to 0"
    )]
    Sliding { contact: String },
    #[error("{part} has no adjoint derivatives: {why}; take those of the rows, by SensitivityRecorder")]
    NotScalar { part: String, why: &'static str },
    #[error("the column {column} has no derivative at t = {t} s; take another one")]
    Column { column: String, t: f64 },
    #[error("the derivatives were stopped; run them again")]
    Interrupted,
    #[error("there is no derivative at t = {t} s: {why}; end the run before, or take another stage")]
    Stopped { t: f64, why: Failure },
    #[error(
        "in the contact {contact} deformable surfaces meet, which the derivatives do not follow; take a rigid obstacle, or no derivatives"
    )]
    Surfaces { contact: String },
}
