//! Derivatives of one scalar with respect to many keys of a scene, by one adjoint solution; the scalar is a weighted sum of recorded columns at the end of a
//! static run.
//!
//! One factorisation and one solution at the last state serve all keys, where [`SensitivityRecorder`](crate::scene::SensitivityRecorder) factorises at every
//! recorded row and solves for every key. Source: see [`crate::solve::adjoints`].
//!
//! Limits: stages without inertia or damping, no effect with memory, no arc length, no open cavity, no rigid part.

use super::error::SensitivityError;
use super::parameter_key::ParameterKey;
use super::{check, parameter};
use crate::scene::build::Scene;
use crate::scene::error_estimate::path_dependence;
use crate::scene::record::recorder::{Energies, Moment};
use crate::solve::{Failure, Integrator, Step, adjoints};
use crate::system::{Gradient, State, Want};
use std::sync::atomic::{AtomicBool, Ordering};

/// Derivatives of a scalar, in its unit per SI unit of the key.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarSensitivity {
    /// Derivatives \[keys\]
    pub values: Vec<f64>,
    /// Estimated errors \[keys\]; zero for exact derivatives
    pub errors: Vec<f64>,
}

/// Refuses a scene whose derivatives do not follow from an adjoint solution at the last state.
///
/// # Errors
///
/// Where a part of the scene rules out an adjoint solution; the error names the part.
pub fn check_scalar(scene: &Scene) -> Result<(), SensitivityError> {
    check(scene)?;
    let refused = |part: String, why| Err(SensitivityError::NotScalar { part, why });
    if let Some(part) = path_dependence(scene) {
        return refused(part, "the last state depends on those before");
    }
    if let Some(k) = scene.spans.iter().position(|s| matches!(s.integrator, Integrator::ArcLength { .. })) {
        return refused(format!("stage {} (arc_length)", k + 1), "the load of the last state depends on the path");
    }
    if scene.system.has_skew_tangent() {
        return refused("the open cavity".into(), "its tangent is not symmetric");
    }
    if !scene.system.ties.is_empty() {
        return refused("a rigid part".into(), "its nodes follow others");
    }
    Ok(())
}

/// Derivatives of Σ w J over the columns of a run with weights w \[columns\], with respect to keys; `last` is the last state and `memory` the memory of the
/// recorders there. `stop`, which is checked between the keys, ends the computation.
///
/// # Errors
///
/// Where a key does not lead to a number, the scene is refused by [`check_scalar`], or `stop` was set.
pub fn scalar_sensitivity(
    scene: &Scene,
    (last, memory): (&State, &[f64]),
    weights: &[f64],
    keys: &[ParameterKey],
    stop: &AtomicBool,
) -> Result<ScalarSensitivity, SensitivityError> {
    check_scalar(scene)?;
    let goes_on = || if stop.load(Ordering::Relaxed) { Err(SensitivityError::Interrupted) } else { Ok(()) };
    let parameters = keys.iter().map(|key| {
        goes_on()?;
        parameter(scene, key, false)
    });
    let parameters: Vec<_> = parameters.collect::<Result<_, _>>()?;
    let functional = functional(scene, last, memory, weights)?;
    let stopped = |why: Failure| SensitivityError::Stopped { t: last.t, why };
    let step = Step { system: &scene.system, integrator: Integrator::Static, past: last, dt: 1.0 };
    let at = step.at(last);
    let adjoint = adjoints(scene.method(), &step, last, std::slice::from_ref(&functional)).map_err(stopped)?.remove(0);
    let mut sums = scene.system.workspace();
    let evaluated = scene.system.assemble(&at, &last.lambda, Want::Residual, None, &mut sums);
    evaluated.map_err(|why| stopped(Failure::Eval(why)))?;
    let energies = Energies::default();
    let now = Moment { body: &scene.body, state: last, step: Some(&at), residual: &sums.r, energies, memory };
    // Weights of the columns that have a derivative, in the order of the scenes of a difference
    let differentiable: Vec<f64> = scene
        .recorders()
        .scan(1, |first, r| {
            let own = *first..*first + r.columns().len();
            *first = own.end;
            Some((r.is_differentiable(), own))
        })
        .filter(|(is_differentiable, _)| *is_differentiable)
        .flat_map(|(_, own)| weights[own].to_vec())
        .collect();
    let mut found = ScalarSensitivity { values: Vec::new(), errors: Vec::new() };
    for (mut parameter, difference) in parameters {
        goes_on()?;
        let own = parameter.change(&scene.system, &at, &last.lambda).map_err(|why| stopped(Failure::Eval(why)))?;
        let mut along = adjoint.along(&functional, &step, last, &own).map_err(stopped)?;
        if let Some(scenes) = &difference {
            for (along, columns) in along.iter_mut().zip(scenes.columns(&now)) {
                let wanted = differentiable.iter().zip(&columns).filter(|(weight, _)| **weight != 0.0);
                *along += wanted.map(|(weight, column)| weight * column).sum::<f64>();
            }
        }
        found.values.push(along[0]);
        found.errors.push(along.get(1).map_or(0.0, |other| (other - along[0]).abs()));
    }
    Ok(found)
}

/// Gradient Σ w ∂J over the columns with a weight.
fn functional(scene: &Scene, last: &State, memory: &[f64], weights: &[f64]) -> Result<Gradient, SensitivityError> {
    let columns = scene.columns();
    let of = |(r, memory): (&dyn crate::scene::Recorder, &[f64])| {
        let mut own = r.gradients(&scene.body, last, memory);
        own.resize(r.columns().len(), None);
        own
    };
    // The time and the number of iterations, the first and the last column, have no derivative
    let all = std::iter::once(None).chain(scene.with_memories(memory).flat_map(of)).chain([None]);
    let mut sum = Gradient::default();
    for (c, (gradient, &weight)) in all.zip(weights).enumerate().filter(|(_, (_, weight))| **weight != 0.0) {
        let none = || SensitivityError::Column { column: columns[c].clone(), t: last.t };
        let gradient = gradient.ok_or_else(none)?;
        sum.x.extend(gradient.x.into_iter().map(|(dof, value)| (dof, weight * value)));
        sum.lambda.extend(gradient.lambda.into_iter().map(|(c, value)| (c, weight * value)));
        sum.reaction.extend(gradient.reaction.into_iter().map(|(dof, value)| (dof, weight * value)));
    }
    Ok(sum)
}
