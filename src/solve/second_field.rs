//! The second field at a state that is not the end of a step, where it follows from the displacements.
//!
//! At fixed displacements its rows are linear in it, r_π = b(u) − C π with C = −∂r_π/∂π positive definite, so that π = C⁻¹ b(u). At the ends of steps
//! these rows are zero anyway.

use super::Failure;
use crate::math::linear::Factor;
use crate::math::sparse::SymPattern;
use crate::system::{Assembled, State, System, Want};

/// Sets the second field of a state so that it is consistent with the displacements. If an effect is not defined there, the field is zero, and the
/// first step stops.
///
/// # Errors
///
/// An effect is not defined at the state, or nothing determines the second field.
pub fn set_second_field(system: &System, state: &mut State) -> Result<(), Failure> {
    let (displacements, field) = state.x.split_at_mut(system.dofs.displacements as usize);
    field.fill(0.0);
    if displacements.iter().all(|u| *u == 0.0) {
        return Ok(());
    }
    let Some(mut rows) = SecondField::new(system, state)? else { return Ok(()) };
    let residual = system.restrict(&rows.sums.r);
    rows.add_correction(system, &residual, &mut state.x)
}

/// The rows of the second field at a state.
pub(super) struct SecondField {
    /// Sums of the whole system at the state, with the tangent
    pub sums: Assembled,
    /// Equations of the field, ascending
    equations: Vec<usize>,
    /// Values of C
    compliance: Vec<f64>,
    factor: Factor,
}

impl SecondField {
    /// Evaluates the rows of the second field; `None` if the system has no such field.
    pub fn new(system: &System, state: &State) -> Result<Option<Self>, Failure> {
        let equations: Vec<usize> = (0..system.dofs.free.len()).filter(|&e| system.dofs.is_scalar(e)).collect();
        if equations.is_empty() {
            return Ok(None);
        }
        let mut sums = system.workspace();
        system.assemble(&state.at(), &state.lambda, Want::Tangent, None, &mut sums).map_err(Failure::Eval)?;
        let place = |e: usize| equations.binary_search(&e).ok().map(|place| place as u32);
        let all = sums.pattern.sparse.entries().zip(&sums.k);
        let own: Vec<((u32, u32), f64)> = all.filter_map(|((i, j), k)| Some(((place(i)?, place(j)?), -*k))).collect();
        // Places ascend with the equations, so that the entries of C come in the order of its pattern
        let pattern = SymPattern::from_pairs(equations.len(), own.iter().map(|(entry, _)| *entry));
        let compliance: Vec<f64> = own.iter().map(|(_, value)| *value).collect();
        let mut factor = Factor::new(pattern);
        factor.factorise(&compliance).map_err(Failure::Linear)?;
        Ok(Some(Self { sums, equations, compliance, factor }))
    }

    /// Adds the correction C⁻¹ r to the second field in `x` \[unknowns\], which makes its rows of the residual \[equations\] zero.
    pub fn add_correction(&mut self, system: &System, residual: &[f64], x: &mut [f64]) -> Result<(), Failure> {
        let mut correction: Vec<f64> = self.equations.iter().map(|&e| residual[e]).collect();
        self.factor.solve(&self.compliance, &mut correction).map_err(Failure::Linear)?;
        for (&e, value) in self.equations.iter().zip(&correction) {
            x[system.dofs.free[e] as usize] += value;
        }
        Ok(())
    }
}
