//! Derivatives of recorded columns with respect to keys of the scene.
//!
//! They are exact for constants of laws (`law_terms`). For every other key whose value is a number they are differences of scenes with other values of it
//! (`difference`), as are the parts of contacts and rigid bodies whose stiffness depends on a law. The derivatives of the states come from
//! [`crate::solve::Differentiator`]; this module passes them through the recorders ([`super::Recorder::gradients`]).
//!
//! Limits: only columns of differentiable recorders have derivatives ([`columns::Sensitivities::columns`]); any other unsupported case is a
//! [`SensitivityError`].

pub(super) mod columns;
pub(super) mod difference;
pub(super) mod error;
pub(super) mod law_terms;
pub(super) mod parameter_key;
pub(super) mod scalar;

use super::build::Scene;
use super::record::recorder::{Energies, Moment};
use crate::solve::{Differentiator, Failure, Integrator, Step};
use crate::system::{Capabilities, Gradient, Needs, State, SystemParameter};
use difference::{Followed, SceneDifference};
use error::SensitivityError;
use law_terms::{is_exact, law_terms, others_follow_laws};
use parameter_key::ParameterKey;

/// Differentiates the states of a scene.
pub(super) struct Sensitivity<'a> {
    scene: &'a Scene,
    pub(super) solver: Differentiator<'a>,
    /// For each key, the scenes for its differences; `None` if the derivative is exact
    differences: Vec<Option<SceneDifference<'a>>>,
}

/// The end of a step.
pub(super) struct StepEnd<'a> {
    pub integrator: Integrator,
    pub past: &'a State,
    pub now: &'a State,
    /// Residual at `now` \[unknowns\]
    pub residual: &'a [f64],
    /// Memory of the recorders at `now`
    pub memory: &'a [f64],
}

/// Derivatives of the columns at one row, estimates of their errors, and the magnitudes of their terms, all \[columns × keys\].
pub(super) struct RowDerivatives {
    pub values: Vec<Vec<f64>>,
    pub errors: Vec<Vec<f64>>,
    pub terms: Vec<Vec<f64>>,
}

impl<'a> Sensitivity<'a> {
    /// Differentiates with respect to these keys; with `by_differences` by differences even if an exact derivative is known.
    pub(super) fn new(scene: &'a Scene, keys: &[ParameterKey], by_differences: bool) -> Result<Self, SensitivityError> {
        check(scene)?;
        let Parameters { parameters, differences } = parameters(scene, keys, by_differences)?;
        let start = |scenes: &Option<SceneDifference>| match scenes {
            None => vec![scene.system.rest()],
            Some(scenes) => scenes.start.to_vec(),
        };
        let start = differences.iter().flat_map(start).collect();
        let mut solver = Differentiator::new(scene.method(), &scene.system, parameters, start);
        // Without pressures and memory if a law is not defined there, which stops the first step
        let start = scene.start();
        _ = solver.set_second_field(&start);
        if has_begun(&start) {
            _ = solver.set_history(&start);
        }
        Ok(Self { scene, solver, differences })
    }

    /// Recorded columns that have a derivative, in their order.
    pub(super) fn columns(&self) -> Vec<String> {
        self.scene.recorders().filter(|r| r.is_differentiable()).flat_map(|r| r.columns()).collect()
    }

    /// Magnitudes of the values of the keys \[SI\]; 0 if the derivative is exact.
    pub(super) fn key_sizes(&self) -> Vec<f64> {
        self.differences.iter().map(|scenes| scenes.as_ref().map_or(0.0, SceneDifference::size)).collect()
    }

    /// Derivatives at the first state.
    pub(super) fn start(&self) -> RowDerivatives {
        let (scene, state) = (self.scene, self.scene.start());
        let mut memory = scene.memory();
        scene.remember(&state, &mut memory);
        let none = vec![0.0; state.x.len()];
        let (body, energies) = (&scene.body, Energies::default());
        let moment = Moment { body, state: &state, step: None, residual: &none, energies, memory: &memory };
        self.row(&moment, &vec![none.clone(); self.solver.changes.len()])
    }

    /// Whether a step needs the derivatives at the end of the previous step.
    pub(super) fn needs_past(integrator: Integrator, state: &State) -> bool {
        !integrator.is_static() || !state.history.is_empty()
    }

    /// Derivatives at the end of a step, if it is recorded, in the unit of the column per SI unit of the key; NaN for a column that has none there.
    pub(super) fn step(&mut self, end: &StepEnd, recorded: bool) -> Result<Option<RowDerivatives>, Failure> {
        let StepEnd { integrator, past, now, residual, memory } = *end;
        if !recorded && !Self::needs_past(integrator, now) {
            return Ok(None);
        }
        let step = Step { system: &self.scene.system, integrator, past, dt: now.t - past.t };
        self.solver.step(&step, now)?;
        if !recorded {
            return Ok(None);
        }
        let reactions = self.solver.reactions(&step, now)?;
        let (body, energies, at) = (&self.scene.body, Energies::default(), step.at(now));
        let moment = Moment { body, state: now, step: Some(&at), residual, energies, memory };
        Ok(Some(self.row(&moment, &reactions)))
    }

