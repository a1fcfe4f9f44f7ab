//! Derivatives of residual and history at fixed x: with respect to the inputs of the step other than x, and to a parameter θ of an effect.

use super::{At, BlockValues, Blocks, Effect, EvalError, Perturbation, System, Want};

/// The derivative ∂/∂θ of one effect of a system at fixed x, v, a, `old` and history.
pub struct ParameterDerivative {
    /// Index of the effect in the system
    pub of: usize,
    /// Its residual is ∂r/∂θ. It reads the history of the effect, and its [`HistoryVariables::advance`](super::HistoryVariables::advance) gives ∂/∂θ
    /// of the new history
    pub effect: Box<dyn Effect>,
}

/// Adds the change of the residual due to the perturbed inputs, at fixed x, to `r` \[unknowns\].
///
/// Nodes that follow others change with them. Their additional motion at another θ, due to the change of their weights, is part of ∂r/∂θ.
pub fn add_residual_derivative(system: &System, at: &At, by: &Perturbation, r: &mut [f64]) -> Result<(), EvalError> {
    let [v, a, old] = [by.v, by.a, by.old].map(|field| system.ties.completed(field));
    let by = &Perturbation { v: &v, a: &a, old: &old, ..*by };
    for (e, effect) in system.effects.iter().enumerate() {
        if let Some(past) = effect.capabilities().past {
            let (at, by) = (system.inputs_of(e, at), perturbation_of(system, e, by));
            add_blocks(effect.blocks(), r, |b, values| past.along(&at, &by, b, values))?;
        }
    }
    Ok(())
}

/// Computes the change of the history due to the perturbation in `new`, which holds the change at the start of the step on entry.
pub fn add_history_derivative(system: &System, at: &At, by: &Perturbation, new: &mut [f64]) -> Result<(), EvalError> {
    for (e, effect) in system.effects.iter().enumerate() {
        let capabilities = effect.capabilities();
        let (Some(history), Some(past)) = (capabilities.history, capabilities.past) else { continue };
        let (at, by) = (system.inputs_of(e, at), perturbation_of(system, e, by));
        for (b, new) in new[system.history_of(e)].chunks_exact_mut(history.size()).enumerate() {
            past.advance_along(&at, &by, b, new)?;
        }
    }
    Ok(())
}

/// Adds ∂r/∂θ of these terms to `r` \[unknowns\].
pub(super) fn add_residual(
    system: &System,
    at: &At,
    terms: &[ParameterDerivative],
    r: &mut [f64],
) -> Result<(), EvalError> {
    for ParameterDerivative { of, effect } in terms {
        let at = system.inputs_of(*of, at);
        add_blocks(effect.blocks(), r, |b, values| effect.eval(&at, b, Want::Residual, values))?;
    }
    Ok(())
}

/// Adds ∂/∂θ of the history at the end of a step, due to these terms.
pub(super) fn add_history(
    system: &System,
    at: &At,
    terms: &[ParameterDerivative],
    new: &mut [f64],
) -> Result<(), EvalError> {
    for ParameterDerivative { of, effect } in terms {
        let Some(history) = effect.capabilities().history else { continue };
        let at = system.inputs_of(*of, at);
        let mut share = vec![0.0; history.size()];
        for (b, new) in new[system.history_of(*of)].chunks_exact_mut(history.size()).enumerate() {
            share.fill(0.0);
            history.advance(&at, b, &mut share)?;
            new.iter_mut().zip(&share).for_each(|(new, share)| *new += share);
        }
    }
    Ok(())
}

/// Adds r of every block.
fn add_blocks(
    blocks: &Blocks,
    r: &mut [f64],
    eval: impl Fn(usize, &mut BlockValues) -> Result<(), EvalError>,
) -> Result<(), EvalError> {
    let mut values = BlockValues::new(blocks.largest());
    for b in 0..blocks.len() {
        values.reset(blocks.size(b), Want::Residual);
        eval(b, &mut values)?;
        blocks.dofs(b).zip(&values.r).for_each(|(dof, value)| r[dof as usize] += value);
    }
    Ok(())
}

/// The perturbation with only the history of effect `e`.
fn perturbation_of<'a>(system: &System, e: usize, by: &Perturbation<'a>) -> Perturbation<'a> {
    Perturbation { history: &by.history[system.history_of(e)], ..*by }
}
