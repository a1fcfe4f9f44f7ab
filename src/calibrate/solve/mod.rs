//! One fit of one law to some samples: weights, solver, intervals.

pub(super) mod linear;
pub(super) mod noise;
pub(super) mod nonnegative;
pub(super) mod offset;
pub(super) mod rows;
pub(super) mod separable;
pub(super) mod solver_check;

use self::solver_check::SolverCheck;
use crate::calibrate::Model;
use crate::calibrate::judgement::errors::{self, Errors};
use crate::calibrate::judgement::identify::{self, Identified};
use crate::calibrate::judgement::repeats::Repeats;
use crate::calibrate::judgement::statistics::median;
use crate::calibrate::{Estimate, FitError, Loss, Sample, Weighting, judgement::statistics};
use crate::material::FitTerms;
use crate::material::principal::invariants;
use linear::Points;
use nalgebra::{DMatrix, DVector};
use noise::ModeNoise;
use offset::{OFFSET, Offset};
use rows::Rows;
use separable::Minimum;

/// Settings that are the same in all fits of a request.
#[derive(Clone, Debug)]
pub struct LawSetting {
    pub model: Model,
    pub weighting: Weighting,
    /// Standard deviation of the stress by mode \[Pa\], where the weights ask for it
    pub noise: Vec<ModeNoise>,
    pub loss: Loss,
    /// Where a linear law is kept stable
    pub stable: Points,
    /// Strain offsets that are unknowns; the samples are those without them
    pub slack: Vec<Offset>,
}

impl LawSetting {
    /// The same with the strain offsets of these samples alone.
    pub fn of(&self, samples: &[Sample]) -> Self {
        let slack = self.slack.iter().filter(|o| samples.iter().any(|s| o.is_of(s))).copied().collect();
        Self { slack, ..self.clone() }
    }
}

/// An answer with its intervals and checks.
#[derive(Clone, Debug)]
pub struct LawFit {
    /// Values of the constants \[SI\]
    pub values: Vec<f64>,
    pub identified: Identified,
    /// Of the strain, one for each of the setting
    pub offsets: Vec<Estimate>,
    pub errors: Errors,
    /// `None` where a single solver was enough (fits of parts of the data)
    pub check: Option<SolverCheck>,
    /// Points at which least squares alone would give an unstable law; empty where the stability constraint is not active
    pub active: Points,
    pub pattern: Pattern,
    /// Neo-Hookean modulus of the same data \[Pa\], a measure of size
    pub modulus: f64,
    /// w of each sample, with Huber's loss in it
    pub weight: Vec<f64>,
    /// √ of Huber's weight of each sample, 1 of least squares
    pub share: Vec<f64>,
    /// Where a separable search ended
    pub at: Vec<f64>,
    /// Values at other minima of a separable search whose misfit the errors of the data points allow \[SI\]
    pub others: Vec<Vec<f64>>,
}

/// Tests of the residuals for a pattern that the error model does not explain.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pattern {
    /// Runs of sign, after the correlation of neighbours is taken out
    pub runs: Option<usize>,
    /// Probability of as few of them or fewer \[–\]
    pub runs_p: Option<f64>,
    /// Two-sided p-value of β = 0 in P = P(λ) + β P(λ)/λ \[–\]; `None` with too few data points
    pub departure_p: Option<f64>,
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
    judge(setting, samples, constants(setting, samples, near)?, true)
}

/// The same without tests of the residuals.
pub fn solve_untested(setting: &LawSetting, samples: &[Sample], near: &LawFit) -> Result<LawFit, FitError> {
    judge(setting, samples, constants(setting, samples, Some(near))?, false)
}

/// The same without intervals. Relative weights and Huber's follow from the law, and the fit is repeated until they settle.
pub fn constants(setting: &LawSetting, samples: &[Sample], near: Option<&LawFit>) -> Result<LawFit, FitError> {
    let base = |stress: &[f64]| {
        let mut weights = noise::weights(samples, stress, setting.weighting, &setting.noise)?;
        noise::share(&mut weights, samples);
        Ok::<_, FitError>(weights)
    };
    let law = |found: &LawFit| samples.iter().map(|s| setting.model.at(&found.values, s)).collect::<Vec<f64>>();
    let measured: Vec<f64> = samples.iter().map(|s| s.stress).collect();
    let (huber, relative) = (setting.loss == Loss::Huber, setting.weighting == Weighting::Relative);
    let mut weight = base(&measured)?;
    let mut share = vec![1.0; samples.len()];
    let mut found = weighted(setting, samples, &weight, near)?;
    if huber || relative {
        for _ in 0..REWEIGHTED {
            let stress = law(&found);
            let own = base(if relative { &stress } else { &measured })?;
            share = if huber { shares(samples, &own, &stress) } else { share };
            let next: Vec<f64> = own.iter().zip(&share).map(|(w, s)| w * s).collect();
            let change = next.iter().zip(&weight).zip(&own).map(|((a, b), c)| ((a - b) / c).abs()).fold(0.0, f64::max);
            weight = next;
            if change < SETTLED {
                break;
            }
            found = weighted(setting, samples, &weight, Some(&found))?;
        }
        let again = weighted(setting, samples, &weight, near)?;
        (found.check, found.others) = (again.check, again.others);
    }
    (found.weight, found.share) = (weight, share);
    Ok(found)
}

