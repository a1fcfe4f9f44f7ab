//! Derivatives of residual and history that K on the free dofs does not hold: by what came before a step, by a constant θ of
//! an effect, and at the prescribed dofs.

use super::{At, Dofs, Effect, EvalError, Local, System, Want};

/// Derivative by a parameter of what an evaluation sees.
#[derive(Clone, Copy)]
pub struct Direction<'a> {
    pub x: &'a [f64],
    /// Of v and a at fixed x: what K has in cv and ca is not in them
    pub v: &'a [f64],
    pub a: &'a [f64],
    pub old: &'a [f64],
    /// As in [`At`]: of the whole state for a system, of its blocks for an effect
    pub history: &'a [f64],
}

/// How an effect that reads more than x depends on it.
pub trait Past: Send + Sync {
    /// The change of r_e along v, a, `old` and the history of `direction`, at fixed x; `direction.x` is not looked at.
    fn along(&self, at: &At, direction: &Direction, b: usize, out: &mut Local) -> Result<(), EvalError>;
    /// The change of the history of block `b` at the end of the step, along x, `old` and the history of `direction`. `new`
    /// comes with the change at the start.
    fn advance_along(&self, _: &At, _: &Direction, _b: usize, _new: &mut [f64]) -> Result<(), EvalError> {
        Ok(())
    }
}

/// ∂/∂θ of one effect of a system at fixed x, v, a, `old` and history.
pub struct Term {
    /// Place of the effect in the system
    pub of: usize,
    /// Its residual is ∂r/∂θ; it sees the history of the effect, and [`Effect::advance`] gives ∂/∂θ of the new one
    pub effect: Box<dyn Effect>,
}

impl System {
    /// Adds the change of the residual along the past of `direction` and by θ, at fixed x, to `r` \[unknowns\].
    pub fn add_change(&self, at: &At, direction: &Direction, terms: &[Term], r: &mut [f64]) -> Result<(), EvalError> {
        let largest = terms.iter().map(|t| t.effect.blocks().largest()).fold(self.largest(), usize::max);
        let mut local = Local::new(largest);
        let mut add = |effect: &dyn Effect, change: &dyn Fn(usize, &mut Local) -> Result<(), EvalError>| {
            let blocks = effect.blocks();
            for b in 0..blocks.len() {
                local.reset(blocks.size(b), Want::Residual);
                change(b, &mut local)?;
                blocks.dofs(b).zip(&local.r).for_each(|(dof, value)| r[dof as usize] += value);
            }
            Ok(())
        };
        for (e, effect) in self.effects.iter().enumerate() {
            if let Some(past) = effect.past() {
                let (at, direction) = self.seen_by(e, at, direction);
                add(&**effect, &|b, local| past.along(&at, &direction, b, local))?;
            }
        }
        for Term { of, effect } in terms {
            let (at, _) = self.seen_by(*of, at, direction);
            add(&**effect, &|b, local| effect.eval(&at, b, Want::Residual, local))?;
        }
        Ok(())
    }

    /// The change of the history along `direction` and by θ into `new`, which comes with the change at the start of the step.
    pub fn advance_change(
        &self,
        at: &At,
        direction: &Direction,
        terms: &[Term],
        new: &mut [f64],
    ) -> Result<(), EvalError> {
        for (e, effect) in self.effects.iter().enumerate().filter(|(_, e)| e.history() > 0) {
            let Some(past) = effect.past() else { continue };
            let (at, direction) = self.seen_by(e, at, direction);
            let terms: Vec<&Term> = terms.iter().filter(|t| t.of == e).collect();
            let mut share = vec![0.0; effect.history()];
            for (b, new) in new[self.histories(e)].chunks_exact_mut(effect.history()).enumerate() {
                past.advance_along(&at, &direction, b, new)?;
                for term in &terms {
                    share.fill(0.0);
                    term.effect.advance(&at, b, &mut share)?;
                    new.iter_mut().zip(&share).for_each(|(new, share)| *new += share);
                }
            }
        }
        Ok(())
    }

    /// With the histories of effect `e` alone.
    fn seen_by<'a>(&self, e: usize, at: &At<'a>, direction: &Direction<'a>) -> (At<'a>, Direction<'a>) {
        let at = At { history: &at.history[self.histories(e)], ..*at };
        (at, Direction { history: &direction.history[self.histories(e)], ..*direction })
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
        let mut local = Local::new(self.largest());
        let fixed = |dof: u32| self.dofs.equation[dof as usize] == Dofs::FIXED;
        for (e, effect) in self.effects.iter().enumerate() {
            let at = &At { history: &at.history[self.histories(e)], ..*at };
            if let Some(means) = effect.means() {
                let eval = |x: &[f64], b: usize, out: &mut Local| effect.eval(&At { x, ..*at }, b, Want::Tangent, out);
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
                let eval = |x: &[f64], b: usize, out: &mut Local| constraint.eval(x, b, Want::Tangent, out);
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
