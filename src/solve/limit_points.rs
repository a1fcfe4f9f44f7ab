//! Stages by arc length, and the search for a limit point where a step under given loads failed or may have jumped.

use super::arc_length::Tracer;
use super::{Failure, Newton, Solved, Span, Status, Step, Stepper, TurningPoint};
use crate::system::{State, Want};

/// Steps of the search for a limit point: it lies within one step under given loads.
const SEARCH: usize = 40;

impl Stepper<'_> {
    /// Follows the path of equilibria from `state` until the loads are those of the end of the span.
    pub fn trace(
        &mut self,
        span: Span,
        max_steps: usize,
        state: &mut State,
        accepted: &mut impl FnMut(&State, &State, &Newton, bool) -> bool,
    ) -> Status {
        let mut tracer = match Tracer::new(&mut self.newton, self.system, state, span.end, span.dt) {
            Ok(tracer) => tracer,
            Err(why) => return self.lost(span, state, why),
        };
        let mut limit = None;
        for _ in 0..max_steps {
            if self.is_over() {
                return Status::TimeBudget { t: state.t };
            }
            let (found, cuts) = tracer.step(&mut self.newton, self.settings.cuts);
            self.totals.cuts += cuts as usize;
            let point = match found {
                Ok(point) => point,
                Err(why) => return self.lost(span, state, why),
            };
            if point.state.t < span.start && span.start > 0.0 {
                // Below lies the protocol of the stage before.
                let limit = limit.unwrap_or(state.t);
                return Status::LimitPoint { t: state.t, limit };
            }
            let past = std::mem::replace(state, point.state);
            self.totals.steps += 1;
            self.totals.iterations += point.iterations;
            self.note_stability(span.integrator, state.t, point.unstable_modes);
            if !accepted(&past, state, &self.newton, true) {
                return Status::Interrupted { t: state.t };
            }
            if let Some(turn) = tracer.turning_point(&mut self.newton) {
                limit = Some(limit.map_or(turn.t, |known: f64| known.max(turn.t)));
                self.findings.turning_points.push(turn);
            }
            if state.t == span.end {
                return Status::Converged;
            }
        }
        match limit {
            Some(limit) => Status::LimitPoint { t: state.t, limit },
            None => Status::StepTooSmall { t: state.t, why: Failure::MaxSteps },
        }
    }

    /// Why the path cannot be followed from `state`.
    fn lost(&mut self, span: Span, state: &State, why: Failure) -> Status {
        let step = Step { system: self.system, integrator: span.integrator, past: state, dt: 1.0 };
        let motions = self.newton.free_motions(&step, state, self.points);
        if motions.is_empty() { Status::stopped(state.t, why) } else { Status::Singular { t: state.t, motions } }
    }

    /// Did a static step whose tangent was made definite on its way jump over a limit point? If not, the sums are again those
    /// of `next`.
    pub(super) fn jumped(&mut self, span: Span, state: &State, next: &State, solved: &Solved) -> Option<Status> {
        if !span.integrator.is_static() || !(solved.regularised || solved.projected) {
            return None;
        }
        let tracer = Tracer::new(&mut self.newton, self.system, state, next.t, next.t - state.t);
        if tracer.is_ok_and(|tracer| !tracer.is_near(next))
            && let Some(TurningPoint { t: limit, node, .. }) = self.limit(state, next.t)
        {
            let touching = self.system.has_contact();
            return Some(Status::NoEquilibrium { t: state.t, limit, node, touching });
        }
        let step = Step { system: self.system, integrator: span.integrator, past: state, dt: next.t - state.t };
        self.newton.iterations = solved.iterations;
        let again = self.newton.evaluate(&step, &mut next.clone(), Want::Residual, None);
        again.err().map(|why| Status::stopped(state.t, why))
    }

    /// The limit point between `state` and the loads of `t`: the path is followed until it turns, or comes to those loads.
    pub(super) fn limit(&mut self, state: &State, t: f64) -> Option<TurningPoint> {
        // Short steps place the limit well, and the first one must still rise: it may be much closer than t.
        let mut dt = 0.1 * (t - state.t);
        let mut tracer = loop {
            let mut tracer = Tracer::new(&mut self.newton, self.system, state, t, dt).ok()?;
            let point = tracer.step(&mut self.newton, self.settings.cuts).0.ok()?;
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
            if self.is_over() {
                return None;
            }
            let point = tracer.step(&mut self.newton, self.settings.cuts).0.ok()?;
            if let Some(turn) = tracer.turning_point(&mut self.newton) {
                // Beyond a limit point the tangent has lost its definiteness, where it has any; a path that doubled back has not
                let lost = point.unstable_modes.is_some_and(|n| n > 0) || !self.newton.sums.skew.is_empty();
                return Some(turn).filter(|turn| turn.highest && lost);
            }
            if point.state.t == t {
                return None;
            }
        }
        None
    }
}
