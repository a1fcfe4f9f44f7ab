//! Reasons why a step is impossible, as a status.

use super::free_motions::{free_motions, pushes};
use super::limit_points::limit_point;
use super::step_solver::StepSolver;
use super::{Failure, Integrator, Status, Step, TimeSpan, TurningPoint};
use crate::math::signal::Clock;
use crate::system::State;

/// A static step over a load that pushes the body where nothing holds it: no smaller step helps.
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

/// The reason why no step from `state`, not even the one to `t`, could be solved.
pub(super) fn diagnose(steps: &mut StepSolver, span: TimeSpan, state: &State, t: f64, why: Failure) -> Status {
    let by_force = steps.system.forces_change(state.clock(), Clock { t, ..state.clock() });
    if !steps.settings.diagnosis {
        return Status::stopped(state.t, why, by_force);
    }
    if span.integrator.is_static() && !matches!(why, Failure::Jammed { .. } | Failure::NotFinite { .. }) {
        let step = Step { system: steps.system, integrator: span.integrator, past: state, dt: t - state.t };
        let motions = free_motions(&mut steps.solver, &step, state, steps.points);
        if !motions.is_empty() {
            return Status::Singular { t: state.t, motions };
        }
        if let Some(TurningPoint { t: limit, node, .. }) = limit_point(steps, state, t) {
            let in_contact = steps.system.has_contact();
            return Status::NoEquilibrium { t: state.t, limit, node, in_contact, by_force };
        }
    }
    Status::stopped(state.t, why, by_force)
}

/// The reason why the path of equilibria cannot be followed from `state`.
pub(super) fn diagnose_path(steps: &mut StepSolver, span: TimeSpan, state: &State, why: Failure) -> Status {
    if !steps.settings.diagnosis || matches!(why, Failure::NotFinite { .. }) {
        return Status::stopped(state.t, why, true);
    }
    let step = Step { system: steps.system, integrator: span.integrator, past: state, dt: 1.0 };
    let motions = free_motions(&mut steps.solver, &step, state, steps.points);
    if motions.is_empty() { Status::stopped(state.t, why, true) } else { Status::Singular { t: state.t, motions } }
}
