//! Exact derivatives of recorded columns by the constants of the laws, in static stages.
//!
//! ∂r/∂θ comes from the derivative of the law ([`crate::material::derivative`]) on the cells of its elastic effects, ∂x/∂θ and
//! ∂λ/∂θ from [`crate::solve::Differentiator`]; here they go through the probes by their linearisation. An angle between
//! a fixed a and b(x): dϑ = [(a·b) d|a × b| − |a × b| a·db]/(|a|²|b|²), d|a × b| = (a × b)·(a × db)/|a × b|.
//!
//! Limits: static stages without history; not the columns of the probes `energy` and `stretch`.

use super::build::Scene;
use super::error::hint;
use super::probe::{Probe, area_vector, cavity_columns};
use super::spec::EffectSpec;
use crate::material::{self, LawSpecError};
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::solve::{Change, Differentiator, Failure};
use crate::system::{Effect, State};
use std::fmt;
use std::str::FromStr;

/// A constant of a law, as it stands in the scene file: `laws.rubber.mu`.
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

/// What exact derivatives do not cover.
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
    #[error("stage {stage} is {integrator}: derivatives are exact in static stages only; make it static")]
    NotStatic { stage: usize, integrator: &'static str },
    #[error("the effect {effect} remembers its past, which the derivatives do not follow; remove it")]
    History { effect: String },
    #[error(
        "the {cable} has friction: its tensions depend on the path of loading, which the derivatives do not follow; remove its `friction`"
    )]
    Friction { cable: String },
}

/// What differentiates the states of a scene.
pub struct Sensitivity<'a> {
    scene: &'a Scene,
    /// Per constant: the effects that make up ∂r/∂θ
    by: Vec<Vec<Box<dyn Effect>>>,
    solver: Differentiator<'a>,
}

impl<'a> Sensitivity<'a> {
    pub fn new(scene: &'a Scene, constants: &[Constant]) -> Result<Self, SensitivityError> {
        if let Some(k) = scene.spans.iter().position(|s| !s.integrator.is_static()) {
            let integrator = scene.spans[k].integrator.name();
            return Err(SensitivityError::NotStatic { stage: k + 1, integrator });
        }
        if let Some(effect) = scene.system.effects.iter().find(|e| e.history() > 0) {
            return Err(SensitivityError::History { effect: effect.name().into() });
        }
        if let Some(cable) = scene.cables.iter().find(|c| c.friction) {
            return Err(SensitivityError::Friction { cable: cable.name.clone() });
        }
        let by = constants.iter().map(|c| derivatives(scene, c)).collect::<Result<_, _>>()?;
        Ok(Self { scene, by, solver: Differentiator::new(&scene.system) })
    }

    /// Recorded columns that have a derivative, in their order.
    pub fn columns(&self) -> Vec<String> {
        let probes = self.scene.probes.iter().filter(|p| !matches!(p, Probe::Energy | Probe::Stretch));
        let cables = self.scene.cables.iter().flat_map(|c| c.columns());
        let cavities = self.scene.cavities.iter().flat_map(cavity_columns);
        probes.flat_map(Probe::columns).chain(cables).chain(cavities).collect()
    }

    /// Derivatives at a converged state, [columns × constants], in the unit of the column per SI unit of the constant.
    pub fn at(&mut self, state: &State) -> Result<Vec<Vec<f64>>, Failure> {
        // ∂P/∂θ = 0 at F = I: at rest nothing changes, and the body need not be held by what comes later.
        if state.x.iter().all(|x| *x == 0.0) {
            return Ok(vec![vec![0.0; self.by.len()]; self.columns().len()]);
        }
        let all = self.solver.at(state, &self.by)?;
        let all: Vec<Vec<f64>> = all.iter().map(|change| changes(self.scene, state, change)).collect();
        Ok((0..self.columns().len()).map(|k| all.iter().map(|values| values[k]).collect()).collect())
    }
}

/// The derivative by a constant of every elastic effect that takes its law.
fn derivatives(scene: &Scene, constant: &Constant) -> Result<Vec<Box<dyn Effect>>, SensitivityError> {
    let laws = &scene.spec.laws;
    let name = constant.to_string();
    let table = laws.get(&constant.law).ok_or_else(|| {
        let known: Vec<&String> = laws.keys().collect();
        SensitivityError::NoLaw { constant: name.clone(), hint: hint(&constant.law, &known) }
    })?;
    let elastic = scene.spec.effects.iter().filter_map(|e| match e {
        EffectSpec::Elastic { law, .. } => Some(law),
        _ => None,
    });
    let mut found = Vec::new();
    for (effect, _) in scene.stressed.iter().zip(elastic).filter(|(_, law)| **law == constant.law) {
        let along = material::derivative(table, &constant.key)
            .map_err(|source| SensitivityError::Law { constant: name.clone(), source })?;
        found.push(effect.along(&scene.body.mesh, along));
    }
    if found.is_empty() { Err(SensitivityError::Unused { constant: name }) } else { Ok(found) }
}

/// Change of each of [`Sensitivity::columns`].
fn changes(scene: &Scene, state: &State, change: &Change) -> Vec<f64> {
    let probes = scene.probes.iter().filter_map(|probe| through(probe, &scene.body.mesh, &state.x, change));
    let mut out: Vec<f64> = probes.flatten().collect();
    scene.cables.iter().for_each(|cable| out.extend(cable.changes(state, change)));
    for cavity in &scene.cavities {
        out.extend([cavity.drive.answer(change), cavity.cavity.growth(&state.x, &change.x)]);
    }
    out
}

/// Change of what a probe records; None where it has no derivative here.
fn through(probe: &Probe, mesh: &TetMesh, x: &[f64], change: &Change) -> Option<Vec<f64>> {
    match probe {
        Probe::BendingAngle { root, tip, facets } => {
            let chord =
                turned(tip.origin - root.origin, tip.at(x) - root.at(x), tip.moved(&change.x) - root.moved(&change.x));
            if facets.is_empty() {
                return Some(vec![chord]);
            }
            let rest = area_vector(mesh, facets, &vec![0.0; x.len()]);
            Some(vec![turned(rest, area_vector(mesh, facets, x), area_turned(mesh, facets, x, &change.x)), chord])
        }
        Probe::Position { mean, .. } => Some(mean.moved(&change.x).as_slice().to_vec()),
        Probe::Reaction { nodes, .. } => {
            let sum = |i: usize| nodes.iter().map(|&k| change.reaction[3 * k as usize + i]).sum();
            Some((0..3).map(sum).collect())
        }
        Probe::Energy | Probe::Stretch => None,
    }
}

/// Change of the angle between a and b [deg] with db.
fn turned(a: Vec3, b: Vec3, db: Vec3) -> f64 {
    let cross = a.cross(&b);
    let (sine, along) = (cross.norm(), a.cross(&db));
    // Where a and b are parallel the angle grows whatever the direction.
    let rate = if sine > 0.0 { cross.dot(&along) / sine } else { along.norm() };
    ((a.dot(&b) * rate - sine * a.dot(&db)) / (a.norm_squared() * b.norm_squared())).to_degrees()
}

/// Change of ∫ n dA [m²] with the motion dx: the cross product of the tangents is linear in each.
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
