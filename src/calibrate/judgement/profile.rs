//! Intervals by profile likelihood, of laws that are not linear in their constants: the range of one constant while all others are refitted.
//!
//! S(θⱼ) = min over the other constants of Σ wᵢ²rᵢ²; the interval is S(θⱼ) − Ŝ ≤ (t dⱼ)²/((JᵀJ)⁻¹)ⱼⱼ with t = t₀.₉₇₅ and the standard error dⱼ of
//! the error model. Of a law linear in its constants it is θⱼ ± t dⱼ; of independent errors it is S(θⱼ) ≤ Ŝ(1 + t²/(n − p)). With other errors it is the
//! profile scaled to their standard error (Chandler & Bate, Biometrika 94, 2007, 167–183).
//!
//! Source: Bates & Watts, *Nonlinear Regression Analysis*, 1988, ch. 6. The interval is skewed as the data are, and open where a constant may
//! grow without end. The minimum is followed from the answer outwards by Levenberg–Marquardt; √(S − Ŝ) is almost straight in θⱼ, so that a
//! secant finds the end. Offsets of the strain are refitted as constants are.
//!
//! Several minima may lie within the interval: of one mode, a term of Ogden's law with α and one with about −2α (uniaxial) are nearly
//! alike. It reaches from the lowest to the highest end of the intervals around all minima that the search of the constants found; S between them may be
//! larger.
//!
//! Terms whose factor vanished stay away, and both of their constants are open. Limits: minima that the search did not find are not looked for.

use super::misfit::sum_of_squares;
use crate::calibrate::solve::offset::Offset;
use crate::calibrate::solve::{LawFit, LawSetting, ROUNDING};
use crate::calibrate::{Model, Sample};
use crate::material::FitTerms;
use crate::math::statistics;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Widths of the covariance interval after which an end is open
const FAR: f64 = 1e3;
/// Part of T at which the end is found \[–\]
const CLOSE: f64 = 1e-6;
const STEPS: usize = 40;

struct Profile<'a> {
    setting: &'a LawSetting,
    model: Model,
    samples: &'a [Sample],
    weight: &'a [f64],
    /// Constants of a minimum, then strain offsets
    minimum: Vec<f64>,
    /// S of the answer \[weighted Pa²\]
    least: f64,
}

/// Both ends per constant \[SI\], infinite where open; `None` of a linear law, where no degree of freedom is left, or where the data points agree with
/// the law to rounding.
pub fn intervals(setting: &LawSetting, samples: &[Sample], answer: &LawFit) -> Option<Vec<[f64; 2]>> {
    let all = |values: &[f64]| {
        let offsets = setting.slack.iter().map(|o| o.strain);
        values.iter().copied().chain(offsets).collect::<Vec<f64>>()
    };
    samples.len().checked_sub(all(&answer.values).len()).filter(|n| *n > 0)?;
    matches!(setting.model.form.terms, FitTerms::Separable(_)).then_some(())?;
    let around = |values, least| Profile {
        setting,
        model: setting.model,
        samples,
        weight: &answer.weight,
        minimum: all(values),
        least,
    };
    let own = around(&answer.values, 0.0);
    let least = own.square(&own.minimum)?;
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
    Some(answer.identified.estimates.par_iter().enumerate().map(one).collect())
}

