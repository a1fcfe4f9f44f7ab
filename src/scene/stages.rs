//! The stages of a scene, each with an integrator, and the conditions that signals must satisfy in them.

use super::build::builder::Builder;
use super::error::{SceneError, content};
use super::signal::protocol::{Between, NamedSignal, between};
use super::text::quantity::Time;
use crate::math::signal::Signal;
use crate::mesh::error::point;
use crate::solve::{Integrator, TimeSpan};
use crate::system::EnergyRole;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Largest number of steps of a stage; more are taken for a wrong unit.
const MOST_STEPS: f64 = 1e7;
/// Default of the largest number of steps of an arc-length stage, unless ten times the nominal number is larger.
const MOST_ARCS: usize = 200;

/// A period of time with one integrator.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageSpec {
    /// Integrator of the stage
    pub integrator: IntegratorSpec,
    /// Duration of the stage
    pub duration: Time,
    /// Time step
    pub dt: Time,
    /// Path following of a static stage; loads are followed in time if absent
    pub continuation: Option<ContinuationSpec>,
    /// Largest number of steps of a continuation
    pub max_steps: Option<usize>,
    /// Number of integration steps in each `dt`, for the loop that detects contact once per step
    pub integration_steps: Option<usize>,
}

impl StageSpec {
    /// A stage with steps of `dt`.
    pub fn new(integrator: IntegratorSpec, duration: Time, dt: Time) -> Self {
        Self { integrator, duration, dt, continuation: None, max_steps: None, integration_steps: None }
    }
}

/// How a static stage continues where the loads no longer determine the state.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum ContinuationSpec {
    /// By arc length, with the load as an unknown
    ArcLength,
}

/// Integrator of a stage in time
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum IntegratorSpec {
    /// Equilibria, without inertia and damping
    Static,
    /// Backward Euler rule, first order and dissipative
    ImplicitEuler,
    /// Backward Euler rule with one linear solution per step
    ImplicitEulerLinearised,
    /// Backward Euler rule for the free motion, with one correction for contact and constraints per step
    ImplicitEulerCorrected,
    /// Backward differentiation formula of second order
    Bdf2,
    /// Generalised-α method, second order
    GeneralisedAlpha {
        /// Spectral radius ρ∞ at high frequencies \[–\]: 1 conserves the energy of such modes, 0 removes it within one step
        rho: f64,
    },
    /// Newmark's method; `force = true` allows the undamped rule together with constraints and rigid bodies
    Newmark {
        /// Newmark's β \[–\]
        beta: f64,
        /// Newmark's γ \[–\]
        gamma: f64,
        /// Allows the undamped rule together with constraints and rigid bodies
        #[serde(default)]
        force: bool,
    },
}

/// Builds the time spans of the stages of a scene.
pub(super) fn build_spans(file: &Path, stages: &[StageSpec]) -> Result<Vec<TimeSpan>, SceneError> {
    let mut start = 0.0;
    let mut spans = Vec::new();
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("stage {}", k + 1);
        if stage.dt.0 <= 0.0 || stage.duration.0 <= 0.0 {
            let fact = format!("dt = {} s, duration = {} s", stage.dt.0, stage.duration.0);
            return Err(content(file, &place, fact, "both must be positive"));
        }
        if stage.duration.0 / stage.dt.0 > MOST_STEPS {
            let fact = format!("{:.1e} steps of {:e} s", stage.duration.0 / stage.dt.0, stage.dt.0);
            return Err(content(file, &place, fact, "take a larger dt or a shorter duration (check their units)"));
        }
        if stage.max_steps.is_some() && stage.continuation.is_none() {
            let fact = "max_steps without continuation";
            return Err(content(file, &place, fact, "add continuation = \"arc_length\", or remove it"));
        }
        if stage.integration_steps.is_some() && stage.integrator != IntegratorSpec::ImplicitEulerCorrected {
            let fact = "integration_steps without a loop that looks for contact between its steps";
            let remedy = "remove it, or take integrator = \"implicit_euler_corrected\"";
            return Err(content(file, &place, fact, remedy));
        }
        if stage.integration_steps == Some(0) {
            return Err(content(file, &place, "integration_steps = 0", "take 1 or more"));
        }
        let integrator = match stage.integrator {
            IntegratorSpec::Static if stage.continuation.is_some() => {
                let nominal = (stage.duration.0 / stage.dt.0).ceil() as usize;
                Integrator::ArcLength { max_steps: stage.max_steps.unwrap_or(MOST_ARCS.max(10 * nominal)) }
            }
            _ if stage.continuation.is_some() => {
                let fact = "a continuation follows equilibria, and this stage has inertia or damping";
                return Err(content(file, &place, fact, "take integrator = \"static\", or remove `continuation`"));
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
                return Err(content(file, &place, format!("rho = {rho}"), "it lies between 0 and 1"));
            }
            IntegratorSpec::Newmark { beta, gamma, .. } if beta > 0.0 && gamma >= 0.5 => {
                Integrator::Newmark { beta, gamma }
            }
            IntegratorSpec::Newmark { beta, gamma, .. } if beta > 0.0 => {
                let fact = format!("gamma = {gamma} makes energy in every step (beta = {})", short(beta));
                return Err(content(file, &place, fact, "take gamma from 0.5 on, where it is neutral; more damps"));
            }
            IntegratorSpec::Newmark { beta, gamma, .. } => {
                let fact = format!("beta = {beta}, gamma = {gamma}");
                return Err(content(file, &place, fact, "beta must be positive; the usual ones are 0.25 and 0.5"));
            }
        };
        let end = start + stage.duration.0;
        spans.push(TimeSpan { integrator, start, end, dt: stage.dt.0.min(stage.duration.0) });
        start = end;
    }
    if spans.is_empty() {
        return Err(content(file, "stage", "the scene has no stage", "add a [[stage]] with integrator, duration, dt"));
    }
    Ok(spans)
}

