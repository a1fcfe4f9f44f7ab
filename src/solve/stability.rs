//! Negative eigenvalues of the constrained tangent: n₋(K) − n₋(S), less one for each unknown of a second field.
//!
//! Pivots of a factorisation count those of K (Sylvester's law of inertia). Limits: the iterative path has no pivots, and counts none.

use super::Step;
use super::multipliers::Schur;
use super::newton::{Newton, Solution};
use crate::system::{State, System, Want};

impl Newton {
    /// Before the first iteration. What an earlier factorisation counted holds as long as there is no new one.
    pub(super) fn unsolved(&self) -> Solution {
        let unstable_modes = self.factor.multigrid().is_none().then_some(0);
        Solution { iterations: 0, unstable_modes, regularised: false, projected: self.sums.projected }
    }

    /// Negative eigenvalues of the constrained tangent at a converged state; none where it has no factorisation, or where they are
    /// not counted.
    pub(super) fn unstable_modes(&mut self, step: &Step, state: &State) -> Option<usize> {
        if self.factor.multigrid().is_some() && !self.factor.fell_back() {
            return None;
        }
        self.sums.descending = false;
        let evaluated = self.evaluate(step, &mut state.clone(), Want::Tangent, None);
        self.sums.descending = true;
        evaluated.ok()?;
        self.fit_factor(step.system);
        self.factor.factorise_counting(&self.sums.k).ok()?;
        let schur = self.schur(step.system).ok()?;
        self.negative(step.system, &schur)
    }

    /// Negative eigenvalues of the constrained tangent, by those of K: a second field brings one an unknown, a multiplier one
    /// of S. Where the tangent has a skew part they say nothing, and none is counted. None on the iterative path.
    pub(super) fn negative(&self, system: &System, schur: &Schur) -> Option<usize> {
        let expected = system.scalar_equations() + schur.negative;
        let pivots = self.factor.counts().then_some(self.factor.negative_eigenvalues)?;
        Some(if self.sums.skew.is_empty() { pivots.saturating_sub(expected) } else { 0 })
    }
}
