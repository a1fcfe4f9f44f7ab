//! The accuracy of the directions of Newton's method: the forcing term η of an inexact Newton method, ‖residual of the direction‖ ≤ η ‖r‖.
//!
//! An iteration from a state of error e leads to η e and a remainder of the linearisation, C e². A direction is as accurate as makes
//! η e a share of the remainder (Eisenstat & Walker, SIAM J. Sci. Comput. 17, 1996, choice 1, with C from the last iteration in place of the
//! remainder itself), never looser than min(0.1, √e), which makes Newton's method converge with the order 3/2 (Dembo, Eisenstat & Steihaug,
//! SIAM J. Numer. Anal. 19, 1982), and never below a third of the tolerance of the step. So a step whose remainder is below the
//! tolerance ends after one iteration.

/// The loosest relative accuracy of a direction.
const LOOSEST: f64 = 0.1;
/// Error of a direction as a share of the remainder that is expected.
const SHARE: f64 = 0.3;
/// Error of a direction that is enough for the step, as a share of its tolerance.
const ENOUGH: f64 = 0.3;

/// The forcing term, and what it knows of the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ForcingTerm {
    /// C of the last full iteration \[–\]; infinite before the first one
    pub nonlinearity: f64,
}

impl Default for ForcingTerm {
    fn default() -> Self {
        Self { nonlinearity: f64::INFINITY }
    }
}

impl ForcingTerm {
    /// η at a state of this error, in a step of this tolerance.
    pub fn at(&self, error: f64, tolerance: f64) -> f64 {
        let share = LOOSEST.min(error.sqrt()).min(SHARE * self.nonlinearity * error);
        share.max(ENOUGH * tolerance / error)
    }

    /// A full iteration from a state of error `before`, whose direction left the error `left`, led to the error `after`.
    pub fn observe(&mut self, before: f64, left: f64, after: f64) {
        self.nonlinearity = (after - left).abs() / (before * before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: f64 = 1e-8;

    /// Iterations and last error of e → η e + C e² from e₀, by a forcing term that begins without knowledge and is used for `steps` steps.
    fn iterate(c: f64, e0: f64, steps: usize) -> (usize, f64) {
        let mut forcing = ForcingTerm::default();
        let (mut count, mut e) = (0, e0);
        for _ in 0..steps {
            (count, e) = (0, e0);
            while e > TOLERANCE {
                let left = forcing.at(e, TOLERANCE) * e;
                let after = left + c * e * e;
                forcing.observe(e, left, after);
                (count, e) = (count + 1, after);
            }
        }
        (count, e)
    }

    /// Exact directions take one iteration where C e₀² ≤ ε, two where C (C e₀²)² ≤ ε. With a forcing term that knows C an iteration leads to
    /// at most 1.3 C e² or C e² + 0.3 ε, so that it takes as many but next to these bounds.
    #[test]
    fn takes_no_more_iterations_than_exact_directions() {
        for (c, e0, exact) in [(1.0, 5e-5, 1), (2.0, 1e-3, 2), (50.0, 1e-5, 1), (0.5, 1e-2, 2)] {
            assert_eq!(iterate(c, e0, 2).0, exact, "C = {c}, e = {e0}");
        }
        // Without knowledge the order is 3/2
        assert_eq!(iterate(1.0, 5e-5, 1).0, 2);
    }

    #[test]
    fn lies_between_its_bounds() {
        let known = |nonlinearity: f64| ForcingTerm { nonlinearity };
        assert_eq!(ForcingTerm::default().at(1e-4, TOLERANCE), 1e-2);
        assert_eq!(ForcingTerm::default().at(1.0, TOLERANCE), LOOSEST);
        assert_eq!(known(1e6).at(1e-4, TOLERANCE), 1e-2);
        // Of products, equal but for rounding
        assert!((known(10.0).at(1e-3, TOLERANCE) - SHARE * 1e-2).abs() < 1e-17);
        assert!((known(0.0).at(1e-4, TOLERANCE) - ENOUGH * 1e-4).abs() < 1e-19);
    }

    /// An inexact direction does not hide the remainder: C is of what it did not leave.
    #[test]
    fn knows_the_remainder_alone() {
        let mut forcing = ForcingTerm::default();
        forcing.observe(1e-3, 5e-4, 5e-4 + 2e-6);
        assert!((forcing.nonlinearity - 2.0).abs() < 1e-9);
    }
}
