//! One fit of one law to some samples: weights, solver, intervals.

use super::Model;
use super::identify::{self, Identified};
use super::linear::{self, Points};
use super::noise;
use super::noise::ModeNoise;
use super::rows::Rows;
use super::{FitError, Loss, Sample, SolverCheck, Weighting, separable, statistics};
use crate::material::FitTerms;
use nalgebra::{DMatrix, DVector};

/// Settings that are the same in all fits of a request.
#[derive(Clone, Debug)]
pub struct LawSetting {
    pub model: Model,
    pub weighting: Weighting,
    /// Standard deviation of the stress by mode \[Pa\], where the weights ask for it
    pub noise: Vec<ModeNoise>,
    pub loss: Loss,
    /// Largest I₁ − 3 of the table \[–\]
    pub reach: f64,
    /// Where a linear law is kept stable
    pub stable: Points,
}

/// An answer with its intervals and checks.
#[derive(Clone, Debug)]
pub struct LawFit {
    /// Values of the constants \[SI\]
    pub values: Vec<f64>,
    pub identified: Identified,
    /// `None` where a single solver was enough (fits of parts of the data)
    pub check: Option<SolverCheck>,
    /// Points at which the stability constraint is active
    pub active: Points,
    /// Two-sided p-value of a departure of the data from the law \[–\]; `None` with too few data points or data that agree with
    /// the law to rounding
    pub departure_p: Option<f64>,
    /// Neo-Hookean modulus of the same data \[Pa\], a measure of size
    pub modulus: f64,
    /// w of each sample, with Huber's loss in it
    pub weight: Vec<f64>,
    /// Where a separable search ended
    at: Vec<f64>,
}

/// Below this misfit ‖r‖/‖P‖ the residuals are rounding and their pattern means nothing \[–\]
pub const ROUNDING: f64 = 1e-9;
/// Huber's constant: 95 % efficiency for normal errors \[–\]
const HUBER: f64 = 1.345;
/// Reweighted fits at most, and the change of a weight that ends them
const REWEIGHTED: usize = 60;
const SETTLED: f64 = 1e-6;

/// `near`: the answer to nearly the same samples; then one solver and one start are enough.
pub fn solve(setting: &LawSetting, samples: &[Sample], near: Option<&LawFit>) -> Result<LawFit, FitError> {
    judge(setting, samples, constants(setting, samples, near)?)
}

/// The same without intervals.
pub fn constants(setting: &LawSetting, samples: &[Sample], near: Option<&LawFit>) -> Result<LawFit, FitError> {
    let base = noise::weights(samples, setting.weighting, &setting.noise)?;
    let mut found = weighted(setting, samples, &base, near)?;
    let mut weight = base.clone();
    if setting.loss == Loss::Huber {
        for _ in 0..REWEIGHTED {
            let next = huber(setting, samples, &base, &found.values);
            let change = next.iter().zip(&weight).zip(&base).map(|((a, b), c)| ((a - b) / c).abs()).fold(0.0, f64::max);
            weight = next;
            if change < SETTLED {
                break;
            }
            found = weighted(setting, samples, &weight, Some(&found))?;
        }
        found.check = weighted(setting, samples, &weight, near)?.check;
    }
    found.weight = weight;
    Ok(found)
}

/// √ of Huber's weights min(1, kσ/|r|) times the base weight, σ = 1.4826 median |r| (Huber, Robust Statistics, 1981, ch. 7).
fn huber(setting: &LawSetting, samples: &[Sample], base: &[f64], values: &[f64]) -> Vec<f64> {
    let off = |(s, w): (&Sample, &f64)| (w * (s.stress - setting.model.at(values, s))).abs();
    let r: Vec<f64> = samples.iter().zip(base).map(off).collect();
    let size = samples.iter().zip(base).map(|(s, w)| (w * s.stress).powi(2)).sum::<f64>() / samples.len() as f64;
    let limit = (HUBER * 1.4826 * median(&r)).max(ROUNDING * size.sqrt());
    r.iter().zip(base).map(|(r, w)| w * (limit / r).min(1.0).sqrt()).collect()
}

pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    0.5 * (sorted[(n - 1) / 2] + sorted[n / 2])
}

/// The constants with these weights.
fn weighted(
    setting: &LawSetting,
    samples: &[Sample],
    weight: &[f64],
    near: Option<&LawFit>,
) -> Result<LawFit, FitError> {
    let rows = Rows::new(samples, weight)?;
    let bare = |values, check, active, at| LawFit {
        values,
        identified: Identified::default(),
        check,
        active,
        departure_p: None,
        modulus: rows.unit,
        weight: weight.to_vec(),
        at,
    };
    match &setting.model.form.terms {
        FitTerms::Linear(derivatives) => {
            let found = linear::solve(*derivatives, setting.model.terms, &rows, &setting.stable, near.is_none())?;
            Ok(bare(found.values, found.check, found.active, vec![]))
        }
        FitTerms::Separable(family) => {
            let warm = near.map(|n| n.at.as_slice());
            let found = separable::solve(family, setting.model.terms, &rows, setting.reach, warm)?;
            // + 0: a factor that vanished has no sign
            let factor = |(c, theta): (&f64, &f64)| [c * (family.factor)(*theta).0 + 0.0, *theta];
            let values = found.factors.iter().zip(&found.shapes).flat_map(factor).collect();
            Ok(bare(values, near.is_none().then_some(found.check), vec![], found.at))
        }
    }
}

fn judge(setting: &LawSetting, samples: &[Sample], mut found: LawFit) -> Result<LawFit, FitError> {
    let (model, weight) = (setting.model, found.weight.clone());
    let p: Vec<f64> = samples.iter().map(|s| model.at(&found.values, s)).collect();
    let zip = || samples.iter().zip(&weight).zip(&p);
    let residual = DVector::from_iterator(samples.len(), zip().map(|((s, w), p)| w * (s.stress - p)));
    let size = zip().map(|((s, w), _)| (w * s.stress).powi(2)).sum::<f64>().sqrt();
    let sensitivities: Vec<f64> = (samples.iter().zip(&weight))
        .flat_map(|(s, w)| model.sensitivities(&found.values, s).into_iter().map(move |v| w * v))
        .collect();
    let jacobian = DMatrix::from_row_slice(samples.len(), found.values.len(), &sensitivities);
    found.identified = identify::identify(model.parameters(), &found.values, &jacobian, &residual, size, 0.0);
    if residual.norm() > ROUNDING * size {
        let second = DVector::from_iterator(samples.len(), zip().map(|((s, w), p)| w * p / s.stretch));
        found.departure_p = departure(&jacobian, &second, &residual);
    }
    Ok(found)
}

/// p-value of β = 0 in P = P(λ) + β P(λ)/λ (of a Neo-Hookean law in uniaxial tension β is Mooney's second constant): a t-test with
/// one degree of freedom less than the fit, on the part of P/λ that the constants of the law cannot make.
fn departure(jacobian: &DMatrix<f64>, second: &DVector<f64>, residual: &DVector<f64>) -> Option<f64> {
    let free = residual.len().checked_sub(jacobian.ncols() + 1).filter(|n| *n >= 1)?;
    let across = identify::across(jacobian, second);
    let across2 = across.norm_squared();
    if across2 <= 1e-16 * second.norm_squared() {
        return None;
    }
    let r2 = residual.norm_squared();
    let explained = across.dot(residual).powi(2) / across2;
    let left = (r2 - explained).max(f64::EPSILON * r2);
    let t = (explained / (left / free as f64)).sqrt();
    Some((1.0 - statistics::t_probability(t, free)).max(0.0))
}