impl Profile<'_> {
    /// Constants of a term with a factor of zero
    fn vanished(&self, k: usize) -> bool {
        k < self.model.parameters().len() && self.minimum[k / 2 * 2] == 0.0
    }

    fn constants<'b>(&self, values: &'b [f64]) -> &'b [f64] {
        &values[..self.model.parameters().len()]
    }

    /// The data point with the strain offsets of these values.
    fn moved(&self, values: &[f64], s: &Sample) -> Sample {
        let pairs = self.setting.slack.iter().zip(&values[self.model.parameters().len()..]);
        let by = |(o, v): (&Offset, &f64)| o.shifted(s, v - o.strain);
        // A data point inside the slack stays there
        pairs.filter(|(o, v)| o.is_of(s) && s.stretch != 1.0 && **v != o.strain).map(by).next().unwrap_or(*s)
    }

    /// P \[Pa\]
    fn law(&self, values: &[f64], s: &Sample) -> f64 {
        self.model.at(self.constants(values), &self.moved(values, s))
    }

    /// ∂P/∂ constants and offsets
    fn slopes(&self, values: &[f64], s: &Sample) -> Vec<f64> {
        let (own, s) = (self.constants(values), self.moved(values, s));
        let offsets = self.setting.slack.iter().map(|o| o.slope(self.model, own, &s));
        self.model.sensitivities(own, &s).into_iter().chain(offsets).collect()
    }

    /// S; `None` where the law is not defined or a factor is negative.
    fn square(&self, values: &[f64]) -> Option<f64> {
        let sum = sum_of_squares(self.samples, self.weight, |s| self.law(values, s));
        let admitted = match &self.model.form.terms {
            FitTerms::Linear(_) => true,
            FitTerms::Separable(f) => self.constants(values).chunks_exact(2).all(|v| v[0] / (f.factor)(v[1]).0 >= 0.0),
        };
        (admitted && sum.is_finite()).then_some(sum)
    }

    /// Both ends around this minimum; `None` where its misfit is above the limit.
    fn ends(&self, j: usize, width: f64, limit: f64) -> Option<[f64; 2]> {
        let tau = (self.square(&self.minimum)? - self.least).max(0.0).sqrt();
        (tau <= limit).then(|| [-width, width].map(|width| self.end(j, width, tau, limit)))
    }

    /// The end of the interval of constant j in the direction of `width`, where √(S − Ŝ) is `limit`; `tau` at the minimum.
    fn end(&self, j: usize, width: f64, tau: f64, limit: f64) -> f64 {
        let value = self.minimum[j];
        // Offset, √(S − Ŝ) and the constants there
        let mut inside = (0.0, tau, self.minimum.clone());
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
            // Where the law ends beyond, there is no secant
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

    /// √(S − Ŝ) with constant j off the minimum by this much, the others found from `start`.
    fn at(&self, j: usize, offset: f64, start: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut x = start.to_vec();
        x[j] = self.minimum[j] + offset;
        let mut square = self.square(&x)?;
        let others: Vec<usize> = (0..x.len()).filter(|k| *k != j && !self.vanished(*k)).collect();
        let mut damping = 1e-9;
        for _ in 0..60 {
            if others.is_empty() {
                break;
            }
            let Some((next, lower)) = self.step(&x, &others, square, &mut damping) else { break };
            let still = lower > square * (1.0 - 1e-9);
            (x, square) = (next, lower);
            if still {
                break;
            }
        }
        Some(((square - self.least).max(0.0).sqrt(), x))
    }

    /// A step of Levenberg–Marquardt in some constants that lowers S; factors stop at zero.
    fn step(&self, x: &[f64], others: &[usize], square: f64, damping: &mut f64) -> Option<(Vec<f64>, f64)> {
        let scale: Vec<f64> = others.iter().map(|k| if x[*k] == 0.0 { 1.0 } else { x[*k].abs() }).collect();
        let rows = self.samples.iter().zip(self.weight);
        let entries: Vec<f64> = rows
            .clone()
            .flat_map(|(s, w)| {
                let all = self.slopes(x, s);
                others.iter().zip(&scale).map(|(k, z)| w * z * all[*k]).collect::<Vec<_>>()
            })
            .collect();
        let jacobian = DMatrix::from_row_slice(self.samples.len(), others.len(), &entries);
        let residual = rows.map(|(s, w)| w * (s.stress - self.law(x, s)));
        let residual = DVector::from_iterator(self.samples.len(), residual);
        let (normal, slope) = (jacobian.transpose() * &jacobian, jacobian.transpose() * residual);
        let largest = normal.diagonal().max();
        for _ in 0..20 {
            let mut a = normal.clone();
            for k in 0..others.len() {
                a[(k, k)] += *damping * normal[(k, k)].max(1e-12 * largest);
            }
            let mut next = x.to_vec();
            if let Some(inverse) = a.cholesky() {
                let change = inverse.solve(&slope);
                others.iter().zip(&scale).zip(change.iter()).for_each(|((k, z), d)| next[*k] += z * d);
                self.stop_at_zero(&mut next, others);
                if let Some(lower) = self.square(&next).filter(|s| *s < square) {
                    *damping = (0.1 * *damping).max(1e-12);
                    return Some((next, lower));
                }
            }
            *damping = 10.0 * damping.max(1e-9);
        }
        None
    }

    fn stop_at_zero(&self, values: &mut [f64], others: &[usize]) {
        if let FitTerms::Separable(f) = &self.model.form.terms {
            let own = self.model.parameters().len();
            for k in others.iter().filter(|k| **k < own && **k % 2 == 0) {
                if values[*k] / (f.factor)(values[k + 1]).0 < 0.0 {
                    values[*k] = 0.0;
                }
            }
        }
    }
}
