//! The stages of a scene, and what each of them allows.

use super::builder::Builder;
use super::error::SceneError;
use super::numerics::NumericsSpec;
use super::parts::cable::CableSpec;
use super::quantity::GuideRadius;
use super::spec::{ConstraintSpec, EffectSpec, IntegratorSpec, SceneSpec, StageSpec};
use crate::solve::{Integrator, TimeSpan};

/// More steps than this in one stage are a slip of a unit.
const MOST_STEPS: f64 = 1e7;
/// Steps that an arc-length stage may take if nothing else is said, or ten times the nominal ones if that is more.
const MOST_ARCS: usize = 200;

pub(super) fn build_spans(builder: &Builder, stages: &[StageSpec]) -> Result<Vec<TimeSpan>, SceneError> {
    let mut start = 0.0;
    let mut spans = Vec::new();
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("stage {}", k + 1);
        if stage.dt.0 <= 0.0 || stage.duration.0 <= 0.0 {
            let fact = format!("dt = {} s, duration = {} s", stage.dt.0, stage.duration.0);
            return Err(builder.content(&place, fact, "both must be positive"));
        }
        if stage.duration.0 / stage.dt.0 > MOST_STEPS {
            let fact = format!("{:.1e} steps of {:e} s", stage.duration.0 / stage.dt.0, stage.dt.0);
            return Err(builder.content(&place, fact, "take a larger dt or a shorter duration (check their units)"));
        }
        if stage.max_steps.is_some() && stage.continuation.is_none() {
            let fact = "max_steps without continuation";
            return Err(builder.content(&place, fact, "add continuation = \"arc_length\", or remove it"));
        }
        if stage.integration_steps.is_some() && stage.integrator != IntegratorSpec::ImplicitEulerCorrected {
            let fact = "integration_steps without a loop that looks for contact between its steps";
            let remedy = "remove it, or take integrator = \"implicit_euler_corrected\"";
            return Err(builder.content(&place, fact, remedy));
        }
        if stage.integration_steps == Some(0) {
            return Err(builder.content(&place, "integration_steps = 0", "take 1 or more"));
        }
        let integrator = match stage.integrator {
            IntegratorSpec::Static if stage.continuation.is_some() => {
                let nominal = (stage.duration.0 / stage.dt.0).ceil() as usize;
                Integrator::ArcLength { max_steps: stage.max_steps.unwrap_or(MOST_ARCS.max(10 * nominal)) }
            }
            _ if stage.continuation.is_some() => {
                let fact = "a continuation follows equilibria, and this stage has inertia or damping";
                return Err(builder.content(&place, fact, "take integrator = \"static\", or remove `continuation`"));
            }
            IntegratorSpec::Static => Integrator::Static,
            IntegratorSpec::ImplicitEuler => Integrator::ImplicitEuler { linearised: false },
            IntegratorSpec::ImplicitEulerLinearised => Integrator::ImplicitEuler { linearised: true },
            IntegratorSpec::ImplicitEulerCorrected => {
                Integrator::FreeMotion { integration_steps: stage.integration_steps.unwrap_or(1) }
            }
            IntegratorSpec::Bdf2 => Integrator::Bdf2,
            IntegratorSpec::GeneralisedAlpha { rho } if (0.0..=1.0).contains(&rho) => {
                Integrator::GeneralisedAlpha { rho }
            }
            IntegratorSpec::GeneralisedAlpha { rho } => {
                return Err(builder.content(&place, format!("rho = {rho}"), "it lies between 0 and 1"));
            }
            IntegratorSpec::Newmark { beta, gamma, .. } if beta > 0.0 && gamma > 0.0 => {
                Integrator::Newmark { beta, gamma }
            }
            IntegratorSpec::Newmark { beta, gamma, .. } => {
                let fact = format!("beta = {beta}, gamma = {gamma}");
                return Err(builder.content(&place, fact, "both must be positive; the usual ones are 0.25 and 0.5"));
            }
        };
        let end = start + stage.duration.0;
        spans.push(TimeSpan { integrator, start, end, dt: stage.dt.0.min(stage.duration.0) });
        start = end;
    }
    if spans.is_empty() {
        return Err(builder.content(
            "stage",
            "the scene has no stage",
            "add a [[stage]] with integrator, duration, dt",
        ));
    }
    Ok(spans)
}

pub(super) fn note_static(builder: &mut Builder, spec: &SceneSpec, spans: &[TimeSpan]) {
    let stages = spans.iter().filter(|s| s.integrator.is_static()).count();
    let rates: Vec<&str> = spec.effects.iter().filter(|e| e.needs_rates()).map(EffectSpec::kind).collect();
    if stages > 0 && !rates.is_empty() {
        builder.notes.push(format!("{} rest in the {stages} static stage(s)", rates.join(", ")));
    }
}

/// Notes on patches smaller than h; returns the reason why a cable through points has no limit as h → 0.
pub(super) fn note_patches(builder: &mut Builder, spec: &SceneSpec) -> Option<String> {
    let h = builder.body.mesh.h();
    let mut no_limit = None;
    for constraint in &spec.constraints {
        match constraint {
            ConstraintSpec::Cable(CableSpec { name, guide_radius: GuideRadius::Point, .. }) => {
                no_limit = Some(format!("the {name} acts through points"));
            }
            ConstraintSpec::Cable(CableSpec { name, guide_radius: GuideRadius::Ball(r), .. }) if *r < h => {
                builder.notes.push(format!("{name}: the guide radius {:.3} mm is below h = {:.3} mm", r * 1e3, h * 1e3))
            }
            _ => {}
        }
    }
    no_limit
}

pub(super) fn check_numerics(builder: &Builder, n: &NumericsSpec) -> Result<(), SceneError> {
    if !(n.tolerance > 0.0 && n.tolerance < 1.0) {
        let fact = format!("tolerance = {}", n.tolerance);
        return Err(builder.content("numerics", fact, "it lies between 0 and 1, for example 1e-8"));
    }
    if let Some(budget) = n.time_budget.filter(|b| b.0 <= 0.0) {
        let fact = format!("time_budget = {} s", budget.0);
        return Err(builder.content("numerics", fact, "give a positive time, for example \"10 min\""));
    }
    if let Some(error) = n.time_error.filter(|e| !(e.0 > 0.0 && e.0.is_finite())) {
        let fact = format!("time_error = {} m", error.0);
        return Err(builder.content("numerics", fact, "give a positive length, for example \"0.05 mm\""));
    }
    if n.reuse_threshold.is_nan() || n.reuse_threshold < 0.0 {
        let fact = format!("reuse_threshold = {}", n.reuse_threshold);
        return Err(builder.content("numerics", fact, "give a number of back-substitutions, 0 or more"));
    }
    if n.max_iterations == 0 {
        return Err(builder.content("numerics", "max_iterations = 0", "allow at least one iteration"));
    }
    Ok(())
}
