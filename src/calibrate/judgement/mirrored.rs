//! Constants that may have either sign, and the test that distinguishes the two answers.
//!
//! If λ₂ = 1 and λ₃ = 1/λ, in planar tests and simple shear, a term of Ogden's law has the same stresses with −μ and −α as with μ and α. The fit
//! takes the positive α, and the intervals include both signs. In other modes the two laws differ.

use super::warning::FitWarning;
use crate::calibrate::solve::LawFit;
use crate::calibrate::{FitResult, FittableLaw, Mode};
use crate::material::FitTerms;

/// The constants with the opposite sign if the fitted modes have the same stresses with both, and the indices of those that have a sign.
fn mirror(answer: &LawFit, model: FittableLaw) -> Option<(Vec<f64>, Vec<usize>)> {
    let FitTerms::Separable(family) = &model.form.terms else { return None };
    let one = |pair: &[f64]| [pair[0] * (family.factor)(-pair[1]).0 / (family.factor)(pair[1]).0, -pair[1]];
    let other: Vec<f64> = answer.mirrored.then(|| answer.values.chunks_exact(2).flat_map(one).collect())?;
    // A term that vanished has no sign
    let is_open = |k: &usize| answer.values[*k] != other[*k] && answer.values[k / 2 * 2] != 0.0;
    let open = (0..other.len()).filter(is_open).collect();
    Some((other, open))
}

/// Symbols of the constants that may have either sign.
pub fn either_sign(answer: &LawFit, model: FittableLaw) -> Vec<&'static str> {
    let open = mirror(answer, model).map(|(_, open)| open).unwrap_or_default();
    open.into_iter().map(|k| answer.identified.estimates[k].symbol).collect()
}

/// Widens the intervals of constants whose sign is open to include the opposite sign, and lists these constants.
pub fn open_signs(mut result: FitResult, answer: &LawFit, model: FittableLaw) -> FitResult {
    let Some((other, open)) = mirror(answer, model) else { return result };
    for k in open {
        let both = |[low, high]: [f64; 2]| [low.min(-high), high.max(-low)];
        let e = &mut result.parameters[k];
        e.interval = both(e.interval);
        result.in_use[k] = both(result.in_use[k]);
        result.open_signs.push(e.symbol);
    }
    let decides = decisive(model, &answer.values, &other, &result);
    result.warnings.insert(0, FitWarning::OpenSigns { symbols: result.open_signs.clone(), decides });
    result
}

/// The mode that was not fitted in which the stresses of two answers differ most at the ends of the fitted stretches, and their difference relative
/// to the larger one \[–\].
pub fn decisive(model: FittableLaw, own: &[f64], other: &[f64], result: &FitResult) -> Option<(Mode, f64)> {
    let differ = |mode: Mode, stretch: f64| {
        let [a, b] = [own, other].map(|values| model.stress(values, mode, stretch));
        (a - b).abs() / a.abs().max(b.abs())
    };
    let modes = Mode::PULLED.into_iter().filter(|m| !result.modes.contains(m));
    let of = |mode: Mode| {
        (mode, result.stretch.into_iter().map(|l| differ(mode, l)).filter(|d| d.is_finite()).fold(0.0, f64::max))
    };
    modes.map(of).filter(|(_, most)| *most > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))
}