/// Refuses signals and masses with which a stage cannot run, and adds notes on details that its steps may not resolve.
pub(super) fn check_stages(builder: &mut Builder, stages: &[StageSpec]) -> Result<(), SceneError> {
    check_resolution(builder)?;
    check_formulas(builder)?;
    check_masses(builder)?;
    check_motions(builder, stages)?;
    let notes: Vec<String> =
        conditional_rules(builder).chain(fast_signals(builder)).chain(unfinished_signals(builder)).collect();
    builder.notes.extend(notes);
    Ok(())
}

/// Refuses prescribed motions with corners in a stage with an undamped rule. Such a rule finds velocities from v = 2 (x − xₙ)/Δt − vₙ, so that a jump of the
/// rate oscillates without decay, with growing accelerations. A stage after a static one starts with such a jump if a node moves, and one after a dynamic
/// stage if the rate jumps between them.
fn check_motions(builder: &Builder, stages: &[StageSpec]) -> Result<(), SceneError> {
    for (k, (span, stage)) in builder.spans.iter().zip(stages).enumerate() {
        let is_forced = matches!(stage.integrator, IntegratorSpec::Newmark { force: true, .. });
        if is_forced || !span.integrator.rings_with_constraints() {
            continue;
        }
        let before = k.checked_sub(1).map(|k| builder.spans[k].integrator);
        let jumps = |signal: &Signal| {
            let at_start = match before {
                None => false,
                Some(rule) if rule.is_static() => signal.moves_at(span.start, span.end),
                Some(_) => signal.jumps_at(span.start, span.end),
            };
            at_start || signal.has_corner(span.start, span.end)
        };
        if let Some(by) = builder.moved_by(jumps) {
            let name = span.integrator.name();
            let fact =
                format!("{name} is undamped, and the rate of a motion that is given jumps ({by}) and then rings");
            let remedy = "take \"bdf2\" or generalised_alpha with rho < 1, a motion without corners, or set force = true in newmark";
            return Err(builder.content(&format!("stage {}", k + 1), fact, remedy));
        }
    }
    Ok(())
}

/// A number as text, with a power of ten if it is small.
fn short(value: f64) -> String {
    if value.abs() < 1e-3 { format!("{value:e}") } else { value.to_string() }
}

/// Notes on Newmark rules that are stable only for short steps (Hughes, *The Finite Element Method*, 1987, § 9.1).
fn conditional_rules(builder: &Builder) -> impl Iterator<Item = String> {
    let short = |(k, span): (usize, &TimeSpan)| {
        let Integrator::Newmark { beta, gamma } = span.integrator else { return None };
        let least = 0.25 * (0.5 + gamma).powi(2);
        (beta < least * (1.0 - 1e-9)).then(|| {
            format!(
                "stage {}: newmark with beta = {} is stable only for steps that are short for the fastest motion of the mesh; with beta \
                 from {least:.4} on it is for all",
                k + 1,
                short(beta)
            )
        })
    };
    builder.spans.iter().enumerate().filter_map(short)
}

/// Share of its range by which a signal may exceed its values at the points of the time grid without a note \[–\].
const UNSEEN: f64 = 0.1;

