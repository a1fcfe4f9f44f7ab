//! Decides which warnings a fit has.

use super::certificate::{Reach, lost};
use super::compressibility::UNNOTICED;
use super::determined::limits;
use super::estimate::Estimate;
use super::mirrored::decisive;
use super::misfit::{Misfit, Residual, residuals};
use super::outliers::Outliers;
use super::repeats::Repeats;
use super::validity::FLOOR;
use super::warning::FitWarning;
use crate::calibrate::constant_format::list;
use crate::calibrate::sample::{Test, by_test};
use crate::calibrate::solve::offset::Offset;
use crate::calibrate::solve::{LawFit, Pattern};
use crate::calibrate::{
    AuditKind, Experiment, FitResult, FittableLaw, Mode, Prediction, PredictionKind, Sample, SolverCheck, Treatment,
    Weighting,
};
use crate::material::FitTerms;
use crate::math::statistics::extent;
use crate::math::units::{Dimension, parse};

/// Relative misfit below which no pattern is reported; it prints as 0.00 % \[–\]
const NOTHING: f64 = 5e-5;

/// All warnings of a fit, except those that need other fits.
pub fn warnings(
    result: &FitResult,
    answer: &LawFit,
    model: FittableLaw,
    (experiment, fitted, outliers): (&Experiment, &[Sample], &Outliers),
    tolerance: f64,
) -> Vec<FitWarning> {
    let mut found = Vec::new();
    if !result.unidentified.is_empty() {
        found.push(FitWarning::Unidentifiable { directions: result.unidentified.clone() });
    }
    if answer.errors.free == 0 && result.unidentified.is_empty() {
        let (constants, rows) = (result.parameters.len() + result.slack.len(), result.rows);
        found.push(FitWarning::NoFreedom { constants, rows, least: answer.identified.least.clone() });
    }
    let limits = limits(answer, model);
    found.extend((!limits.is_empty()).then_some(FitWarning::Limit { found: limits }));
    found.extend(undefined(answer, model, experiment));
    found.extend(cycles(result));
    found.extend(may_be_zero(result));
    found.extend(other_minimum(result, answer, model));
    found.extend(held(answer));
    found.extend(unstable(result, model, fitted));
    found.extend(misfits(result, model, &answer.values, &outliers.counted(fitted, result.loss), tolerance));
    let other = |p: &&Prediction| p.kind == PredictionKind::OtherModeInRange;
    for p in result.predictions.iter().filter(other).filter(|p| p.misfit.rms_relative > tolerance) {
        let Misfit { bias_relative, rms_relative, .. } = p.misfit;
        found.push(FitWarning::CrossMode { mode: p.mode, bias_relative, rms_relative });
    }
    if let ([mode], true) = (&result.modes[..], result.parameters.len() > 1 && experiment.modes().len() == 1) {
        found.push(FitWarning::OneMode { mode: *mode });
    }
    found.extend(outliers.warnings(&experiment.specimens, result.loss));
    found.extend(result.scatter.as_ref().and_then(|s| {
        let one = s.specimens.iter().find(|one| Some(&one.file) == s.outlier.as_ref())?;
        Some(FitWarning::Specimen { file: one.file.clone(), level: one.level? })
    }));
    if let Some(SolverCheck::Starts { starts, agree: 1 }) = result.solver_check
        && starts > 2
    {
        found.push(FitWarning::Starts { starts });
    }
    let shear = model.law(&answer.values, 1e5 * answer.modulus).ok().map(|law| law.small_strain().mu);
    found.extend(shear.and_then(|mu| stiffness(mu, &experiment.stress_unit)));
    let doubts = [AuditKind::Doubt, AuditKind::Slack].into_iter().flat_map(|kind| experiment.audit.of(kind));
    found.extend(doubts.map(|e| FitWarning::Data { message: e.message.clone() }));
    let lateral = result.poisson.iter().flat_map(|p| p.doubts.iter().cloned());
    found.extend(lateral.map(|message| FitWarning::Data { message }));
    found.extend(compressible(result, model));
    found
}

