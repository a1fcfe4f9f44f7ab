//! Exact derivatives of recorded columns by the constants of the laws.
//!
//! ∂r/∂θ comes from the derivative of the law ([`crate::material::derivative`]) in every effect that takes it: elastic, membrane,
//! viscoelastic, mullins, stiffness damping. The derivatives of the states come from [`crate::solve::Differentiator`]; here they go through the
//! recorders ([`super::Recorder::gradients`]).
//!
//! Limits: only the columns of recorders with a derivative, so not those of the probes `energy` and `stretch`; what else is not covered is a [`SensitivityError`].

use super::build::Scene;
use super::error::hint;
use super::spec::EffectSpec;
use crate::effect::StiffnessDamping;
use crate::material::{self, LawSpecError};
use crate::solve::{AcceptedStep, Differentiator, Failure, Step};
use crate::system::{Capabilities, Effect, Gradient, Needs, ParameterDerivative};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// A constant of a law by its name in the scene file: `laws.rubber.mu`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Constant {
    /// Name of the table below `laws`
    pub law: String,
    pub key: String,
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "laws.{}.{}", self.law, self.key)
    }
}

impl FromStr for Constant {
    type Err = SensitivityError;

    fn from_str(text: &str) -> Result<Self, SensitivityError> {
        let parts = text.strip_prefix("laws.").and_then(|rest| rest.split_once('.'));
        let (law, key) = parts.ok_or_else(|| SensitivityError::Form { text: text.into() })?;
        Ok(Self { law: law.into(), key: key.into() })
    }
}

/// Reason why a scene has no exact derivatives.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    #[error("\"{text}\" names no constant; write for example laws.rubber.mu")]
    Form { text: String },
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
        "the {cable} has friction: its tensions depend on the path of loading, which the derivatives do not follow; remove its `friction`"
    )]
    Friction { cable: String },
    #[error(
        "the contact {contact} has friction: its forces depend on the path, which the derivatives do not follow; set its `friction` to 0"
    )]
    Sliding { contact: String },
    #[error(
        "in the contact {contact} deformable surfaces meet, which the derivatives do not follow; take a rigid obstacle, or no derivatives"
    )]
    Surfaces { contact: String },
}

/// Differentiates the states of a scene.
pub(super) struct Sensitivity<'a> {
    scene: &'a Scene,
    pub(super) solver: Differentiator<'a>,
}

impl<'a> Sensitivity<'a> {
    pub(super) fn new(scene: &'a Scene, constants: &[Constant]) -> Result<Self, SensitivityError> {
        if scene.controls.has_inputs() {
            return Err(SensitivityError::Decided);
        }
        if let Some(k) = scene.spans.iter().position(|s| s.integrator.is_linearised()) {
            let integrator = scene.spans[k].integrator.name();
            return Err(SensitivityError::NotConverged { stage: k + 1, integrator });
        }
        let system = &scene.system;
        let unknown = |c: Capabilities| (c.history.is_some() || c.needs != Needs::default()) && c.past.is_none();
        if let Some(effect) = system.effects.iter().find(|e| unknown(e.capabilities())) {
            return Err(SensitivityError::Past { effect: effect.name().into() });
        }
        if let Some(contact) = scene.contacts.iter().find(|c| c.slides()) {
            return Err(SensitivityError::Sliding { contact: contact.name.clone() });
        }
        if let Some(contact) = scene.contacts.iter().find(|c| c.points().is_none()) {
            return Err(SensitivityError::Surfaces { contact: contact.name.clone() });
        }
        if let Some(cable) = scene.cables.iter().find(|c| c.friction) {
            return Err(SensitivityError::Friction { cable: cable.name.clone() });
        }
        let by = constants.iter().map(|c| terms(scene, c)).collect::<Result<_, _>>()?;
        Ok(Self { scene, solver: Differentiator::new(scene.method(), system, by) })
    }

    /// Recorded columns that have a derivative, in their order.
    pub(super) fn columns(&self) -> Vec<String> {
        self.scene.recorders().filter(|r| r.is_differentiable()).flat_map(|r| r.columns()).collect()
    }

