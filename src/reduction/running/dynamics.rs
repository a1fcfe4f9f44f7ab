//! Inertia, damping and time stepping of a dynamic reduced model.

use crate::solve::Integrator;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Inertia, damping and time stepping of a dynamic model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dynamics {
    pub integrator: Integrator,
    /// Length of a step \[s\]
    pub dt: f64,
    /// \[displacement modes × displacement modes\] VᵀMV \[kg\], with the mass matrix M
    pub mass: Vec<f64>,
    /// \[displacement modes × displacement modes\] VᵀCV \[kg/s\], with the sum C of constant damping matrices
    pub damping: Vec<f64>,
    /// For each input: its largest change per step in the runs from which the model and its error bars were made
    pub changes: Vec<f64>,
    /// Length of the longest run from which the error bars were made \[s\]
    pub duration: f64,
}

impl Dynamics {
    /// Whether no input changes by more per step than in the runs from which the model was made.
    pub fn allows(&self, from: &[f64], to: &[f64]) -> bool {
        from.iter().zip(to).zip(&self.changes).all(|((from, to), most)| (to - from).abs() <= most * (1.0 + ROUNDING))
    }

    /// Whether a time since the rest state is within the runs from which the error bars were made.
    pub fn covers(&self, t: f64) -> bool {
        t <= self.duration + 0.5 * self.dt
    }

    /// Returns the reason why the parts do not belong to a model with `n` displacement modes and this number of inputs, if they do not.
    pub fn fault(&self, n: usize, inputs: usize) -> Option<&'static str> {
        let matrix = |m: &[f64]| m.len() == n * n && m.iter().all(|x| x.is_finite());
        let sound = |x: f64| x.is_finite() && x >= 0.0;
        let checks = [
            (self.dt > 0.0 && self.dt.is_finite() && !self.integrator.is_static(), "it has no step in time"),
            (matrix(&self.mass) && matrix(&self.damping), "the mass or the damping has another size"),
            (
                !self.integrator.needs_initial_acceleration() || factor(&self.mass, n).is_some(),
                "the mass of its modes is not positive within rounding",
            ),
            (
                self.changes.len() == inputs && self.changes.iter().all(|c| sound(*c)),
                "the changes of inputs are not known",
            ),
            (sound(self.duration), "the length of its runs is not known"),
        ];
        checks.into_iter().find(|(holds, _)| !holds).map(|(_, fact)| fact)
    }
}

/// Relative difference between changes that is rounding \[–\].
const ROUNDING: f64 = 1e-9;

/// Returns the Cholesky factor of a mass matrix, if it is positive definite.
pub fn factor(mass: &[f64], n: usize) -> Option<nalgebra::Cholesky<f64, nalgebra::Dyn>> {
    DMatrix::from_row_slice(n, n, mass).cholesky()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If all modes translate far more than they deform, rounding leaves only one direction of their mass matrix: integrators that need an initial
    /// acceleration cannot use it, others can.
    #[test]
    fn a_mass_of_one_direction_is_refused_where_accelerations_begin() {
        let model = |integrator: Integrator| Dynamics {
            integrator,
            dt: 0.01,
            mass: vec![1.0, 3.0, 3.0, 9.0],
            damping: vec![0.0; 4],
            changes: vec![1.0],
            duration: 1.0,
        };
        assert_eq!(model(Integrator::Bdf2).fault(2, 1), None);
        let fault = model(Integrator::GeneralisedAlpha { rho: 0.5 }).fault(2, 1);
        assert!(fault.is_some_and(|fact| fact.contains("not positive within rounding")), "{fault:?}");
    }
}