/// √ of Huber's weights, with the weights before them and the stresses of the law.
fn shares(samples: &[Sample], base: &[f64], law: &[f64]) -> Vec<f64> {
    let off = |((s, w), p): ((&Sample, &f64), &f64)| (w * (s.stress - p)).abs();
    let r: Vec<f64> = samples.iter().zip(base).zip(law).map(off).collect();
    let size = samples.iter().zip(base).map(|(s, w)| (w * s.stress).powi(2)).sum::<f64>().sqrt();
    huber_share(&r, size)
}

/// √ of Huber's weights min(1, kσ/|r|), σ = 1.4826 median |r| (Huber, Robust Statistics, 1981, ch. 7), of weighted |r| of data points with the norm
/// `size`.
pub fn huber_share(r: &[f64], size: f64) -> Vec<f64> {
    let limit = (HUBER * 1.4826 * median(r)).max(ROUNDING * size / (r.len() as f64).sqrt());
    r.iter().map(|r| (limit / r).min(1.0).sqrt()).collect()
}

/// The constants with these weights.
fn weighted(
    setting: &LawSetting,
    samples: &[Sample],
    weight: &[f64],
    near: Option<&LawFit>,
) -> Result<LawFit, FitError> {
    let rows = Rows::new(samples, weight, setting.model.nu)?;
    let bare = |values, check, active, at| LawFit {
        values,
        identified: Identified::default(),
        check,
        active,
        offsets: vec![],
        errors: Errors::default(),
        pattern: Pattern::default(),
        modulus: rows.unit,
        weight: weight.to_vec(),
        share: vec![1.0; samples.len()],
        at,
        others: vec![],
    };
    match &setting.model.form.terms {
        FitTerms::Linear(derivatives) => {
            let found = linear::solve(*derivatives, setting.model.terms, &rows, &setting.stable, near.is_none())?;
            Ok(bare(found.values, found.check, found.active, vec![]))
        }
        FitTerms::Separable(family) => {
            let warm = near.map(|n| n.at.as_slice());
            let reach = samples.iter().map(|s| invariants(s.stretches(setting.model.nu)).0).fold(0.0, f64::max);
            let found = separable::solve(family, setting.model.terms, &rows, reach, warm)?;
            // + 0: a factor that vanished has no sign
            let factor = |(c, theta): (&f64, &f64)| [c * (family.factor)(*theta).0 + 0.0, *theta];
            let values = |m: &Minimum| m.factors.iter().zip(&m.shapes).flat_map(factor).collect();
            let others = found.others.iter().map(values).collect();
            let check = near.is_none().then_some(found.check);
            Ok(LawFit { others, ..bare(values(&found.least), check, vec![], found.least.at) })
        }
    }
}

