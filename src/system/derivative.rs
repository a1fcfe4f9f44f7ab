//! Parts of the derivative of an equilibrium that K on the free dofs does not hold: ∂r/∂θ, and the reactions.

use super::{At, Dofs, Effect, EvalError, Local, System, Want};

impl System {
    /// Adds the residual of an effect that is no part of the system, on its unknowns, to `r` [unknowns].
    pub fn add_residual(&self, effect: &dyn Effect, at: &At, r: &mut [f64]) -> Result<(), EvalError> {
        let blocks = effect.blocks();
        let mut local = Local::new(blocks.largest());
        for b in 0..blocks.len() {
            local.reset(blocks.size(b), Want::Residual);
            effect.eval(at, b, Want::Residual, &mut local)?;
            blocks.dofs(b).zip(&local.r).for_each(|(dof, value)| r[dof as usize] += value);
        }
        Ok(())
    }

    /// Adds K dx + Σ h dλ at the prescribed dofs, for each (dx, dλ), to its `r` [unknowns]: the change of the reactions.
    /// Only blocks with a prescribed dof are evaluated.
    pub fn add_reactions(
        &self,
        at: &At,
        lambda: &[f64],
        changes: &[(&[f64], &[f64])],
        r: &mut [Vec<f64>],
    ) -> Result<(), EvalError> {
        let mut local = Local::new(self.largest());
        let fixed = |dof: u32| self.dofs.equation[dof as usize] == Dofs::FIXED;
        for (e, effect) in self.effects.iter().enumerate() {
            let at = &At { history: &at.history[self.histories(e)], ..*at };
            for b in (0..effect.blocks().len()).filter(|&b| effect.blocks().dofs(b).any(fixed)) {
                let dofs: Vec<u32> = effect.blocks().dofs(b).collect();
                local.reset(dofs.len(), Want::Tangent);
                effect.eval(at, b, Want::Tangent, &mut local)?;
                for (&(dx, _), r) in changes.iter().zip(&mut *r) {
                    add_product(&local, &dofs, fixed, 1.0, dx, r);
                }
            }
        }
        for (c, constraint) in self.constraints.iter().enumerate() {
            for b in (0..constraint.blocks().len()).filter(|&b| constraint.blocks().dofs(b).any(fixed)) {
                let dofs: Vec<u32> = constraint.blocks().dofs(b).collect();
                local.reset(dofs.len(), Want::Tangent);
                constraint.eval(at.x, b, Want::Tangent, &mut local)?;
                for (&(dx, dlambda), r) in changes.iter().zip(&mut *r) {
                    add_product(&local, &dofs, fixed, lambda[c], dx, r);
                    let rows = dofs.iter().zip(&local.r).filter(|(dof, _)| fixed(**dof));
                    rows.for_each(|(&dof, h)| r[dof as usize] += h * dlambda[c]);
                }
            }
        }
        Ok(())
    }
}

/// r += factor K_e dx on the chosen rows.
fn add_product(local: &Local, dofs: &[u32], row: impl Fn(u32) -> bool, factor: f64, dx: &[f64], r: &mut [f64]) {
    let n = dofs.len();
    for (i, &to) in dofs.iter().enumerate().filter(|(_, to)| row(**to)) {
        let entry = |(j, from): (usize, &u32)| local.k[i.max(j) * n + i.min(j)] * dx[*from as usize];
        r[to as usize] += factor * dofs.iter().enumerate().map(entry).sum::<f64>();
    }
}