/// One warning for each test in which the misfit is above the tolerance: large stresses in one test may hide the misfit in another. Misfits below 2 %
/// of the rms stress of the fit, where the range of validity does not end either, do not count.
fn misfits(
    result: &FitResult,
    model: FittableLaw,
    values: &[f64],
    counted: &[Sample],
    tolerance: f64,
) -> Vec<FitWarning> {
    let square = |rows: &[Residual], of: fn(&Residual) -> f64| rows.iter().map(|r| of(r).powi(2)).sum::<f64>();
    let budget = FLOOR * FLOOR * counted.iter().map(|s| s.stress.powi(2)).sum::<f64>();
    let groups = by_test(counted);
    let one = |(test, own): (&Test, &Vec<Sample>)| {
        let rows = residuals(own, |s| model.at(values, s));
        let (r2, p2) = (square(&rows, |r| r.residual), square(&rows, |r| r.measured));
        let test = (groups.len() > 1).then_some(*test);
        let is_large = r2 > tolerance * tolerance * p2 && r2 > budget;
        is_large.then(|| FitWarning::Misfit { test, rms_relative: (r2 / p2).sqrt(), tolerance })
    };
    let found: Vec<FitWarning> = groups.iter().filter_map(one).collect();
    let Misfit { rms_relative, .. } = result.misfit;
    match found[..] {
        [] if rms_relative > tolerance => vec![FitWarning::Misfit { test: None, rms_relative, tolerance }],
        _ => found,
    }
}

/// A pattern in the residuals of one specimen; the level of the tests is shared by all specimens.
pub fn systematic(patterns: &[Pattern], rms_relative: f64, wider: bool) -> Option<FitWarning> {
    let worst = patterns.iter().min_by(|a, b| a.least().total_cmp(&b.least()))?;
    let found = rms_relative > NOTHING && worst.is_found(patterns.len());
    let Pattern { runs, runs_p, departure_p, .. } = *worst;
    found.then_some(FitWarning::Systematic { runs, runs_p, departure_p, rms_relative, wider })
}

/// A warning about errors that grow with the stress or differ between modes although the weights assume otherwise. A pattern of the residuals can
/// look the same and is reported instead. `ratio`: ratio of the largest to the smallest standard deviation of a curve, if they differ.
pub fn unequal(result: &FitResult, ratio: Option<f64>) -> Option<FitWarning> {
    // Residuals that are only rounding of the file say nothing about its errors
    let grow = (result.misfit.rms_relative > NOTHING && result.errors.grows()).then_some(FitWarning::Unequal);
    let apart = ratio.filter(|_| result.modes.len() > 1).map(|ratio| FitWarning::UnequalCurves { ratio });
    grow.or(apart).filter(|_| result.weighting == Weighting::Absolute)
}

/// A warning about tests with one specimen if other tests have several.
pub fn no_repeat(fitted: &[Sample]) -> Option<FitWarning> {
    let Repeats { repeated, single } = Repeats::of_samples(fitted);
    let several = fitted.iter().any(|s| s.specimen != fitted[0].specimen);
    (several && !single.is_empty()).then_some(FitWarning::NoRepeat { single, repeated })
}

/// A warning about an offset that was not fitted, if a constant without it lies outside its interval with it.
pub fn slack_hint(own: &[Estimate], offset: Offset, other: &[Estimate]) -> Option<FitWarning> {
    // The slack is in the residuals of the fit without it, and widens its interval
    let leaves = |(a, b): (&Estimate, &Estimate)| a.value < b.interval[0] || a.value > b.interval[1];
    let answer = list(own, other.iter().map(|e| e.value));
    let Offset { mode, strain, .. } = offset;
    own.iter().zip(other).any(leaves).then_some(FitWarning::Slack { mode, strain, answer })
}

/// The answer of a choice of data points that was not requested: the last loading, otherwise all data points.
fn cycles(result: &FitResult) -> Option<FitWarning> {
    let unasked = || result.otherwise.iter().filter(|o| o.unasked);
    let other = unasked().find(|o| o.treatment == Treatment::LastLoading).or_else(|| unasked().next())?;
    let answer = list(&result.parameters, other.parameters.iter().map(|e| e.value));
    Some(FitWarning::Cycles { treatment: other.treatment, change: other.change, answer })
}