/// w ∂P/∂(constants, offsets), (n, p + q).
pub fn jacobian(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> DMatrix<f64> {
    let row = |(s, w): (&Sample, &f64)| {
        let offsets = setting.slack.iter().map(|o| o.slope(setting.model, &found.values, s));
        let all = setting.model.sensitivities(&found.values, s).into_iter().chain(offsets);
        all.map(|v| w * v).collect::<Vec<f64>>()
    };
    let entries: Vec<f64> = samples.iter().zip(&found.weight).flat_map(row).collect();
    DMatrix::from_row_slice(samples.len(), found.values.len() + setting.slack.len(), &entries)
}

/// w(P − law).
pub fn residual(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> DVector<f64> {
    let one = |(s, w): (&Sample, &f64)| w * (s.stress - setting.model.at(&found.values, s));
    DVector::from_iterator(samples.len(), samples.iter().zip(&found.weight).map(one))
}

/// Jacobian, residual and stresses of the law, weighted, whose errors are those of the data points.
struct ErrorRows {
    jacobian: DMatrix<f64>,
    residual: DVector<f64>,
    fitted: DVector<f64>,
}

impl ErrorRows {
    /// Those of an answer. With Huber's loss they have the weights before it, and the residual is Kψ(r)/ψ̄′ with ψ(r) the residual up to its bound, ψ̄′ the part m of the
    /// data points within it and K = 1 + (p/n)(1 − m)/m: its covariance (JᵀJ)⁻¹Σ(Kψ)²/((n − p)m²) is the asymptotic one (Huber, *Robust Statistics*, 1981,
    /// eq. 7.6.10). Weights of single data points would make the columns as rough as the errors are.
    fn of(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> Self {
        let (n, p) = (samples.len() as f64, found.values.len() + setting.slack.len());
        let inside = found.share.iter().filter(|s| **s == 1.0).count() as f64 / n;
        let by = (1.0 + p as f64 / n * (1.0 - inside) / inside) / inside;
        let rows = residual(setting, samples, found);
        // ψ(r) = share² of the residual before the loss
        let pseudo = DVector::from_fn(samples.len(), |i, _| by * found.share[i] * rows[i]);
        let law = |(i, s): (usize, &Sample)| found.weight[i] / found.share[i] * setting.model.at(&found.values, s);
        Self {
            jacobian: unshared(jacobian(setting, samples, found), found),
            residual: pseudo,
            fitted: DVector::from_iterator(samples.len(), samples.iter().enumerate().map(law)),
        }
    }
}

/// Weighted rows without Huber's weights.
fn unshared(mut rows: DMatrix<f64>, found: &LawFit) -> DMatrix<f64> {
    rows.row_iter_mut().zip(&found.share).for_each(|(mut row, share)| row /= *share);
    rows
}

/// w P of the law.
pub fn fitted(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> DVector<f64> {
    let one = |(s, w): (&Sample, &f64)| w * setting.model.at(&found.values, s);
    DVector::from_iterator(samples.len(), samples.iter().zip(&found.weight).map(one))
}

/// Intervals and tests of an answer.
fn judge(setting: &LawSetting, samples: &[Sample], mut found: LawFit, tested: bool) -> Result<LawFit, FitError> {
    let residual = residual(setting, samples, &found);
    let size = samples.iter().zip(&found.weight).map(|(s, w)| (w * s.stress).powi(2)).sum::<f64>().sqrt();
    let jacobian = jacobian(setting, samples, &found);
    let rounding = residual.norm() <= ROUNDING * size;
    let rows = ErrorRows::of(setting, samples, &found);
    let mut errors = errors::of(&rows.jacobian, &rows.residual, &rows.fitted, samples, rounding);
    if setting.loss == Loss::Huber {
        // The likelihood of the profile is that of the weighted data points
        errors.plain = errors::directions(&jacobian).plain();
    }
    let q = setting.slack.len();
    let parameters = [setting.model.parameters(), &vec![OFFSET; q]].concat();
    let values = [found.values.clone(), setting.slack.iter().map(|o| o.strain).collect()].concat();
    found.identified = identify::identify(&parameters, &values, &jacobian, &residual, size, 0.0, Some(&errors));
    found.offsets = found.identified.estimates.split_off(found.values.len());
    if tested && !rounding {
        found.pattern = pattern(setting, samples, &found, &rows, errors.rho);
    }
    let others = std::mem::take(&mut found.others);
    let allowed = others.into_iter().filter(|o| is_allowed(setting, samples, &found, o, &errors));
    found.others = allowed.collect();
    found.errors = errors;
    Ok(found)
}

/// Whether other constants lie within the likelihood of one of the 95 % intervals: S − Ŝ ≤ (t dⱼ)²/((JᵀJ)⁻¹)ⱼⱼ, see `judgement::profile`.
fn is_allowed(setting: &LawSetting, samples: &[Sample], found: &LawFit, other: &[f64], errors: &Errors) -> bool {
    let square = |values: &[f64]| -> f64 {
        let of = |(s, w): (&Sample, &f64)| (w * (s.stress - setting.model.at(values, s))).powi(2);
        samples.iter().zip(&found.weight).map(of).sum()
    };
    // Without a degree of freedom no interval is finite
    if errors.free == 0 {
        return false;
    }
    let t = statistics::t_quantile(0.95, errors.free);
    let limit = errors.deviations.iter().zip(&errors.plain).map(|(d, plain)| t * d / plain).filter(|l| l.is_finite());
    square(other) - square(&found.values) <= limit.fold(0.0, f64::max).powi(2)
}

/// Tests of what the constants and these errors of the measurement, each of any size, leave of the residuals; `columns` as those of the Jacobian.
pub fn pattern_beyond(setting: &LawSetting, samples: &[Sample], found: &LawFit, columns: &DMatrix<f64>) -> Pattern {
    let own = ErrorRows::of(setting, samples, found);
    let columns = unshared(columns.clone(), found);
    let p = own.jacobian.ncols();
    let both = DMatrix::from_fn(samples.len(), p + columns.ncols(), |i, k| match k.checked_sub(p) {
        None => own.jacobian[(i, k)],
        Some(k) => columns[(i, k)],
    });
    let left = identify::across(&both, &own.residual);
    let rho = errors::of(&both, &left, &own.fitted, samples, false).rho;
    pattern(setting, samples, found, &ErrorRows { jacobian: both, residual: left, fitted: own.fitted }, rho)
}

/// Tests of a residual with neighbours of correlation `rho`.
fn pattern(setting: &LawSetting, samples: &[Sample], found: &LawFit, rows: &ErrorRows, rho: f64) -> Pattern {
    let second =
        |(i, s): (usize, &Sample)| found.weight[i] / found.share[i] * setting.model.at(&found.values, s) / s.stretch;
    let second = DVector::from_iterator(samples.len(), samples.iter().enumerate().map(second));
    let (runs, runs_p) = runs(samples, &rows.residual, rho).unzip();
    Pattern { runs, runs_p, departure_p: departure(rows, second, samples) }
}

/// Blocks of a curve whose signs are tested at most, two of them less one
const BLOCKS: usize = 200;

/// Runs of sign with their probability: of independent errors in the order of λ, of correlated ones in the order of loading without what the
/// neighbour explains; `None` of several specimens in one mode, whose levels differ.
///
/// Of long curves with correlated errors the signs are those of the means of blocks: what the neighbour does not explain of means of data points, as
/// tables with very many of them become, is correlated by up to ¼ from one to the next (Working, Econometrica 28, 1960, 916–918), which thousands of signs show.
fn runs(samples: &[Sample], residual: &DVector<f64>, rho: f64) -> Option<(usize, f64)> {
    if !Repeats::of(samples).repeated.is_empty() {
        return None;
    }
    let mut curves = errors::curves(samples);
    if rho == 0.0 {
        curves.iter_mut().for_each(|c| c.sort_by(|a, b| samples[*a].stretch.total_cmp(&samples[*b].stretch)));
    }
    let blocks = |curve: &Vec<usize>| {
        let size = if rho == 0.0 { 1 } else { (curve.len() / BLOCKS).max(1) };
        let white = errors::whitened(residual, std::slice::from_ref(curve), rho);
        white.chunks(size).map(|block| block.iter().sum::<f64>()).collect::<Vec<f64>>()
    };
    let signs = curves.iter().flat_map(blocks).filter(|r| *r != 0.0).map(|r| r > 0.0);
    statistics::few_runs(&signs.collect::<Vec<bool>>())
}

/// p-value of β = 0 in P = P(λ) + β P(λ)/λ (of a Neo-Hookean law in uniaxial tension β is Mooney's second constant): a t-test with the error
/// model of the fit that has β too, on the part of P/λ that the constants of the law cannot make.
fn departure(rows: &ErrorRows, second: DVector<f64>, samples: &[Sample]) -> Option<f64> {
    let ErrorRows { jacobian, residual, fitted } = rows;
    let p = jacobian.ncols();
    residual.len().checked_sub(p + 1).filter(|n| *n >= 1)?;
    let across = identify::across(jacobian, &second);
    let across2 = across.norm_squared();
    if across2 <= 1e-16 * second.norm_squared() {
        return None;
    }
    let beta = across.dot(residual) / across2;
    let r2 = residual.norm_squared();
    let mut left = residual - &across * beta;
    if left.norm_squared() < f64::EPSILON * r2 {
        left *= (f64::EPSILON * r2 / left.norm_squared().max(f64::MIN_POSITIVE)).sqrt();
    }
    let mut more = jacobian.clone().insert_column(p, 0.0);
    more.set_column(p, &across);
    let errors = errors::of(&more, &left, fitted, samples, false);
    let t = beta / errors.deviations[p];
    Some((1.0 - statistics::t_probability(t, errors.free)).max(0.0))
}
