//! Gradients of functionals of a state.

use super::State;

/// Derivatives of a functional J with respect to the unknowns of a state and the reactions there; derivatives that are not listed are zero.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Gradient {
    /// (unknown, derivative) \[unit of J per m\]
    pub x: Vec<(u32, f64)>,
    /// (constraint, derivative with respect to its multiplier)
    pub lambda: Vec<(usize, f64)>,
    /// (unknown, derivative) \[unit of J per N\]
    pub reaction: Vec<(u32, f64)>,
}

impl Gradient {
    /// The gradient of a functional of the displacements only.
    pub fn of_displacements(x: Vec<(u32, f64)>) -> Self {
        Self { x, ..Self::default() }
    }

    /// Change of J due to a change of the state and of the reactions \[3 × nodes\].
    pub fn along(&self, change: &State, reaction: &[f64]) -> f64 {
        self.terms(change, reaction).sum()
    }

    /// The terms whose sum is the change of J, [`Self::along`].
    pub fn terms<'g>(&'g self, change: &'g State, reaction: &'g [f64]) -> impl Iterator<Item = f64> + 'g {
        let of_x = self.x.iter().map(|(dof, weight)| weight * change.x[*dof as usize]);
        let of_multipliers = self.lambda.iter().map(|(c, weight)| weight * change.lambda[*c]);
        let of_reactions = self.reaction.iter().map(|(dof, weight)| weight * reaction[*dof as usize]);
        of_x.chain(of_multipliers).chain(of_reactions)
    }
}