/// Constants with a finite interval that includes zero, for laws that do not need them.
fn may_be_zero(result: &FitResult) -> Option<FitWarning> {
    let holds_zero = |e: &&Estimate| e.std_error.is_finite() && e.value != 0.0 && e.may_be_zero();
    let symbols: Vec<_> = result.parameters.iter().filter(holds_zero).map(|e| e.symbol).collect();
    (!symbols.is_empty()).then_some(FitWarning::MayBeZero { symbols })
}

/// The constants at the second-lowest minimum.
fn other_minimum(result: &FitResult, answer: &LawFit, model: FittableLaw) -> Option<FitWarning> {
    let values = answer.others.first()?;
    let all = list(&result.parameters, values.iter().copied());
    let decides = decisive(model, &answer.values, values, result);
    Some(FitWarning::OtherMinimum { answer: all, minima: answer.others.len(), decides })
}

/// One warning for each mode and side of rest in which least squares alone would give an unstable law.
fn held(answer: &LawFit) -> Vec<FitWarning> {
    let of = |(mode, tension): (Mode, bool)| {
        let own = answer.active.iter().filter(|(m, s)| *m == mode && (*s > 1.0) == tension);
        let range = extent(own.map(|(_, s)| *s));
        (range[0] <= range[1]).then_some(FitWarning::Held { mode, range })
    };
    Mode::ALL.into_iter().flat_map(|m| [(m, false), (m, true)]).filter_map(of).collect()
}

fn unstable(result: &FitResult, model: FittableLaw, fitted: &[Sample]) -> Option<FitWarning> {
    let reach = Reach::of(fitted, model.nu);
    let lost = lost(&result.stability, reach);
    let linear = matches!(model.form.terms, FitTerms::Linear(_));
    (!lost.is_empty()).then_some(FitWarning::Unstable { lost, reach: reach.principal, linear })
}

/// A warning about data points outside the range at which the law is not defined.
fn undefined(answer: &LawFit, model: FittableLaw, experiment: &Experiment) -> Option<FitWarning> {
    let not_defined = |s: &&Sample| !model.at(&answer.values, s).is_finite();
    let stretches: Vec<f64> = experiment.samples.iter().filter(not_defined).map(Sample::reach).collect();
    let nearest = stretches.iter().copied().min_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()))?;
    Some(FitWarning::Undefined { rows: stretches.len(), nearest })
}

/// A warning if the law of the file, or of the scene that completes it, departs from the fitted curve because it is compressible.
fn compressible(result: &FitResult, model: FittableLaw) -> Option<FitWarning> {
    if model.form.compressible {
        return None;
    }
    let Some(given) = result.partner else {
        let volumetric = model.volumetric().is_some() && result.volumetric.is_none();
        return Some(FitWarning::NoPartner { volumetric });
    };
    let written = result.written(model);
    let change = written.change(given).filter(|c| c.relative.abs() > UNNOTICED)?;
    Some(FitWarning::Compressible { given, change, enough: written.enough() })
}

/// Range of shear moduli of rubbers \[Pa\], from the softest silicones to nearly hard compounds
const RUBBER: std::ops::RangeInclusive<f64> = 1e3..=1e7;

/// A warning about a stiffness outside the range of rubbers, usually due to a misread unit.
fn stiffness(mu: f64, unit: &str) -> Option<FitWarning> {
    if RUBBER.contains(&mu) {
        return None;
    }
    let pascal = |unit: &str| parse(&format!("1 {unit}"), Dimension::PRESSURE);
    // A force has a different kind of unit
    let read_as = pascal(unit).ok();
    let fits = |other: &&str| {
        pascal(other).ok().zip(read_as).is_some_and(|(factor, read_as)| RUBBER.contains(&(mu / read_as * factor)))
    };
    let instead = ["MPa", "kPa", "Pa"].into_iter().find(fits);
    Some(FitWarning::Stiffness { mu_pa: mu, unit: unit.into(), instead })
}