    /// Derivatives at the end of a step, where it is recorded: \[columns × constants\], in the unit of the column per SI
    /// unit of the constant; NaN of a column that has none there.
    pub(super) fn step(
        &mut self,
        step: &AcceptedStep,
        memory: &[f64],
        recorded: bool,
    ) -> Result<Option<Vec<Vec<f64>>>, Failure> {
        let AcceptedStep { integrator, past, now, .. } = *step;
        if !recorded && integrator.is_static() && now.history.is_empty() {
            return Ok(None);
        }
        let step = Step { system: &self.scene.system, integrator, past, dt: now.t - past.t };
        self.solver.step(&step, now)?;
        if !recorded {
            return Ok(None);
        }
        let reactions = self.solver.reactions(&step, now)?;
        let recorders = self.scene.with_memories(memory);
        let gradients = recorders.flat_map(|(r, memory)| r.gradients(&self.scene.body, now, memory));
        let derivatives = |gradient: Option<Gradient>| {
            let all = self.solver.changes.iter().zip(&reactions);
            all.map(|(change, reaction)| gradient.as_ref().map_or(f64::NAN, |g| g.along(change, reaction))).collect()
        };
        Ok(Some(gradients.map(derivatives).collect()))
    }
}

/// ∂/∂θ of every effect that takes the law of a constant.
fn terms(scene: &Scene, constant: &Constant) -> Result<Vec<ParameterDerivative>, SensitivityError> {
    let (laws, mesh) = (&scene.spec.laws, &scene.body.mesh);
    let name = constant.to_string();
    let table = laws.get(&constant.law).ok_or_else(|| {
        let known: Vec<&String> = laws.keys().collect();
        SensitivityError::NoLaw { constant: name.clone(), hint: hint(&constant.law, &known) }
    })?;
    let along = || {
        let along = material::derivative(table, &constant.key);
        along.map_err(|source| SensitivityError::Law { constant: name.clone(), source })
    };
    let (mut stressed, mut relaxing) = (scene.stressed.iter(), scene.relaxing.iter());
    let (mut membranes, mut softening) = (scene.membranes.iter(), scene.softening.iter());
    let mut found = Vec::new();
    // For stiffness damping: region, and ∂/∂θ of the elastic effect there
    let mut elastic: Vec<(&str, Arc<dyn Effect>)> = Vec::new();
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        match spec {
            EffectSpec::Elastic(solid) => {
                let effect = stressed.next().expect("one for each elastic effect");
                if solid.law == constant.law {
                    let shared: Arc<dyn Effect> = effect.along(mesh, along()?).into();
                    elastic.push((&solid.region, shared.clone()));
                    found.push(ParameterDerivative { of, effect: Box::new(shared) });
                }
            }
            EffectSpec::Viscoelastic(viscoelastic) => {
                let effect = relaxing.next().expect("one for each viscoelastic effect");
                if viscoelastic.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(&*along()?) });
                }
            }
            EffectSpec::Mullins(mullins) => {
                let effect = softening.next().expect("one for each softening effect");
                if mullins.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(&*along()?) });
                }
            }
            EffectSpec::Membrane(sheet) => {
                let effect = membranes.next().expect("one for each membrane");
                if sheet.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(along()?) });
                }
            }
            _ => {}
        }
    }
    if found.is_empty() {
        return Err(SensitivityError::Unused { constant: name });
    }
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        let EffectSpec::StiffnessDamping(spec) = spec else { continue };
        let damped = elastic.iter().filter(|(of, _)| *of == spec.region).map(|(_, effect)| effect.clone()).collect();
        let damping = StiffnessDamping::new(damped, spec.beta.0, spec.stiffness.into(), &mesh.points);
        found.push(ParameterDerivative { of, effect: Box::new(damping.expect("built once already")) });
    }
    let tied =
        |ParameterDerivative { of, effect }| ParameterDerivative { of, effect: scene.system.ties.effect(effect) };
    Ok(found.into_iter().map(tied).collect())
}
