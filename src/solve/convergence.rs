//! The acceptance test of every nonlinear iteration: Newton's method, repeated contact corrections, arc length.

use super::equations::ScaledError;

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
    at_rounding: AtRounding,
    /// Whether the last state was below the tolerance already
    was_below: bool,
}

impl Convergence {
    pub fn new(tolerance: f64, at_rounding: AtRounding) -> Self {
        Self { tolerance, at_rounding, was_below: false }
    }

    /// Whether a state of this error is accepted as the solution. It must have all prescribed displacements (`is_complete`); the
    /// `last` state that is tried needs no confirmation.
    pub fn is_converged(&mut self, error: ScaledError, is_complete: bool, last: bool) -> bool {
        let below = is_complete && error.above_rounding <= self.tolerance;
        let confirmed = self.was_below || last || error.exact <= self.tolerance;
        self.was_below = below;
        below && (confirmed || self.at_rounding == AtRounding::Accept)
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
        let test = || Convergence::new(0.5, AtRounding::IterateOnceMore);
        assert!(
            !test().is_converged(far, true, true)
                && test().is_converged(exact, true, false)
                && test().is_converged(rounding, true, true)
        );
        let mut twice = test();
        assert!(!twice.is_converged(rounding, true, false) && twice.is_converged(rounding, true, false));
        assert!(Convergence::new(0.5, AtRounding::Accept).is_converged(rounding, true, false));
    }
}