    fn row(&self, now: &Moment, reactions: &[Vec<f64>]) -> RowDerivatives {
        let recorders = self.scene.with_memories(now.memory).filter(|(r, _)| r.is_differentiable());
        let gradients: Vec<Option<Gradient>> =
            recorders.flat_map(|(r, memory)| r.gradients(now.body, now.state, memory)).collect();
        let none = vec![vec![]; gradients.len()];
        let mut row = RowDerivatives { values: none.clone(), errors: none.clone(), terms: none };
        let mut all = self.solver.changes.iter().zip(reactions);
        for difference in &self.differences {
            let own: Vec<(&State, &Vec<f64>)> = all.by_ref().take(if difference.is_some() { 2 } else { 1 }).collect();
            let explicit = difference.as_ref().map(|scenes| scenes.columns(now));
            for (c, gradient) in gradients.iter().enumerate() {
                let terms = |k: usize| {
                    let (change, reaction) = own[k];
                    let of_state = gradient.as_ref().map(|g| g.terms(change, reaction));
                    of_state.map(|terms| terms.chain([explicit.as_ref().map_or(0.0, |columns| columns[k][c])]))
                };
                let value = |k: usize| terms(k).map_or(f64::NAN, Iterator::sum);
                row.values[c].push(value(0));
                row.errors[c].push(if explicit.is_some() { (value(1) - value(0)).abs() } else { 0.0 });
                row.terms[c].push(terms(0).map_or(f64::NAN, |terms| terms.map(f64::abs).sum()));
            }
        }
        row
    }
}

/// Parameters of a system, one for each key.
pub(super) struct Parameters<'a> {
    pub parameters: Vec<SystemParameter<'a>>,
    /// For each key, the scenes for its differences; `None` if the derivative is exact
    pub differences: Vec<Option<SceneDifference<'a>>>,
}

/// The parameters for these keys; with `by_differences` by differences even if an exact derivative is known.
pub(super) fn parameters<'a>(
    scene: &'a Scene,
    keys: &[ParameterKey],
    by_differences: bool,
) -> Result<Parameters<'a>, SensitivityError> {
    let all = keys.iter().map(|key| parameter(scene, key, by_differences));
    let (parameters, differences) = all.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    Ok(Parameters { parameters, differences })
}

/// The parameter for one key, with its scenes if a part of it uses differences.
pub(super) fn parameter<'a>(
    scene: &'a Scene,
    key: &ParameterKey,
    by_differences: bool,
) -> Result<(SystemParameter<'a>, Option<SceneDifference<'a>>), SensitivityError> {
    let exact = key.law_constant().filter(|constant| !by_differences && is_exact(scene, constant));
    let followed = match &exact {
        None => Some(Followed::All),
        Some(_) => others_follow_laws(scene).then_some(Followed::FollowingLaws),
    };
    let terms = exact.map_or(Ok(Vec::new()), |constant| law_terms(scene, &constant))?;
    let difference = followed.map(|followed| SceneDifference::new(scene, key, followed)).transpose()?;
    let parameter = match &difference {
        None => SystemParameter::exact(terms),
        Some(scenes) => SystemParameter::with_difference(terms, scenes.system()),
    };
    Ok((parameter, difference))
}

/// Whether an effect starts with a memory, away from rest.
fn has_begun(start: &State) -> bool {
    start.history.iter().any(|value| *value != 0.0)
}

/// Refuses scenes whose states cannot be differentiated, whatever the key.
pub(super) fn check(scene: &Scene) -> Result<(), SensitivityError> {
    if scene.controls.has_inputs() {
        return Err(SensitivityError::Decided);
    }
    if let Some(k) = scene.spans.iter().position(|s| s.integrator.is_linearised()) {
        let integrator = scene.spans[k].integrator.name();
        return Err(SensitivityError::NotConverged { stage: k + 1, integrator });
    }
    if let Some(contact) = scene.contacts.iter().find(|c| c.slides()) {
        return Err(SensitivityError::Sliding { contact: contact.name.clone() });
    }
    let unknown = |c: Capabilities| (c.history.is_some() || c.needs != Needs::default()) && c.past.is_none();
    if let Some(effect) = scene.system.effects.iter().find(|e| unknown(e.capabilities())) {
        return Err(SensitivityError::Past { effect: effect.name().into() });
    }
    if let Some(contact) = scene.contacts.iter().find(|c| c.points().is_none()) {
        return Err(SensitivityError::Surfaces { contact: contact.name.clone() });
    }
    let start = scene.start();
    let is_at_kink = || scene.system.history_on_its_side(&start.at()).is_ok_and(|smooth| smooth != start.history);
    if has_begun(&start) && is_at_kink() {
        return Err(SensitivityError::Begun);
    }
    match scene.cables.iter().find(|c| c.friction) {
        Some(cable) => Err(SensitivityError::Friction { cable: cable.name.clone() }),
        None => Ok(()),
    }
}
