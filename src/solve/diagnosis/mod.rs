//! Reasons why a step is impossible, as a status.

pub(super) mod free_motions;
pub(super) mod rigid_motions;

use super::arc_length::limit_points::limit_point;
use super::step_solver::StepSolver;
use super::{Failure, Integrator, Status, Step, TimeSpan, TurningPoint};
use crate::math::signal::Clock;
use crate::system::{State, System};
use free_motions::{free_motions, pushes};

/// Returns the status of a static step if a load pushes the body where nothing holds it, so that no smaller step helps.
pub(super) fn pushes_unheld_body(
    steps: &mut StepSolver,
    integrator: Integrator,
    state: &State,
    goal: f64,
) -> Option<Status> {
    if !integrator.is_static() || steps.points.is_empty() {
        return None;
    }
    let step = Step { system: steps.system, integrator, past: state, dt: goal - state.t };
    let motions = free_motions(&mut steps.solver, &step, state, steps.points);
    let pushed = pushes(&mut steps.solver, &step, &State { t: goal, ..state.clone() }, &motions);
    pushed.then_some(Status::Singular { t: state.t, motions })
}

/// The status of a step from `state` to `t` that no cut could save.
pub(super) fn stopped(system: &System, state: &State, t: f64, why: Failure) -> Status {
    let why = match why {
        Failure::NotConverged { residual, node } if state.t == 0.0 && system.acts_at(state.clock()) => {
            Failure::InFull { residual, node }
        }
        why => why,
    };
    match Status::stopped(state.t, why, by_force(system, state, t)) {
        Status::Inverted { t, why, .. } => {
            let displaced = system.prescribed.iter().any(|p| p.signal.at(state.clock()) != 0.0);
            Status::Inverted { t, why, in_full: t == 0.0 && displaced }
        }
        other => other,
    }
}

/// Whether a prescribed force, pressure or tension changes from `state` to `t`.
fn by_force(system: &System, state: &State, t: f64) -> bool {
    system.forces_change(state.clock(), Clock { t, ..state.clock() })
}

/// Determines why no step from `state`, not even the one to `t`, could be solved.
pub(super) fn diagnose(steps: &mut StepSolver, span: TimeSpan, state: &State, t: f64, why: Failure) -> Status {
    if !steps.settings.diagnosis {
        return stopped(steps.system, state, t, why);
    }
    if span.integrator.is_static() && !matches!(why, Failure::Jammed { .. } | Failure::NotFinite { .. }) {
        let step = Step { system: steps.system, integrator: span.integrator, past: state, dt: t - state.t };
        let motions = free_motions(&mut steps.solver, &step, state, steps.points);
        if !motions.is_empty() {
            return Status::Singular { t: state.t, motions };
        }
        if let Some(TurningPoint { t: limit, node, .. }) = limit_point(steps, state, t) {
            let (in_contact, by_force) = (steps.system.has_contact(), by_force(steps.system, state, t));
            return Status::NoEquilibrium { t: state.t, limit, node, in_contact, by_force };
        }
    }
    stopped(steps.system, state, t, why)
}

/// Determines why the path of equilibria cannot be followed from `state`.
pub(super) fn diagnose_path(steps: &mut StepSolver, span: TimeSpan, state: &State, why: Failure) -> Status {
    if !steps.settings.diagnosis || matches!(why, Failure::NotFinite { .. }) {
        return stopped(steps.system, state, span.end, why);
    }
    let step = Step { system: steps.system, integrator: span.integrator, past: state, dt: 1.0 };
    let motions = free_motions(&mut steps.solver, &step, state, steps.points);
    match motions.is_empty() {
        true => stopped(steps.system, state, span.end, why),
        false => Status::Singular { t: state.t, motions },
    }
}
