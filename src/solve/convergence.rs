//! The acceptance test of every nonlinear iteration: Newton's method, repeated contact corrections, arc length. A linearised step
//! ([`Integrator::is_linearised`](super::Integrator::is_linearised)) is accepted after its one iteration, whatever its error.

use super::equations::ScaledError;
use super::{Integrator, NewtonSettings};

/// Treatment of a state whose residual is below the tolerance only because it is rounding of the stiffest part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AtRounding {
    /// One more iteration. Under the rounding of a stiff part the error of a soft one does not show, and directions of Newton's
    /// method that come from a lagged factor are only as accurate as the whole residual asks for
    IterateOnceMore,
    /// Accepted: the directions are exact ones of the present tangent, which reduce the error of soft and stiff parts alike
    Accept,
}

/// The acceptance test of one solve.
pub(super) struct Convergence {
    tolerance: f64,
    max_iterations: usize,
    is_linearised: bool,
    at_rounding: AtRounding,
    /// Whether the last state was below the tolerance already
    was_below: bool,
}

impl Convergence {
    pub fn new(settings: &NewtonSettings, integrator: Integrator, at_rounding: AtRounding) -> Self {
        let NewtonSettings { tolerance, max_iterations, .. } = *settings;
        Self { tolerance, max_iterations, is_linearised: integrator.is_linearised(), at_rounding, was_below: false }
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
        converged || self.is_linearised && iterations > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_at_the_rounding_of_forces_is_confirmed_by_one_more_iteration() {
        let (far, rounding) =
            (ScaledError { exact: 1.0, above_rounding: 1.0 }, ScaledError { exact: 1.0, above_rounding: 0.5 });
        let exact = ScaledError { exact: 0.5, above_rounding: 0.5 };
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
