//! The acceptance test of every nonlinear iteration: Newton's method, repeated contact corrections, arc length. A linearised step
//! ([`Integrator::is_linearised`](crate::solve::Integrator::is_linearised)) is accepted after its one iteration, whatever its error.

use crate::solve::equations::ScaledError;
use crate::solve::{Integrator, NewtonSettings};

/// Treatment of a state whose residual is below the tolerance only because it is rounding of the stiffest part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::solve) enum AtRounding {
    /// One more iteration. Under the rounding of a stiff part the error of a soft one does not show, and directions of Newton's
    /// method that come from a lagged factor are only as accurate as the whole residual asks for
    IterateOnceMore,
    /// Accepted: the directions are exact ones of the present tangent, which reduce the error of soft and stiff parts alike
    Accept,
}

/// Share of the accuracy below which a correction by a shifted tangent is rounding \[–\].
const ROUNDED: f64 = 1e-6;
/// Share of the last estimated correction above which another iteration only stirs rounding \[–\].
const STALLED: f64 = 0.5;

/// The acceptance test of one solve.
pub(in crate::solve) struct Convergence {
    tolerance: f64,
    accuracy: f64,
    max_iterations: usize,
    is_linearised: bool,
    at_rounding: AtRounding,
    /// Whether the last state was below the tolerance already
    was_below: bool,
    /// Correction that was estimated last; infinite before
    last_correction: f64,
}

impl Convergence {
    pub fn new(settings: &NewtonSettings, integrator: Integrator, at_rounding: AtRounding) -> Self {
        let NewtonSettings { tolerance, accuracy, max_iterations, .. } = *settings;
        let (is_linearised, last_correction) = (integrator.is_linearised(), f64::INFINITY);
        Self { tolerance, accuracy, max_iterations, is_linearised, at_rounding, was_below: false, last_correction }
    }

    /// Whether no iteration may follow so many.
    pub fn is_last(&self, iterations: usize) -> bool {
        iterations == self.max_iterations
    }

    /// Whether a state of this error after so many iterations is accepted as the solution. It must have all prescribed displacements
    /// (`is_complete`); the last state that is tried needs no confirmation.
    pub fn accepts(&mut self, error: ScaledError, is_complete: bool, iterations: usize) -> bool {
        let below = is_complete && error.above_rounding <= self.tolerance;
        let confirmed = self.was_below || self.is_last(iterations) || error.exact <= self.tolerance;
        self.was_below = below;
        let converged = below && (confirmed || self.at_rounding == AtRounding::Accept);
        converged || (self.is_linearised && iterations > 0)
    }

    /// Whether a state that [`Convergence::accepts`] is accurate in its displacements too: the `correction` that it still asks for,
    /// as a share of the largest displacement, is small, or no longer falls because the forces are rounding. The limit of this share does not depend on the
    /// mesh; the sum of the forces of all blocks does. A state without an estimate has to come from an iteration.
    ///
    /// By a tangent that `is_shifted` for want of a factor, corrections d fall slowly, to a sum of d/(1 − q) with the ratio q of the last two: this is what has
    /// to be small, and such a state is not accepted because d hardly falls.
    pub fn is_accurate(
        &mut self,
        correction: Option<f64>,
        error: ScaledError,
        is_shifted: bool,
        iterations: usize,
    ) -> bool {
        let Some(correction) = correction else {
            return iterations > 0 || self.is_last(iterations) || self.is_linearised;
        };
        let last = std::mem::replace(&mut self.last_correction, correction);
        if is_shifted {
            let is_known = last.is_finite() && correction * last <= self.accuracy * (last - correction);
            return is_known || correction <= ROUNDED * self.accuracy || self.is_linearised;
        }
        correction <= self.accuracy || (error.is_rounding && correction > STALLED * last) || self.is_linearised
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_accurate_where_its_correction_is_small_or_stalls() {
        let settings = NewtonSettings { accuracy: 1e-6, max_iterations: 3, ..NewtonSettings::default() };
        let test = || Convergence::new(&settings, Integrator::Static, AtRounding::IterateOnceMore);
        let forces = ScaledError { exact: 1e-9, above_rounding: 1e-9, is_rounding: false };
        let rounding = ScaledError { is_rounding: true, ..forces };
        let exact =
            |test: &mut Convergence, correction, iterations| test.is_accurate(correction, forces, false, iterations);
        assert!(exact(&mut test(), Some(1e-6), 0) && !exact(&mut test(), Some(2e-6), 2));
        assert!(!exact(&mut test(), None, 0) && exact(&mut test(), None, 1) && !exact(&mut test(), Some(2e-6), 3));
        // Far from the solution corrections may grow, and only those of forces that are rounding have nowhere to fall to
        for (error, is_accurate) in [(forces, false), (rounding, true)] {
            let mut stalls = test();
            assert!(!stalls.is_accurate(Some(1e-3), error, false, 0));
            assert!(!stalls.is_accurate(Some(4e-4), error, false, 1));
            assert_eq!(stalls.is_accurate(Some(3e-4), error, false, 2), is_accurate);
        }
        // By a shifted tangent: 1e-7 that falls by a tenth leaves 1e-6 more, by a half 2e-7
        for (ratio, is_accurate) in [(0.95, false), (0.5, true), (1.0, false), (1.2, false)] {
            let mut slow = test();
            assert!(!slow.is_accurate(Some(1e-7 / ratio), rounding, true, 1), "nothing is known of the ratio");
            assert_eq!(slow.is_accurate(Some(1e-7), rounding, true, 2), is_accurate, "ratio {ratio}");
        }
        assert!(!test().is_accurate(Some(1.0), forces, true, 3) && test().is_accurate(Some(0.0), forces, true, 1));
        let mut at_rounding = test();
        let mut is_accurate = |iterations| at_rounding.is_accurate(Some(1e-13), rounding, true, iterations);
        assert!(is_accurate(1) && is_accurate(2));
    }

    #[test]
    fn a_state_at_the_rounding_of_forces_is_confirmed_by_one_more_iteration() {
        let far = ScaledError { exact: 1.0, above_rounding: 1.0, is_rounding: false };
        let rounding = ScaledError { above_rounding: 0.5, is_rounding: true, ..far };
        let exact = ScaledError { exact: 0.5, above_rounding: 0.5, is_rounding: false };
        let settings = NewtonSettings { tolerance: 0.5, max_iterations: 3, ..NewtonSettings::default() };
        let test = |at_rounding| Convergence::new(&settings, Integrator::Static, at_rounding);
        let newton = || test(AtRounding::IterateOnceMore);
        assert!(
            !newton().accepts(far, true, 3) && newton().accepts(exact, true, 0) && newton().accepts(rounding, true, 3)
        );
        let mut twice = newton();
        assert!(!twice.accepts(rounding, true, 0) && twice.accepts(rounding, true, 1));
        assert!(test(AtRounding::Accept).accepts(rounding, true, 0));
    }
}