/// Notes on signals that exceed their values at the points of the time grid between them.
fn fast_signals(builder: &Builder) -> impl Iterator<Item = String> {
    let known = builder.signals.iter().flat_map(|s| s.signal.prescribed().map(move |signal| (s, signal)));
    known.filter_map(|(NamedSignal { name, signal: whole }, signal)| {
        let Between { t, value, .. } = between(signal, &builder.spans).filter(|b| b.share > UNSEEN)?;
        // The time of a signal counts from the event that switches to it
        let [others, own] = match whole {
            Signal::Switched { .. } => [", or one that replaces it,", " of its own time"],
            _ => [""; 2],
        };
        Some(format!(
            "the signal {name}{others} goes to {value:.4e} at t = {t:.6} s{own}, between two points of the time grid: no step sees that; shorten dt"
        ))
    })
}

/// Notes on ramps and tables that continue after the end of the run.
fn unfinished_signals(builder: &Builder) -> impl Iterator<Item = String> {
    let end = builder.spans.last().map_or(0.0, |span| span.end);
    builder.signals.iter().filter_map(move |NamedSignal { name, signal }| {
        let late = signal.last_change().filter(|late| *late > end * (1.0 + 1e-9))?;
        Some(format!(
            "the signal {name} does not reach its end: it changes until t = {late} s, and the run ends at t = {end} s"
        ))
    })
}

/// Refuses steps that are lost in the rounding of the time.
fn check_resolution(builder: &Builder) -> Result<(), SceneError> {
    let Some(k) = builder.spans.iter().position(|span| !span.is_resolved()) else { return Ok(()) };
    let TimeSpan { end, dt, .. } = builder.spans[k];
    let fact = format!("steps of {dt:e} s at t = {end} s, whose rounding is {:.0e} s", f64::EPSILON * end);
    Err(builder.content(&format!("stage {}", k + 1), fact, "take a larger dt, or shorter stages before it"))
}

/// Refuses a formula that has no value at a time at which it is evaluated.
fn check_formulas(builder: &Builder) -> Result<(), SceneError> {
    for NamedSignal { name, signal } in builder.signals.iter().filter(|s| !s.signal.has_inputs()) {
        let times = builder.spans.iter().flat_map(|s| (0..=s.steps().min(100_000)).map(|k| s.point(k)));
        if let Some((t, value)) = times.map(|t| (t, signal.at(t))).find(|(_, value)| !value.is_finite()) {
            let fact = format!("it is {value} at t = {t} s");
            let remedy = "keep the formula defined there, for example by sqrt(max(x, 0)) in place of sqrt(x)";
            return Err(builder.content(&format!("signal {name}"), fact, remedy));
        }
    }
    Ok(())
}

/// Refuses a stage that needs an initial acceleration, which can be computed only if every free node has a mass.
fn check_masses(builder: &Builder) -> Result<(), SceneError> {
    let needs = |s: &TimeSpan| s.integrator.needs_initial_acceleration();
    let Some(k) = builder.spans.iter().position(needs) else { return Ok(()) };
    let mut has_mass = vec![false; builder.nodes];
    for effect in builder.effects.iter().filter(|e| e.role() == EnergyRole::Kinetic) {
        let blocks = effect.blocks();
        for &node in (0..blocks.len()).flat_map(|b| blocks.nodes(b)) {
            has_mass[node as usize] = true;
            for &(followed, _) in builder.tied.get(&node).into_iter().flatten() {
                has_mass[followed as usize] = true;
            }
        }
    }
    let is_free = |node: u32| {
        let moves = |dof: u32| builder.motion(dof).is_none() && builder.carried.iter().all(|(other, _)| *other != dof);
        !builder.tied.contains_key(&node) && (3 * node..3 * node + 3).any(moves)
    };
    let light: Vec<u32> = (0..builder.nodes as u32).filter(|&k| !has_mass[k as usize] && is_free(k)).collect();
    let Some(first) = light.first() else { return Ok(()) };
    let at = builder.body.mesh.points.get(*first as usize).map_or("a rigid part".into(), point);
    let fact = format!(
        "{} needs the acceleration at its start, and {} nodes that move have no mass, one of them at {at}",
        builder.spans[k].integrator.name(),
        light.len()
    );
    let remedy = "give the whole body an [[effect]] of kind \"inertia\", or take \"bdf2\" or \"implicit_euler\"";
    Err(builder.content(&format!("stage {}", k + 1), fact, remedy))
}

/// Refuses decisions during a run with continuation, whose points are not those of the time grid.
pub(super) fn check_continued(builder: &Builder, has_events: bool) -> Result<(), SceneError> {
    let decided = has_events || builder.signals.iter().any(|s| s.signal.has_inputs());
    let arc = builder.spans.iter().position(|s| matches!(s.integrator, Integrator::ArcLength { .. }));
    let Some(k) = arc.filter(|_| decided) else { return Ok(()) };
    let fact = "a continuation together with events, or with signals that are decided during the run";
    Err(builder.content(&format!("stage {}", k + 1), fact, "take integrator = \"static\" without `continuation`"))
}
