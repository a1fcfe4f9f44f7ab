//! The acceptance test of all nonlinear iterations: Newton's method, repeated contact corrections, and arc length. A linearised step
//! ([`Integrator::is_linearised`](crate::solve::Integrator::is_linearised)) is accepted after its one iteration, whatever its error.

use crate::solve::equations::ScaledError;
use crate::solve::{Integrator, NewtonSettings};

/// Treatment of a state whose residual is below the tolerance only because it is at the rounding level of the stiffest part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::solve) enum AtRounding {
    /// One more iteration is made. The rounding of a stiff part hides the error of a soft one, and directions of Newton's method from a lagged factor
    /// are only as accurate as the whole residual requires
    IterateOnceMore,
    /// The state is accepted: the directions are exact for the current tangent, and reduce the errors of soft and stiff parts equally
    Accept,
}

/// Size, relative to the accuracy, below which a correction by a shifted tangent is rounding \[–\].
const ROUNDED: f64 = 1e-6;
/// Ratio to the last estimated correction above which another iteration only perturbs rounding errors \[–\].
const STALLED: f64 = 0.5;

/// The acceptance test of one solve.
pub(in crate::solve) struct Convergence {
    tolerance: f64,
    accuracy: f64,
    max_iterations: usize,
    is_linearised: bool,
    at_rounding: AtRounding,
    /// Whether the previous state was already below the tolerance
    was_below: bool,
    /// The last estimated correction; infinite before the first one
    last_correction: f64,
}

impl Convergence {
    pub fn new(settings: &NewtonSettings, integrator: Integrator, at_rounding: AtRounding) -> Self {
        let NewtonSettings { tolerance, accuracy, max_iterations, .. } = *settings;
        let (is_linearised, last_correction) = (integrator.is_linearised(), f64::INFINITY);
        Self { tolerance, accuracy, max_iterations, is_linearised, at_rounding, was_below: false, last_correction }
    }

    /// Whether this is the last iteration that is allowed.
    pub fn is_last(&self, iterations: usize) -> bool {
        iterations == self.max_iterations
    }

    /// Whether a state with this error after this number of iterations is accepted as the solution. It must have reached all prescribed displacements
    /// (`is_complete`); the last state that is tried needs no confirmation.
    pub fn accepts(&mut self, error: ScaledError, is_complete: bool, iterations: usize) -> bool {
        let below = is_complete && error.above_rounding <= self.tolerance;
        let confirmed = self.was_below || self.is_last(iterations) || error.exact <= self.tolerance;
        self.was_below = below;
        let converged = below && (confirmed || self.at_rounding == AtRounding::Accept);
        converged || (self.is_linearised && iterations > 0)
    }

    /// Whether a state that [`Convergence::accepts`] is also accurate in its displacements: the remaining `correction`, relative to the largest
    /// displacement, is small, or no longer decreases because the forces are at the rounding level. The limit of this ratio does not depend on the
    /// mesh, whereas the sum of the forces of all blocks does. A state without an estimate must result from an iteration.
    ///
    /// With a tangent that `is_shifted` for lack of a factor, the corrections d decrease slowly and add up to d/(1 − q), where q is the ratio of the
    /// last two. This sum has to be small, and such a state is not accepted merely because d hardly decreases.
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
        // Far from the solution corrections may grow; only when the forces are at the rounding level can corrections not decrease further
        for (error, is_accurate) in [(forces, false), (rounding, true)] {
            let mut stalls = test();
            assert!(!stalls.is_accurate(Some(1e-3), error, false, 0));
            assert!(!stalls.is_accurate(Some(4e-4), error, false, 1));
            assert_eq!(stalls.is_accurate(Some(3e-4), error, false, 2), is_accurate);
        }
        // With a shifted tangent: 1e-7 that decreases by a tenth leaves another 1e-6, by a half 2e-7
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
