//! Exact derivatives of recorded columns by the constants of the laws.
//!
//! ∂r/∂θ comes from the derivative of the law ([`crate::material::derivative`]) in every effect that takes it: elastic, viscoelastic,
//! stiffness damping. The derivatives of the states come from [`crate::solve::Differentiator`]; here they go through the probes by
//! their linearisation. An angle between a fixed a and b(x): dϑ = \[(a·b) d|a × b| − |a × b| a·db\]/(|a|²|b|²),
//! d|a × b| = (a × b)·(a × db)/|a × b|.
//!
//! Limits: not the columns of the probes `energy` and `stretch`; what else is not covered is a [`SensitivityError`].

use super::build::Scene;
use super::error::hint;
use super::probe::{Probe, area_vector, cavity_columns};
use super::spec::EffectSpec;
use crate::effect::StiffnessDamping;
use crate::material::{self, LawSpecError};
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::solve::{AcceptedStep, Differentiator, Failure, Step};
use crate::system::{Capabilities, Effect, Needs, ParameterDerivative, State};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// A constant of a law by its name in the scene file: `laws.rubber.mu`.
#[derive(Clone, Debug, PartialEq, Eq)]
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
        "the signals are decided on the way, and their derivatives are not followed; remove events and formulas of columns"
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
        let probes = self.scene.probes.iter().filter(|p| !matches!(p, Probe::Energy | Probe::Stretch));
        let cables = self.scene.cables.iter().flat_map(|c| c.columns());
        let cavities = self.scene.cavities.iter().flat_map(cavity_columns);
        probes.flat_map(Probe::columns).chain(cables).chain(cavities).collect()
    }

    /// Derivatives at the end of a step, where it is recorded: \[columns × constants\], in the unit of the column per SI
    /// unit of the constant.
    pub(super) fn step(&mut self, step: &AcceptedStep, recorded: bool) -> Result<Option<Vec<Vec<f64>>>, Failure> {
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
        let all = self.solver.changes.iter().zip(&reactions);
        let all: Vec<Vec<f64>> = all.map(|(change, reaction)| changes(self.scene, now, change, reaction)).collect();
        Ok(Some((0..self.columns().len()).map(|k| all.iter().map(|values| values[k]).collect()).collect()))
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
    let mut found = Vec::new();
    // For stiffness damping: region, and ∂/∂θ of the elastic effect there
    let mut elastic: Vec<(&str, Arc<dyn Effect>)> = Vec::new();
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        match spec {
            EffectSpec::Elastic { region, law, .. } => {
                let effect = stressed.next().expect("one for each elastic effect");
                if *law == constant.law {
                    let shared: Arc<dyn Effect> = effect.along(mesh, along()?).into();
                    elastic.push((region, shared.clone()));
                    found.push(ParameterDerivative { of, effect: Box::new(shared) });
                }
            }
            EffectSpec::Viscoelastic { law, .. } => {
                let effect = relaxing.next().expect("one for each viscoelastic effect");
                if *law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(&*along()?) });
                }
            }
            _ => {}
        }
    }
    if found.is_empty() {
        return Err(SensitivityError::Unused { constant: name });
    }
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        let EffectSpec::StiffnessDamping { region, beta, stiffness } = spec else { continue };
        let damped = elastic.iter().filter(|(of, _)| of == region).map(|(_, effect)| effect.clone()).collect();
        let damping = StiffnessDamping::new(damped, beta.0, (*stiffness).into(), &mesh.points);
        found.push(ParameterDerivative { of, effect: Box::new(damping.expect("built once already")) });
    }
    Ok(found)
}

/// Change of each of [`Sensitivity::columns`] with that of the state and of the reactions.
fn changes(scene: &Scene, state: &State, change: &State, reaction: &[f64]) -> Vec<f64> {
    let through = |probe| through(probe, &scene.body.mesh, &state.x, &change.x, reaction);
    let probes = scene.probes.iter().filter_map(through);
    let mut out: Vec<f64> = probes.flatten().collect();
    scene.cables.iter().for_each(|cable| out.extend(cable.changes(state, change)));
    for cavity in &scene.cavities {
        out.extend([cavity.drive.answer(change), cavity.cavity.growth(&state.x, &change.x)]);
    }
    out
}

/// Change of the values that a probe records; none where they have no derivative here.
fn through(probe: &Probe, mesh: &TetMesh, x: &[f64], dx: &[f64], reaction: &[f64]) -> Option<Vec<f64>> {
    match probe {
        Probe::BendingAngle { root, tip, facets } => {
            let chord = turned(tip.origin - root.origin, tip.at(x) - root.at(x), tip.moved(dx) - root.moved(dx));
            if facets.is_empty() {
                return Some(vec![chord]);
            }
            let rest = area_vector(mesh, facets, &vec![0.0; x.len()]);
            Some(vec![turned(rest, area_vector(mesh, facets, x), area_turned(mesh, facets, x, dx)), chord])
        }
        Probe::Position { mean, .. } => Some(mean.moved(dx).as_slice().to_vec()),
        Probe::Markers { points, .. } => Some(points.iter().flat_map(|p| p.moved(dx).data.0[0]).collect()),
        Probe::Reaction { nodes, .. } => {
            let sum = |i: usize| nodes.iter().map(|&k| reaction[3 * k as usize + i]).sum();
            Some((0..3).map(sum).collect())
        }
        Probe::Energy | Probe::Stretch => None,
    }
}

/// Change of the angle between a and b \[deg\] with db.
fn turned(a: Vec3, b: Vec3, db: Vec3) -> f64 {
    let cross = a.cross(&b);
    let (sine, along) = (cross.norm(), a.cross(&db));
    // Where a and b are parallel the angle grows whatever the direction.
    let rate = if sine > 0.0 { cross.dot(&along) / sine } else { along.norm() };
    ((a.dot(&b) * rate - sine * a.dot(&db)) / (a.norm_squared() * b.norm_squared())).to_degrees()
}

/// Change of ∫ n dA \[m²\] with the motion dx: the cross product of the tangents is linear in each.
fn area_turned(mesh: &TetMesh, facets: &[u32], x: &[f64], dx: &[f64]) -> Vec3 {
    let rule = quadrature::tri(2);
    let mut sum = Vec3::zeros();
    for &f in facets {
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = element::facet_gradients(mesh.order, xi);
            let [mut a, mut b, mut da, mut db] = [Vec3::zeros(); 4];
            for (&k, g) in mesh.facet(f as usize).iter().zip(gradients) {
                let at = |v: &[f64]| Vec3::from_column_slice(&v[3 * k as usize..][..3]);
                let (p, dp) = (mesh.points[k as usize] + at(x), at(dx));
                a += p * g[0];
                b += p * g[1];
                da += dp * g[0];
                db += dp * g[1];
            }
            sum += (da.cross(&b) + a.cross(&db)) * *w;
        }
    }
    sum
}
