//! Intervals by profile likelihood, for laws that are not linear in their constants: the range of one constant while all others are refitted.
//!
//! S(θⱼ) = min over the other constants of Σ wᵢ²rᵢ²; the interval is S(θⱼ) − Ŝ ≤ (t dⱼ)²/((JᵀJ)⁻¹)ⱼⱼ with t = t₀.₉₇₅ and the standard error dⱼ of the
//! error model. For a law linear in its constants it is θⱼ ± t dⱼ; for independent errors it is S(θⱼ) ≤ Ŝ(1 + t²/(n − p)). For other errors the
//! profile is scaled to their standard error (Chandler & Bate, Biometrika 94, 2007, 167–183).
//!
//! Source: Bates & Watts, *Nonlinear Regression Analysis*, 1988, ch. 6. The interval may be asymmetric, as the data are, and is open if a constant
//! may grow without bound. The minimum is followed from the answer outwards by Levenberg–Marquardt; √(S − Ŝ) is almost linear in θⱼ, so that the
//! secant method finds the end. Strain offsets are refitted like constants.
//!
//! Several minima may lie within the interval: in one mode, a term of Ogden's law with α and one with about −2α (uniaxial) are nearly equal. The
//! interval reaches from the lowest to the highest end of the intervals around all minima that the search for the constants found; S between them may
//! be larger.
//!
//! A term whose factor vanished may have any shape, and both of its constants are open. In the profile of another term it takes the shape of that
//! term, so that the two can share the load. Limits: no further minima are sought.

use crate::calibrate::Sample;
use crate::calibrate::solve::refit::Refit;
use crate::calibrate::solve::{LawFit, LawSetting, ROUNDING};
use crate::material::FitTerms;
use crate::math::{statistics, threads};

/// Number of widths of the covariance interval beyond which an end counts as open
const FAR: f64 = 1e3;
/// Relative deviation from the limit at which the end counts as found \[–\]
const CLOSE: f64 = 1e-6;
const STEPS: usize = 40;

struct Profile<'a> {
    of: Refit<'a>,
    /// Constants at a minimum, followed by strain offsets
    minimum: Vec<f64>,
    /// S of the answer \[weighted Pa²\]
    least: f64,
}

/// Both ends for each constant \[SI\], infinite if open; `None` for a linear law, without a degree of freedom, or if the data points agree with the
/// law to rounding.
pub fn intervals(setting: &LawSetting, samples: &[Sample], answer: &LawFit) -> Option<Vec<[f64; 2]>> {
    let all = |values: &[f64]| {
        let offsets = setting.slack.iter().map(|o| o.strain);
        values.iter().copied().chain(offsets).collect::<Vec<f64>>()
    };
    samples.len().checked_sub(all(&answer.values).len()).filter(|n| *n > 0)?;
    matches!(setting.model.form.terms, FitTerms::Separable(_)).then_some(())?;
    let of = Refit { model: setting.model, slack: &setting.slack, samples, weight: &answer.weight };
    let around = |values, least| Profile { of, minimum: all(values), least };
    let least = of.square(&all(&answer.values))?;
    let size: f64 = samples.iter().zip(&answer.weight).map(|(s, w)| (w * s.stress).powi(2)).sum();
    if least <= ROUNDING * ROUNDING * size {
        return None;
    }
    let minima: Vec<Profile> =
        std::iter::once(&answer.values).chain(&answer.others).map(|values| around(values, least)).collect();
    let t = statistics::t_quantile(0.95, answer.errors.free);
    let one = |(j, e): (usize, &super::estimate::Estimate)| {
        let limit = t * e.std_error / answer.errors.plain[j];
        let ends = minima.iter().filter_map(|profile| match e.std_error.is_finite() && !profile.vanished(j) {
            true => profile.ends(j, t * e.std_error, limit),
            false => Some([f64::NEG_INFINITY, f64::INFINITY]),
        });
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, own| [all[0].min(own[0]), all[1].max(own[1])])
    };
    Some(threads::map(answer.identified.estimates.iter().enumerate().collect(), one))
}

impl Profile<'_> {
    /// Whether the constant belongs to a term with a factor of zero.
    fn vanished(&self, k: usize) -> bool {
        k < self.of.model.parameters().len() && self.minimum[k / 2 * 2] == 0.0
    }

    /// The minimum, with vanished terms given the shape of the term of constant j.
    fn shared(&self, j: usize) -> Vec<f64> {
        let mut x = self.minimum.clone();
        let constants = self.of.model.parameters().len();
        if j < constants {
            let shape = x[j / 2 * 2 + 1];
            (0..constants).filter(|k| k % 2 == 1 && self.vanished(*k)).for_each(|k| x[k] = shape);
        }
        x
    }

    /// Both ends around this minimum; `None` if its misfit is above the limit.
    fn ends(&self, j: usize, width: f64, limit: f64) -> Option<[f64; 2]> {
        let tau = statistics::root(self.of.square(&self.minimum)? - self.least);
        (tau <= limit).then(|| [-width, width].map(|width| self.end(j, width, tau, limit)))
    }

    /// The end of the interval of constant j in the direction of `width`, where √(S − Ŝ) reaches `limit`; `tau`: its value at the minimum.
    fn end(&self, j: usize, width: f64, tau: f64, limit: f64) -> f64 {
        let value = self.minimum[j];
        // Offset, √(S − Ŝ) and the constants at the last point inside
        let mut inside = (0.0, tau, self.shared(j));
        let mut step = 0.5;
        let mut outside = loop {
            match self.at(j, step * width, &inside.2) {
                Some((tau, x)) if tau <= limit => inside = (step, tau, x),
                Some((tau, _)) => break (step, Some(tau)),
                None => break (step, None),
            }
            step = if step < 1.0 { 1.0 } else { 1.4 * step };
            if step > FAR {
                return f64::INFINITY.copysign(width);
            }
        };
        for _ in 0..STEPS {
            // If the law is not defined beyond, there is no secant
            let part = outside.1.map_or(0.5, |tau| ((limit - inside.1) / (tau - inside.1)).clamp(0.01, 0.99));
            let middle = inside.0 + part * (outside.0 - inside.0);
            match self.at(j, middle * width, &inside.2) {
                Some((tau, x)) if tau <= limit => inside = (middle, tau, x),
                Some((tau, _)) => outside = (middle, Some(tau)),
                None => outside = (middle, None),
            }
            let close = |tau: f64| (tau - limit).abs() <= CLOSE * limit;
            if close(inside.1) || outside.0 - inside.0 <= CLOSE * outside.0 {
                break;
            }
            if outside.1.is_some_and(close) {
                return value + outside.0 * width;
            }
        }
        value + inside.0 * width
    }

    /// √(S − Ŝ) with constant j changed by `offset` from the minimum, the others found from `start`.
    fn at(&self, j: usize, offset: f64, start: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut x = start.to_vec();
        x[j] = self.minimum[j] + offset;
        let others: Vec<usize> = (0..x.len()).filter(|k| *k != j).collect();
        let (x, square) = self.of.refitted(x, &others)?;
        Some((statistics::root(square - self.least), x))
    }
}
