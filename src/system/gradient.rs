//! Gradients of functionals of a state.

use super::State;

/// Derivatives of a functional J by the unknowns of a state and by the reactions there; what is not listed is zero.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Gradient {
    /// (unknown, derivative) \[unit of J per m\]
    pub x: Vec<(u32, f64)>,
    /// (constraint, derivative by its multiplier)
    pub lambda: Vec<(usize, f64)>,
    /// (unknown, derivative) \[unit of J per N\]
    pub reaction: Vec<(u32, f64)>,
}

impl Gradient {
    /// Of a functional of the displacements only.
    pub fn of_displacements(x: Vec<(u32, f64)>) -> Self {
        Self { x, ..Self::default() }
    }

    /// Change of J with a change of the state and \[3 × nodes\] of the reactions.
    pub fn along(&self, change: &State, reaction: &[f64]) -> f64 {
        let sum = |weights: &[(u32, f64)], values: &[f64]| -> f64 {
            weights.iter().map(|(dof, weight)| weight * values[*dof as usize]).sum()
        };
        let of_multipliers: f64 = self.lambda.iter().map(|(c, weight)| weight * change.lambda[*c]).sum();
        sum(&self.x, &change.x) + of_multipliers + sum(&self.reaction, reaction)
    }
}
