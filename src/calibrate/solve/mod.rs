//! One fit of one law to some samples: weights, solver, intervals.

pub(super) mod error_rows;
pub(super) mod linear;
pub(super) mod noise;
pub(super) mod offset;
mod pattern;
pub(super) mod refit;
pub(super) mod rows;
pub(super) mod separable;
pub(super) mod solver_check;

pub use pattern::Pattern;

use self::solver_check::SolverCheck;
use crate::calibrate::FittableLaw;
use crate::calibrate::judgement::errors::{self, Errors};
use crate::calibrate::judgement::identify::{self, Identified};
use crate::calibrate::judgement::misfit::sum_of_squares;
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::judgement::repeats::Repeats;
use crate::calibrate::{Estimate, FitError, Loss, Sample, Weighting};
use crate::material::FitTerms;
use crate::material::principal::invariants;
use crate::math::statistics::median;
use error_rows::{ErrorRows, unshared};
use linear::Points;
use nalgebra::{DMatrix, DVector};
use noise::ModeNoise;
use offset::{OFFSET, Offset};
use refit::{Held, Refit};
use rows::WeightedRows;
use separable::Minimum;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Settings that are the same in all fits of a request.
#[derive(Clone, Debug)]
pub struct LawSetting {
    pub model: FittableLaw,
    pub weighting: Weighting,
    /// Standard deviation of the stress of each mode \[Pa\], if the weights need it
    pub noise: Vec<ModeNoise>,
    pub loss: Loss,
    /// Points at which a linear law is kept stable
    pub stable: Points,
    /// Strain offsets that are unknowns; the samples are given without these offsets
    pub slack: Vec<Offset>,
    /// Constants that are held, if only some are fitted
    pub held: Option<Held>,
    /// Flag that is set from outside to stop the fit
    pub stop: Option<Arc<AtomicBool>>,
}

impl LawSetting {
    /// Returns an error if the fit is to stop.
    fn goes_on(&self) -> Result<(), FitError> {
        match &self.stop {
            Some(stop) if stop.load(Ordering::Relaxed) => Err(FitError::Interrupted),
            _ => Ok(()),
        }
    }

    /// These settings with only the strain offsets of these samples.
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
    /// Strain offsets, one for each offset of the setting
    pub offsets: Vec<Estimate>,
    pub errors: Errors,
    /// `None` if a single solver was enough (fits of parts of the data)
    pub check: Option<SolverCheck>,
    /// Points at which least squares alone would give an unstable law; empty if no stability constraint is active
    pub active: Points,
    pub pattern: Pattern,
    /// Neo-Hookean modulus of the same data \[Pa\], used as a scale
    pub modulus: f64,
    /// w of each sample, including Huber's weight
    pub weight: Vec<f64>,
    /// √ of Huber's weight of each sample; 1 for least squares
    pub share: Vec<f64>,
    /// Shape variables at which a separable search ended
    pub at: Vec<f64>,
    /// Values at other minima of a separable search whose misfit is compatible with the errors of the data points \[SI\]
    pub others: Vec<Vec<f64>>,
    /// Whether shape constants with the opposite sign give the same stresses
    pub mirrored: bool,
}

/// Misfit ‖r‖/‖P‖ below which the residuals are rounding and their pattern has no meaning \[–\]
pub const ROUNDING: f64 = 1e-9;
/// Huber's constant: 95 % efficiency for normal errors \[–\]
const HUBER: f64 = 1.345;
/// Largest number of reweighted fits, and the change of a weight below which they end
const REWEIGHTED: usize = 60;
const SETTLED: f64 = 1e-6;

/// Fits the constants with intervals and tests. `near`: the answer to nearly the same samples; one solver and one start are then enough.
pub fn solve(setting: &LawSetting, samples: &[Sample], near: Option<&LawFit>) -> Result<LawFit, FitError> {
    judge(setting, samples, constants(setting, samples, near)?, true)
}

/// Fits the constants starting from an answer to nearly the same samples, without tests of the residuals.
pub fn solve_untested(setting: &LawSetting, samples: &[Sample], near: &LawFit) -> Result<LawFit, FitError> {
    judge(setting, samples, constants(setting, samples, Some(near))?, false)
}

