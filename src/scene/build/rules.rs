//! Combinations that no run can satisfy, one rule for each: the place, the fact, and the remedy.
//!
//! A mistake in the values of one part is refused where that part is built; a rule in this module involves two parts.

use crate::scene::error::SceneError;
use crate::scene::linear_solver::LinearSpec;
use crate::scene::parts::contact::spec::{ContactSpec, ResponseSpec};
use crate::scene::parts::effects::EffectSpec;
use crate::scene::spec::{ConstraintSpec, SceneSpec};
use crate::scene::stages::IntegratorSpec;
use crate::solve::{Integrator, TimeSpan};
use std::path::Path;

/// A combination that is refused.
struct Refusal {
    place: String,
    fact: String,
    remedy: &'static str,
}

impl Refusal {
    fn new(place: impl Into<String>, fact: impl Into<String>, remedy: &'static str) -> Option<Self> {
        Some(Self { place: place.into(), fact: fact.into(), remedy })
    }
}

/// A rule, which returns the refusal of a scene that breaks it.
type Rule = fn(&SceneSpec, &[TimeSpan]) -> Option<Refusal>;

/// All rules, in the order in which they are checked.
const RULES: [Rule; 12] = [
    time_error_in_statics,
    time_error_of_corrections,
    rates_in_statics,
    acceleration_without_inertia,
    friction_of_cables_along_an_arc,
    undamped_rule_with_exact_constraints,
    undamped_rule_with_rigid_bodies,
    undamped_rule_with_friction,
    free_body_in_statics,
    contact_along_an_arc,
    corrections_without_multipliers,
    iterative_solver,
];

/// Refuses a scene that breaks a rule.
pub(in crate::scene) fn check(file: &Path, spec: &SceneSpec, spans: &[TimeSpan]) -> Result<(), SceneError> {
    let Some(Refusal { place, fact, remedy }) = RULES.iter().find_map(|rule| rule(spec, spans)) else {
        return Ok(());
    };
    Err(SceneError::Content { file: file.into(), place, fact, remedy: remedy.into() })
}

fn is_corrected(span: &TimeSpan) -> bool {
    matches!(span.integrator, Integrator::FreeMotion { .. })
}

fn is_arc(span: &TimeSpan) -> bool {
    matches!(span.integrator, Integrator::ArcLength { .. })
}

fn time_error_in_statics(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    spec.numerics.time_error.filter(|_| spans.iter().all(|s| s.integrator.is_static()))?;
    let fact = "time_error where all stages are static: a sequence of equilibria has no time error";
    Refusal::new("numerics", fact, "remove it, or give a stage a dynamic integrator")
}

fn time_error_of_corrections(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    spec.numerics.time_error.filter(|_| spans.iter().any(is_corrected))?;
    let fact = "time_error with implicit_euler_corrected, whose steps cannot be cut";
    Refusal::new("numerics", fact, "remove it, or take integrator = \"implicit_euler\"")
}

fn rates_in_statics(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let (k, effect) = spec.effects.iter().enumerate().find(|(_, e)| e.needs_rates())?;
    if spans.iter().any(|s| !s.integrator.is_static()) {
        return None;
    }
    let kind = effect.kind();
    let remedy = "remove the effect, or give a stage a dynamic integrator such as \"bdf2\"";
    Refusal::new(format!("effect {} ({kind})", k + 1), format!("{kind} under the static integrator"), remedy)
}

fn acceleration_without_inertia(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    if spec.effects.iter().any(|e| matches!(e, EffectSpec::Inertia(_))) {
        return None;
    }
    let k = spans.iter().position(|s| s.integrator.needs_initial_acceleration())?;
    let fact = format!("{} without inertia", spans[k].integrator.name());
    Refusal::new(format!("stage {}", k + 1), fact, "add an [[effect]] of kind \"inertia\", or take \"static\"")
}

fn friction_of_cables_along_an_arc(spec: &SceneSpec, _: &[TimeSpan]) -> Option<Refusal> {
    let k = spec.stages.iter().position(|s| s.continuation.is_some())?;
    spec.constraints.iter().find(|c| c.has_friction())?;
    let fact = "a continuation with a cable with friction, whose tensions depend on the path";
    let remedy = "remove the friction, or drive the cable by length step by step";
    Refusal::new(format!("stage {}", k + 1), fact, remedy)
}

