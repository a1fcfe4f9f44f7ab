//! Derivatives of residual and history that K on the free dofs does not hold: by what came before a step, by a constant θ of
//! an effect, and at the prescribed dofs.

use super::{At, BlockValues, Dofs, Effect, EvalError, Perturbation, System, Want};

/// ∂/∂θ of one effect of a system at fixed x, v, a, `old` and history.
pub struct ParameterDerivative {
    /// Place of the effect in the system
    pub of: usize,
    /// Its residual is ∂r/∂θ; it sees the history of the effect, and [`HistoryVariables::advance`](super::HistoryVariables::advance) gives ∂/∂θ of the new one
    pub effect: Box<dyn Effect>,
}

impl System {
    /// Adds the change of the residual along the past of `direction` and by θ, at fixed x, to `r` \[unknowns\].
    pub fn add_change(
        &self,
        at: &At,
        direction: &Perturbation,
        terms: &[ParameterDerivative],
        r: &mut [f64],
    ) -> Result<(), EvalError> {
        let largest = terms.iter().map(|t| t.effect.blocks().largest()).fold(self.largest(), usize::max);
        let mut local = BlockValues::new(largest);
        let mut add = |effect: &dyn Effect, change: &dyn Fn(usize, &mut BlockValues) -> Result<(), EvalError>| {
            let blocks = effect.blocks();
            for b in 0..blocks.len() {
                local.reset(blocks.size(b), Want::Residual);
                change(b, &mut local)?;
                blocks.dofs(b).zip(&local.r).for_each(|(dof, value)| r[dof as usize] += value);
            }
            Ok(())
        };
        for (e, effect) in self.effects.iter().enumerate() {
            if let Some(past) = effect.capabilities().past {
                let (at, direction) = self.seen_by(e, at, direction);
                add(&**effect, &|b, local| past.along(&at, &direction, b, local))?;
            }
        }
        for ParameterDerivative { of, effect } in terms {
            let (at, _) = self.seen_by(*of, at, direction);
            add(&**effect, &|b, local| effect.eval(&at, b, Want::Residual, local))?;
        }
        Ok(())
    }

    /// The change of the history along `direction` and by θ into `new`, which comes with the change at the start of the step.
    pub fn advance_change(
        &self,
        at: &At,
        direction: &Perturbation,
        terms: &[ParameterDerivative],
        new: &mut [f64],
    ) -> Result<(), EvalError> {
        for (e, effect) in self.effects.iter().enumerate() {
            let capabilities = effect.capabilities();
            let (Some(history), Some(past)) = (capabilities.history, capabilities.past) else { continue };
            let (at, direction) = self.seen_by(e, at, direction);
            let terms: Vec<&ParameterDerivative> = terms.iter().filter(|t| t.of == e).collect();
            let mut share = vec![0.0; history.size()];
            for (b, new) in new[self.histories(e)].chunks_exact_mut(history.size()).enumerate() {
                past.advance_along(&at, &direction, b, new)?;
                for term in &terms {
                    share.fill(0.0);
                    if let Some(history) = term.effect.capabilities().history {
                        history.advance(&at, b, &mut share)?;
                    }
                    new.iter_mut().zip(&share).for_each(|(new, share)| *new += share);
                }
            }
        }
        Ok(())
    }

    /// With the histories of effect `e` alone.
    fn seen_by<'a>(&self, e: usize, at: &At<'a>, direction: &Perturbation<'a>) -> (At<'a>, Perturbation<'a>) {
        let at = At { history: &at.history[self.histories(e)], ..*at };
        (at, Perturbation { history: &direction.history[self.histories(e)], ..*direction })
    }

    /// Adds (K + A) dx + Σ h dλ at the prescribed dofs, for each (dx, dλ), to its `r` \[unknowns\]: the change of the reactions.
    /// Only blocks with a prescribed dof are evaluated.
    pub fn add_reactions(
        &self,
        at: &At,
        lambda: &[f64],
        changes: &[(&[f64], &[f64])],
        r: &mut [Vec<f64>],
    ) -> Result<(), EvalError> {
        let mut local = BlockValues::new(self.largest());
        let fixed = |dof: u32| self.dofs.equation[dof as usize] == Dofs::FIXED;
        for (e, effect) in self.effects.iter().enumerate() {
            let at = &At { history: &at.history[self.histories(e)], ..*at };
            if let Some(means) = effect.capabilities().means {
                let eval =
                    |x: &[f64], b: usize, out: &mut BlockValues| effect.eval(&At { x, ..*at }, b, Want::Tangent, out);
                let changes: Vec<_> = changes.iter().map(|&(dx, _)| (dx, 0.0)).collect();
                self.add_reactions_by_means((means, effect.blocks()), 1.0, &changes, eval, at.x, r)?;
                continue;
            }
            for b in (0..effect.blocks().len()).filter(|&b| effect.blocks().dofs(b).any(fixed)) {
                let dofs: Vec<u32> = effect.blocks().dofs(b).collect();
                local.reset(dofs.len(), Want::Tangent);
                effect.eval(at, b, Want::Tangent, &mut local)?;
                for (&(dx, _), r) in changes.iter().zip(&mut *r) {
                    local.add_product(&dofs, fixed, 1.0, dx, r);
                }
            }
        }
        self.each_skew(at, |i, j, a| {
            for (&(dx, _), r) in changes.iter().zip(&mut *r) {
                for (to, value) in [(i, a * dx[j as usize]), (j, -a * dx[i as usize])] {
                    r[to as usize] += if fixed(to) { value } else { 0.0 };
                }
            }
        });
        for (c, constraint) in self.constraints.iter().enumerate() {
            if let Some(means) = constraint.means() {
                let eval = |x: &[f64], b: usize, out: &mut BlockValues| constraint.eval(x, b, Want::Tangent, out);
                let changes: Vec<_> = changes.iter().map(|&(dx, dlambda)| (dx, dlambda[c])).collect();
                self.add_reactions_by_means((means, constraint.blocks()), lambda[c], &changes, eval, at.x, r)?;
                continue;
            }
            for b in (0..constraint.blocks().len()).filter(|&b| constraint.blocks().dofs(b).any(fixed)) {
                let dofs: Vec<u32> = constraint.blocks().dofs(b).collect();
                local.reset(dofs.len(), Want::Tangent);
                constraint.eval(at.x, b, Want::Tangent, &mut local)?;
                for (&(dx, dlambda), r) in changes.iter().zip(&mut *r) {
                    local.add_product(&dofs, fixed, lambda[c], dx, r);
                    let rows = dofs.iter().zip(&local.r).filter(|(dof, _)| fixed(**dof));
                    rows.for_each(|(&dof, h)| r[dof as usize] += h * dlambda[c]);
                }
            }
        }
        Ok(())
    }
}
