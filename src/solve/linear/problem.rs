//! The linear system of one iteration, [K Hᵀ; H −C] [du; dλ] = [−r − lift; g − carried], and its solution.

use super::multipliers::Schur;
use super::tangent;
use crate::math::linear::Factor;
use crate::math::vector::dot;
use crate::solve::equations::Equations;
use crate::solve::{Failure, Step};
use crate::system::{State, System};

/// The state of one iteration, with its equations linearised there.
#[derive(Clone, Copy)]
pub(in crate::solve) struct LinearProblem<'a> {
    pub step: &'a Step<'a>,
    pub equations: &'a Equations,
    pub state: &'a State,
    /// \[unknowns\] the remaining prescribed motion, if any
    pub increment: Option<&'a [f64]>,
}

/// Solution of a [`LinearProblem`].
pub(in crate::solve) struct NewtonDirection {
    /// \[unknowns\] change of the state
    pub x: Vec<f64>,
    /// \[constraints\] multipliers after the step
    pub lambda: Vec<f64>,
}

impl<'a> LinearProblem<'a> {
    pub fn system(&self) -> &'a System {
        self.step.system
    }

    /// −r − lift \[equations\]
    pub fn right_side(&self) -> Vec<f64> {
        self.equations.right_side(self.system(), self.increment.is_some())
    }

    /// Change of g \[constraints\] due to the free displacements `y` \[equations\] and the prescribed motion.
    pub fn shift(&self, y: &[f64]) -> Vec<f64> {
        let sums = &self.equations.sums;
        (0..self.state.lambda.len()).map(|c| -sums.increment_gap[c] - dot(&sums.gradient[c], y)).collect()
    }

    /// The direction with free displacements `du` \[equations\].
    pub fn direction(&self, du: &[f64], lambda: Vec<f64>) -> NewtonDirection {
        let system = self.system();
        let mut x = self.increment.map_or_else(|| vec![0.0; system.dofs.equation.len()], <[f64]>::to_vec);
        system.expand(du, &mut x);
        NewtonDirection { x, lambda }
    }

    /// Computes du = K⁻¹(−r − lift) − Z (λ' − λ), where λ' follows from the laws of the linearised constraints. `factor` is that of K.
    pub fn solve(&self, factor: &mut Factor, schur: &Schur) -> Result<NewtonDirection, Failure> {
        let mut y = self.right_side();
        tangent::solve(factor, &self.equations.sums, &mut y).map_err(Failure::Linear)?;
        // r contains λ h with h = ∂c/∂x, so that du = y − Σ z (λ' − λ); g' = g − h·du − (change by the prescribed motion)
        let mut lambda = vec![0.0; self.state.lambda.len()];
        if !lambda.is_empty() {
            let rows = self.equations.rows(self.state);
            let found = schur.multipliers(self.system(), &rows, &self.shift(&y));
            (lambda, _) = found.ok_or(Failure::Complementarity)?;
            for (z, (new, old)) in schur.z.chunks_exact(y.len()).zip(lambda.iter().zip(&self.state.lambda)) {
                let change = new - old;
                y.iter_mut().zip(z).for_each(|(y, z)| *y -= z * change);
            }
        }
        Ok(self.direction(&y, lambda))
    }
}