/// Refuses the first stage that uses an undamped rule without `force`, for the reason `why`.
fn undamped(spec: &SceneSpec, spans: &[TimeSpan], why: &str, remedy: &'static str) -> Option<Refusal> {
    let forced = |k: usize| matches!(spec.stages[k].integrator, IntegratorSpec::Newmark { force: true, .. });
    let rings = |(k, s): (usize, &TimeSpan)| s.integrator.rings_with_constraints() && !forced(k);
    let k = spans.iter().enumerate().position(rings)?;
    let fact = format!("{} is undamped, and {why}", spans[k].integrator.name());
    Refusal::new(format!("stage {}", k + 1), fact, remedy)
}

fn undamped_rule_with_exact_constraints(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let (k, part) = spec.constraints.iter().enumerate().find_map(|(k, c)| Some((k, c.exact()?)))?;
    let remedy = "take \"bdf2\" or generalised_alpha with rho < 1, or set force = true in newmark";
    undamped(spec, spans, &format!("rings with {part} (constraint {}; Cardona & Géradin 1989)", k + 1), remedy)
}

fn undamped_rule_with_rigid_bodies(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let rigid = &spec.rigids.first()?.name;
    let why = format!(
        "the energy of a free rigid body grows with it where it turns (rigid 1, {rigid}): its stiffness is high"
    );
    let remedy =
        "take \"bdf2\", or generalised_alpha with rho well below 1 and a short dt, or set force = true in newmark";
    undamped(spec, spans, &why, remedy)
}

fn undamped_rule_with_friction(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let (k, contact) = spec.contacts.iter().enumerate().find(|(_, c)| c.friction > 0.0)?;
    let why = format!("rings with friction (contact {}, {}): what sticks is held elastically", k + 1, contact.name);
    let remedy = "take \"bdf2\" or generalised_alpha with rho < 1, or set force = true in newmark";
    undamped(spec, spans, &why, remedy)
}

fn free_body_in_statics(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let rigid = spec.rigids.first()?;
    let k = spans.iter().position(|s| s.integrator.is_static())?;
    let fact = format!("the body is free, and nothing holds it in stage {} (static)", k + 1);
    Refusal::new(format!("rigid 1 ({})", rigid.name), fact, "take a dynamic integrator such as \"bdf2\"")
}

fn contact_along_an_arc(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let contact = spec.contacts.first()?;
    let k = spans.iter().position(is_arc)?;
    let fact = format!("a continuation with contact (stage {})", k + 1);
    let remedy = "take integrator = \"static\" without `continuation`";
    Refusal::new(format!("contact 1 ({})", contact.name), fact, remedy)
}

fn corrections_without_multipliers(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let k = spans.iter().position(is_corrected)?;
    let other = |c: &&ContactSpec| c.response != ResponseSpec::Multiplier;
    let (n, contact) = spec.contacts.iter().enumerate().find(|(_, c)| other(c))?;
    let fact = format!("{} with implicit_euler_corrected (stage {})", contact.response.name(), k + 1);
    let remedy = "take response = \"multiplier\" (of an obstacle that is no region): this loop corrects by multipliers";
    Refusal::new(format!("contact {} ({})", n + 1, contact.name), fact, remedy)
}

fn iterative_solver(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<Refusal> {
    let why = against_iterations(spec, spans).filter(|_| spec.numerics.linear == LinearSpec::Iterative)?;
    Refusal::new("numerics", format!("linear = \"iterative\" where {why}"), "take linear = \"auto\"")
}

/// The property of the tangents, if there is one, that rules out the iterative solver.
pub(in crate::scene) fn against_iterations(spec: &SceneSpec, spans: &[TimeSpan]) -> Option<&'static str> {
    if spec.contacts.iter().any(|c| c.response == ResponseSpec::Multiplier) {
        Some("multipliers of a contact are unknown next to the displacements")
    } else if spec.constraints.iter().any(|c| matches!(c, ConstraintSpec::Rigid(_)))
        || !spec.rigids.is_empty()
        || spec.contacts.iter().any(|c| c.motion.is_some())
    {
        Some("a rigid body, or an obstacle with a `motion`, has nodes that are not those of a mesh")
    } else if spans.iter().any(is_arc) {
        Some("arc length goes through unstable equilibria, whose tangents are indefinite")
    } else {
        None
    }
}
