//! Search for a limit point where a step under prescribed loads failed or may have jumped over one.

use super::path::PathTracer;
use crate::solve::step_solver::StepSolver;
use crate::solve::{Solution, Status, Step, TimeSpan, TurningPoint};
use crate::system::{State, Want};

/// Largest number of steps of the search: the limit point lies within one step under prescribed loads.
const SEARCH: usize = 40;

/// Returns the status if a static step whose tangent was made definite has jumped over a limit point. Otherwise the sums are again those of `next`.
pub(in crate::solve) fn jumped(
    steps: &mut StepSolver,
    span: TimeSpan,
    state: &State,
    next: &State,
    solution: &Solution,
) -> Option<Status> {
    if !span.integrator.is_static() || !(solution.regularised || solution.projected) {
        return None;
    }
    let by_force = steps.system.forces_change(state.clock(), next.clock());
    let tracer = PathTracer::new(&mut steps.solver, steps.system, state, next.t, next.t - state.t);
    if tracer.is_ok_and(|tracer| !tracer.is_near(next))
        && let Some(TurningPoint { t: limit, node, .. }) = limit_point(steps, state, next.t)
    {
        let in_contact = steps.system.has_contact();
        return Some(Status::NoEquilibrium { t: state.t, limit, node, in_contact, by_force });
    }
    let step = Step { system: steps.system, integrator: span.integrator, past: state, dt: next.t - state.t };
    let again = steps.solver.equations.evaluate(&step, &mut next.clone(), Want::Residual, None);
    again.err().map(|why| Status::stopped(state.t, why, by_force))
}

/// Finds the limit point between `state` and the loads of `t`: the path is followed until it turns, or reaches those loads.
pub(in crate::solve) fn limit_point(steps: &mut StepSolver, state: &State, t: f64) -> Option<TurningPoint> {
    let cuts = steps.settings.cuts;
    // Short steps locate the limit accurately, and the first one must still rise: the limit may be much closer than t
    let mut dt = 0.1 * (t - state.t);
    let mut tracer = loop {
        let mut tracer = PathTracer::new(&mut steps.solver, steps.system, state, t, dt).ok()?;
        let point = tracer.step_with_cuts(&mut steps.solver, cuts).ok()?;
        if point.state.t == t {
            return None;
        }
        if point.state.t > state.t {
            break tracer;
        }
        dt /= 4.0;
        if dt < f64::EPSILON * t.abs() {
            return None;
        }
    };
    for _ in 0..SEARCH {
        if steps.solver.equations.limit.reached().is_some() {
            return None;
        }
        let point = tracer.step_with_cuts(&mut steps.solver, cuts).ok()?;
        if let Some(turn) = tracer.turning_point(&mut steps.solver) {
            // Beyond a limit point the tangent has one more negative eigenvalue, if they are counted; after a path that doubled back it does not
            let before = tracer.start_modes.unwrap_or(0);
            let lost = point.solution.unstable_modes.is_some_and(|n| n > before)
                || !steps.solver.equations.sums.skew.is_empty();
            return Some(turn).filter(|turn| turn.highest && lost);
        }
        if point.state.t == t {
            return None;
        }
    }
    None
}