/// Fits the constants without intervals and tests. Relative weights and Huber's weights follow from the law, and the fit is repeated until they
/// settle.
pub fn constants(setting: &LawSetting, samples: &[Sample], near: Option<&LawFit>) -> Result<LawFit, FitError> {
    let (specimen, repeats): (Vec<usize>, _) =
        (samples.iter().map(|s| s.specimen).collect(), Repeats::of_samples(samples));
    let base = |stress: &[f64]| {
        let mut weights = noise::weights(samples, stress, setting.weighting, &setting.noise)?;
        noise::share(&mut weights, &specimen, &repeats);
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
            let settled = next.iter().zip(&weight).zip(&own).all(|((a, b), c)| (a - b).abs() <= SETTLED * c);
            weight = next;
            if settled {
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

/// √ of Huber's weights, from the weights without them and the stresses of the law.
fn shares(samples: &[Sample], base: &[f64], law: &[f64]) -> Vec<f64> {
    let off = |((s, w), p): ((&Sample, &f64), &f64)| (w * (s.stress - p)).abs();
    let r: Vec<f64> = samples.iter().zip(base).zip(law).map(off).collect();
    let size = samples.iter().zip(base).map(|(s, w)| (w * s.stress).powi(2)).sum::<f64>().sqrt();
    huber_share(&r, size)
}

/// √ of Huber's weights min(1, kσ/|r|), σ = 1.4826 median |r| (Huber, Robust Statistics, 1981, ch. 7), for weighted |r| of data points with the norm
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
    setting.goes_on()?;
    let rows = WeightedRows::new(samples, weight, setting.model.nu)?;
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
        mirrored: false,
    };
    if let Some(Held { values, free }) = &setting.held {
        let start = near.map_or(values, |n| &n.values).clone();
        let found = Refit { model: setting.model, slack: &[], samples, weight }.refitted(start, free);
        let (values, _) = found.ok_or_else(|| FitError::Solver {
            solver: "Levenberg-Marquardt",
            status: "the law is not defined at the constants that are held".into(),
        })?;
        return Ok(bare(values, None, vec![], vec![]));
    }
    match &setting.model.form.terms {
        FitTerms::Linear(derivatives) => {
            let found = linear::solve(*derivatives, setting.model.terms, &rows, &setting.stable, near.is_none())?;
            Ok(bare(found.values, found.check, found.active, vec![]))
        }
        FitTerms::Separable(family) => {
            let warm = near.map(|n| n.at.as_slice());
            let reach = samples.iter().map(|s| invariants(s.stretches(setting.model.nu)).0).fold(0.0, f64::max);
            let found = separable::solve((family, setting.model.terms), &rows, reach, warm, || setting.goes_on())?;
            // + 0: a factor that vanished has no sign
            let factor = |(c, theta): (&f64, &f64)| [c * (family.factor)(*theta).0 + 0.0, *theta];
            let values = |m: &Minimum| m.factors.iter().zip(&m.shapes).flat_map(factor).collect();
            let others = found.others.iter().map(values).collect();
            let check = near.is_none().then_some(found.check);
            let mirrored = found.mirrored;
            Ok(LawFit { others, mirrored, ..bare(values(&found.least), check, vec![], found.least.at) })
        }
    }
}

/// w ∂P/∂(constants, offsets), (n × (p + q)).
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

/// The rows of an answer that determine the errors of its constants.
fn error_rows(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> ErrorRows {
    let law: Vec<f64> = samples.iter().map(|s| setting.model.at(&found.values, s)).collect();
    let (jacobian, residual) = (jacobian(setting, samples, found), residual(setting, samples, found));
    ErrorRows::of(jacobian, &residual, &law, &found.weight, &found.share)
}

/// w P of the law.
pub fn fitted(setting: &LawSetting, samples: &[Sample], found: &LawFit) -> DVector<f64> {
    let one = |(s, w): (&Sample, &f64)| w * setting.model.at(&found.values, s);
    DVector::from_iterator(samples.len(), samples.iter().zip(&found.weight).map(one))
}

/// Adds intervals and tests to an answer.
fn judge(setting: &LawSetting, samples: &[Sample], mut found: LawFit, tested: bool) -> Result<LawFit, FitError> {
    let residual = residual(setting, samples, &found);
    let size = samples.iter().zip(&found.weight).map(|(s, w)| (w * s.stress).powi(2)).sum::<f64>().sqrt();
    let jacobian = jacobian(setting, samples, &found);
    let rounding = residual.norm() <= ROUNDING * size;
    let rows = error_rows(setting, samples, &found);
    let errors = rows.errors(&jacobian, &Origin::of(samples), rounding);
    let q = setting.slack.len();
    let parameters = [setting.model.parameters(), &vec![OFFSET; q]].concat();
    let values = [found.values.clone(), setting.slack.iter().map(|o| o.strain).collect()].concat();
    found.identified = identify::identify(
        &parameters,
        (values.as_slice(), values.as_slice()),
        &jacobian,
        &residual,
        size,
        0.0,
        Some(&errors),
    );
    found.offsets = found.identified.estimates.split_off(found.values.len());
    if tested && !rounding {
        found.pattern = Pattern::of(samples, &rows.over(errors.sizes.as_ref()), errors.correlation);
    }
    let others = std::mem::take(&mut found.others);
    let allowed = others.into_iter().filter(|o| is_allowed(setting, samples, &found, o, &errors));
    found.others = allowed.collect();
    found.errors = errors;
    Ok(found)
}

/// Whether other constants lie within the likelihood of one of the 95 % intervals.
fn is_allowed(setting: &LawSetting, samples: &[Sample], found: &LawFit, other: &[f64], errors: &Errors) -> bool {
    let square = |values: &[f64]| sum_of_squares(samples, &found.weight, |s| setting.model.at(values, s));
    errors.rise().is_some_and(|rise| square(other) - square(&found.values) <= rise)
}

/// Tests of the residuals that remain after the constants and these errors of the measurement, each of any size, are fitted; `columns` are in the
/// form of the Jacobian.
pub fn pattern_beyond(setting: &LawSetting, samples: &[Sample], found: &LawFit, columns: &DMatrix<f64>) -> Pattern {
    let own = error_rows(setting, samples, found);
    let columns = unshared(columns.clone(), &found.share);
    let p = own.jacobian.ncols();
    let both = DMatrix::from_fn(samples.len(), p + columns.ncols(), |i, k| match k.checked_sub(p) {
        None => own.jacobian[(i, k)],
        Some(k) => columns[(i, k)],
    });
    let left = identify::across(&both, &own.residual);
    let errors = errors::of(&both, &left, &own.fitted, &Origin::of(samples), false);
    let unlimited = identify::across(&both, &own.unlimited);
    let rows = ErrorRows { jacobian: both, residual: left, unlimited, fitted: own.fitted };
    Pattern::of(samples, &rows.over(errors.sizes.as_ref()), errors.correlation)
}
