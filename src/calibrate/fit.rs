//! From a request to a result: choose data points, fit, judge.

use super::intake::tables;
use super::judgement::certificate::{Reach, certificate};
use super::judgement::determined::undetermined;
use super::judgement::measurement::{self, NORMAL, Stated};
use super::judgement::mirrored::open_signs;
use super::judgement::misfit::residuals;
use super::judgement::outliers::Outliers;
use super::judgement::ranges::Whole;
use super::judgement::specimen::scatter;
use super::judgement::{no_repeat, predictions, slack_hint, systematic, unequal, validity, warnings};
use super::judgement::{profile, slack};
use super::poisson;
use super::result::interval_assumption;
use super::solve::{LawFit, LawSetting, pattern_beyond, solve};
use super::solve::{noise, offset};
use super::{
    AuditKind, ColumnChoice, Estimate, Experiment, FitCurves, FitError, FitOptions, FitRequest, FitResult, FittableLaw,
    Misfit, Mode, Otherwise, Partner, Sample, SharedError, Slack, SlackChoice, StretchRange, Treatment, Validity,
    Weighting,
};
use crate::math::statistics::{extent, t_quantile};
use nalgebra::DMatrix;
use std::borrow::Cow;

/// Reads a table and fits a law to it.
///
/// # Errors
///
/// An error is returned if the table cannot be read or holds too little, the law is unknown or cannot be fitted, or an option does not suit the data.
pub fn fit(request: &FitRequest) -> Result<FitResult, FitError> {
    // A law that does not exist is refused before a file is read.
    let model = FittableLaw::new(&request.options.law, request.options.terms)?;
    let compressible = model.form.compressible;
    let ratio = match request.options.partner {
        Some(Partner::Nu(nu)) if compressible => Some(nu),
        _ => None,
    };
    let columns = ColumnChoice { compressible, ratio, ..request.columns.clone() };
    let experiment = read(&FitRequest { columns, ..request.clone() })?;
    let poisson = poisson::of_request(request, model, &experiment)?;
    poisson::check_slack(fit_experiment(&experiment, &FitOptions { poisson, ..request.options.clone() })?)
}

/// The tables of a request, pooled.
pub(super) fn read(request: &FitRequest) -> Result<Experiment, FitError> {
    let prepared = tables::read(request)?.into_iter().map(|table| table.prepare(&request.preparation));
    Experiment::pool(prepared.collect::<Result<_, _>>()?)
}

/// Fits a law to a table that has already been read.
///
/// # Errors
///
/// Returns the errors of [`fit`], except those of reading files.
pub fn fit_experiment(experiment: &Experiment, options: &FitOptions) -> Result<FitResult, FitError> {
    let (model, poisson) = poisson::of_options(options, FittableLaw::new(&options.law, options.terms)?)?;
    let partner = options.partner.filter(|_| poisson.is_none()).map(|p| p.check()).transpose()?;
    let volumetric = options.volumetric.as_ref().map(|v| check_volumetric(model, v)).transpose()?;
    let (experiment, slack) = without_slack(experiment, options, model)?;
    let choice = choose(&experiment, options)?;
    let setting = LawSetting { slack: slack.offsets.clone(), ..choice.setting(options, model)? };
    let ChosenData { modes, range, fitted, stretch } = choice;
    let is_fitted = |s: &Sample| modes.contains(&s.mode) && range.contains(s.reach()) && s.is_informative();
    let mut answer = solve(&setting, &fitted, None)?;
    let groups = by_specimen(&fitted, experiment.specimens.len());
    let stress = |s: &Sample| model.at(&answer.values, s);
    let own = residuals(&fitted, stress);
    let defined = within_law(&experiment, stress);
    let all = residuals(&defined, stress);
    let (outliers, misfit, validity) = described(&fitted, (&defined, &modes), options, stress);
    let by_range = Whole::of(&setting, &fitted, &answer).ranges(&experiment, &modes, (range, options.ranges));
    let (scatter, patterns) = scatter(&setting, &experiment.specimens, &groups, &answer)?.unzip();
    let (parameters, stated) = headline(&setting, &fitted, &answer, &experiment, options)?;
    if !stated.contributions.is_empty() && answer.pattern.departure_p.is_some() {
        answer.pattern = pattern_beyond(&setting, &fitted, &answer, &stated.columns);
    }
    let measurement = stated.contributions;
    let largest = Reach::of(&experiment.samples, model.nu).largest();
    let title = format!("{} fitted to {}", model.label(), experiment.file);
    let curves = FitCurves::new(title, model, &answer.values, &experiment.samples, &all, is_fitted, stretch);
    let mut result = FitResult {
        law: model.name(),
        label: model.label(),
        terms: model.terms,
        formula: model.form.formula,
        law_source: model.form.source,
        data: experiment.file.clone(),
        data_sha256: experiment.sha256.clone(),
        data_source: experiment.card.as_ref().map(|c| citation(&c.source)).filter(|c| !c.is_empty()),
        version: env!("CARGO_PKG_VERSION"),
        asked_range: options.range,
        stretch,
        rows: fitted.len(),
        weighting: options.weighting,
        noise: setting.noise.clone(),
        loss: options.loss,
        in_use: in_use(&parameters, &answer),
        covariance: covariance(&answer, parameters.len()),
        correlation: correlation(&parameters, &answer, &stated.covariance),
        parameters,
        errors: answer.errors.model,
        degrees: answer.errors.free,
        interval_assumption: interval_assumption(&answer.errors, options.weighting, options.loss, &measurement),
        measurement,
        slack: slack_estimates(&setting, &fitted, &answer, &experiment, options),
        scatter,
        otherwise: otherwise(&experiment, &setting, &fitted, &answer, is_fitted),
        unidentified: answer.identified.directions.clone(),
        open_signs: vec![],
        undetermined: vec![],
        stability: certificate(model, &answer.values, answer.modulus, largest),
        partner,
        poisson,
        volumetric,
        misfit,
        validity,
        predictions: predictions(&all, &modes, range),
        range_spread: by_range.spread,
        range_dependence: by_range.rows,
        solver_check: answer.check,
        warnings: vec![],
        residuals: own,
        curves,
        audit: experiment.audit.clone(),
        modes,
    };
    result.warnings = warnings(&result, &answer, model, (&*experiment, &fitted[..], &outliers), options.tolerance);
    let patterns = patterns.unwrap_or_else(|| vec![answer.pattern]);
    let patterned = systematic(&patterns, misfit.rms_relative, answer.errors.smooth > 0.0);
    result.warnings.extend(patterned.or_else(|| unequal(&result, answer.errors.ratio())));
    result.warnings.extend(no_repeat(&fitted));
    result.warnings.extend(slack.hint.and_then(|(offset, other)| slack_hint(&result.parameters, offset, &other)));
    Ok(with_open_constants(result, &answer, model))
}

/// The data points at which the law is finite: a law of chains of finite length is not defined at every stretch outside the range.
fn within_law(experiment: &Experiment, stress: impl Fn(&Sample) -> f64) -> Vec<Sample> {
    experiment.samples.iter().filter(|s| s.is_informative() && stress(s).is_finite()).copied().collect()
}

/// Outliers among the fitted data points, with misfit and validity over the others. `defined`: data points of all modes at which the law is finite.
fn described(
    fitted: &[Sample],
    (defined, modes): (&[Sample], &[Mode]),
    options: &FitOptions,
    law: impl Fn(&Sample) -> f64 + Copy,
) -> (Outliers, Misfit, Validity) {
    let outliers = Outliers::of(fitted, law);
    let counted = residuals(&outliers.counted(fitted, options.loss), law);
    let misfit = Misfit::of(&counted).expect("outliers are few");
    let own: Vec<Sample> = defined.iter().filter(|s| modes.contains(&s.mode)).copied().collect();
    let valid = validity(&outliers.counted(&own, options.loss), law, &counted, options.tolerance);
    (outliers, misfit, valid)
}

/// The fit with a list of the constants that the data leave open: those whose sign is not determined, and all others.
fn with_open_constants(result: FitResult, answer: &LawFit, model: FittableLaw) -> FitResult {
    let mut result = open_signs(result, answer, model);
    result.undetermined = undetermined(&result.parameters, &result.open_signs, answer, model);
    result
}

/// The constants with the 95 % intervals of the error model (by profile likelihood if the law is not linear in them), and of the stated errors of the
/// measurement, which are listed.
pub(super) fn headline(
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    experiment: &Experiment,
    options: &FitOptions,
) -> Result<(Vec<Estimate>, Stated), FitError> {
    let mut found = answer.identified.estimates.clone();
    let ends = profile::intervals(setting, fitted, answer).unwrap_or_default();
    found.iter_mut().zip(ends).for_each(|(e, ends)| e.interval = ends);
    let mut asked = options.accuracy.clone();
    if let Some(half) = options.poisson.as_ref().filter(|p| p.measured).map(|p| p.ratio.half_width()) {
        asked.0.insert(SharedError::Poisson, half);
    }
    let stated = measurement::contributions(setting, fitted, answer, experiment, &asked)?;
    measurement::widen(&mut found, &stated.contributions);
    Ok((found, stated))
}

/// Covariance of the first `count` constants, which are those of the law.
fn covariance(answer: &LawFit, count: usize) -> Vec<Vec<f64>> {
    let c = &answer.errors.covariance;
    (0..count).map(|a| (0..count).map(|b| c[(a, b)]).collect()).collect()
}

/// Largest ratio of the half-width of an interval to that of a linear fit at which the interval counts as that of a linear fit
const LINEAR: f64 = 1.5;

/// Correlation of the constants due to the scatter and the shared errors together, each weighted as in the half-widths of the intervals: t²C +
/// 1.96²S. Empty if a variance is not finite, if no degree of freedom is left, or if intervals are far from those of a linear fit.
fn correlation(parameters: &[Estimate], answer: &LawFit, shared: &DMatrix<f64>) -> Vec<Vec<f64>> {
    if answer.errors.free == 0 {
        return vec![];
    }
    let count = shared.nrows();
    let t = t_quantile(0.95, answer.errors.free);
    let total = answer.errors.covariance.view((0, 0), (count, count)) * (t * t) + shared * (NORMAL * NORMAL);
    let of_linear = |(k, e): (usize, &Estimate)| 0.5 * (e.interval[1] - e.interval[0]) / total[(k, k)].sqrt();
    let [least, most] = extent(parameters.iter().enumerate().map(of_linear));
    let is_linear = most <= LINEAR * least;
    if !is_linear {
        return vec![];
    }
    let one = |a: usize, b: usize| if a == b { 1.0 } else { total[(a, b)] / (total[(a, a)] * total[(b, b)]).sqrt() };
    let all: Vec<Vec<f64>> = (0..count).map(|a| (0..count).map(|b| one(a, b)).collect()).collect();
    if all.iter().flatten().all(|r| r.is_finite()) { all } else { vec![] }
}

/// The intervals, widened by the largest shift of each constant that a departure from the law as large as that of the data can cause: |δθⱼ| ≤
/// ‖δ‖√((JᵀJ)⁻¹)ⱼⱼ.
fn in_use(parameters: &[Estimate], answer: &LawFit) -> Vec<[f64; 2]> {
    let one = |(e, plain): (&Estimate, &f64)| {
        let shift = answer.errors.smooth * plain;
        [e.interval[0] - shift, e.interval[1] + shift]
    };
    parameters.iter().zip(&answer.errors.plain).map(one).collect()
}

/// The table with strains counted from where the specimens begin to carry load, and the strain offsets.
pub(super) fn without_slack<'a>(
    experiment: &'a Experiment,
    options: &FitOptions,
    model: FittableLaw,
) -> Result<(Cow<'a, Experiment>, slack::SlackFit), FitError> {
    let choice = choose(experiment, options)?;
    let setting = choice.setting(options, model)?;
    // If the toe has been removed, that removed the slack
    let is_shifted = experiment.alternatives.iter().any(|a| a.treatment == Treatment::WithoutToe);
    let asked = match options.slack {
        SlackChoice::Yes if is_shifted => {
            return Err(FitError::Slack { reason: "the toe has shifted the strain already: take one of the two" });
        }
        SlackChoice::Auto if is_shifted => SlackChoice::No,
        asked => asked,
    };
    let mut found = slack::find(&setting, &choice.fitted, asked)?;
    if found.offsets.is_empty() {
        return Ok((Cow::Borrowed(experiment), found));
    }
    let mut rows = choice.fitted;
    for _ in 0..AGAIN {
        // The range refers to the stretch without slack
        let inside = |s: &&Sample| {
            let real = offset::removed(&[**s], &found.offsets)[0];
            choice.modes.contains(&s.mode) && choice.range.contains(real.reach()) && s.is_informative()
        };
        let next: Vec<Sample> = experiment.samples.iter().filter(inside).copied().collect();
        if next == rows {
            break;
        }
        found.offsets = slack::search(&setting, &next, found.offsets)?.0;
        rows = next;
    }
    let mut own = experiment.clone();
    own.audit.remove(AuditKind::Slack);
    own.samples = offset::removed(&experiment.samples, &found.offsets);
    own.alternatives.iter_mut().for_each(|a| a.samples = offset::removed(&a.samples, &found.offsets));
    let (treatment, unasked) = (Treatment::WithoutSlack, false);
    own.alternatives.push(super::Alternative { treatment, unasked, samples: experiment.samples.clone() });
    for o in &found.offsets {
        let inside = experiment.samples.iter().filter(|s| o.is_of(s) && o.shifted(s, o.strain).stretch == 1.0);
        let message = format!("{} strain was shifted by {:+.6}, its fitted slack", o.mode, -o.strain);
        own.audit.add(AuditKind::Changed, message, inside.map(|s| s.line).collect());
    }
    Ok((Cow::Owned(own), found))
}

/// How often the choice of data points is repeated when the slack changes it
const AGAIN: usize = 4;

/// The strain offsets with their intervals.
pub(super) fn slack_estimates(
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    experiment: &Experiment,
    options: &FitOptions,
) -> Vec<Slack> {
    let one = |(o, e): (&offset::Offset, &Estimate)| Slack {
        file: experiment.specimens[o.specimen].clone(),
        mode: o.mode,
        strain: o.strain,
        interval: e.interval,
        rows: fitted.iter().filter(|s| o.is_of(s) && s.stretch == 1.0).count(),
        asked: options.slack == SlackChoice::Yes,
    };
    setting.slack.iter().zip(&answer.offsets).map(one).collect()
}

/// The fit under every other treatment of the data points.
fn otherwise(
    experiment: &Experiment,
    setting: &LawSetting,
    fitted: &[Sample],
    answer: &LawFit,
    is_fitted: impl Fn(&Sample) -> bool,
) -> Vec<Otherwise> {
    let one = |a: &super::Alternative| {
        let rows: Vec<Sample> = a.samples.iter().filter(|s| is_fitted(s)).copied().collect();
        let own = LawSetting { slack: vec![], ..setting.clone() };
        let found = solve(&own, &rows, None).ok()?;
        let law = |s: &Sample| setting.model.at(&answer.values, s);
        let change: f64 = fitted.iter().map(|s| (setting.model.at(&found.values, s) - law(s)).powi(2)).sum();
        let size: f64 = fitted.iter().map(|s| law(s).powi(2)).sum();
        let parameters = found.identified.estimates;
        let change = (change / size).sqrt();
        Some(Otherwise { treatment: a.treatment, unasked: a.unasked, rows: rows.len(), parameters, change })
    };
    experiment.alternatives.iter().filter_map(one).collect()
}

/// Data points of each specimen.
fn by_specimen(rows: &[Sample], specimens: usize) -> Vec<Vec<Sample>> {
    (0..specimens).map(|k| rows.iter().filter(|s| s.specimen == k).copied().collect()).collect()
}

/// The data points that a fit uses.
pub(super) struct ChosenData {
    pub modes: Vec<Mode>,
    pub range: StretchRange,
    pub fitted: Vec<Sample>,
    /// Smallest and largest fitted λ
    pub stretch: [f64; 2],
}

/// Chooses modes and data points as requested; refuses too few of them.
pub(super) fn choose(experiment: &Experiment, options: &FitOptions) -> Result<ChosenData, FitError> {
    let modes = choose_modes(experiment, &options.modes)?;
    let range = options.range.unwrap_or(StretchRange::ALL);
    let is_fitted = |s: &Sample| modes.contains(&s.mode) && range.contains(s.reach()) && s.is_informative();
    let fitted: Vec<Sample> = experiment.samples.iter().copied().filter(is_fitted).collect();
    check_rows(experiment, &modes, range, &fitted)?;
    let stretch = extent(fitted.iter().map(|s| s.stretch));
    Ok(ChosenData { modes, range, fitted, stretch })
}

impl ChosenData {
    pub(super) fn setting(&self, options: &FitOptions, model: FittableLaw) -> Result<LawSetting, FitError> {
        let noise = match options.weighting {
            Weighting::Noise => noise::of_modes(&self.fitted, &self.modes, options.noise)?,
            _ if options.noise.is_some() => return Err(FitError::IdleNoise),
            Weighting::Absolute | Weighting::Relative => vec![],
        };
        Ok(LawSetting {
            model,
            weighting: options.weighting,
            noise,
            loss: options.loss,
            stable: stable_points(options.stable, &self.fitted),
            slack: vec![],
            held: None,
            stop: options.stop.clone(),
        })
    }
}

fn choose_modes(experiment: &Experiment, asked: &[Mode]) -> Result<Vec<Mode>, FitError> {
    let present = experiment.modes();
    if asked.is_empty() {
        return match present[..] {
            [only] => Ok(vec![only]),
            _ => Err(FitError::ChooseMode { file: experiment.file.clone(), present }),
        };
    }
    if let Some(&mode) = asked.iter().find(|m| !present.contains(m)) {
        return Err(FitError::AbsentMode { file: experiment.file.clone(), mode, present });
    }
    Ok(Mode::ALL.into_iter().filter(|m| asked.contains(m)).collect())
}

/// Least number of data points at stretches other than 1 that a fit of any law needs; with fewer data points than constants the result names the
/// directions that they leave open.
const ROWS: usize = 2;

fn check_rows(experiment: &Experiment, modes: &[Mode], range: StretchRange, fitted: &[Sample]) -> Result<(), FitError> {
    let rows = fitted.iter().filter(|s| s.stretch != 1.0).count();
    if rows >= ROWS {
        return check_strain(experiment, fitted);
    }
    let own = experiment.samples.iter().filter(|s| modes.contains(&s.mode)).map(Sample::reach);
    let [data_from, data_to] = extent(own);
    let (from, to) = if range == StretchRange::ALL { (data_from, data_to) } else { (range.from, range.to) };
    Err(FitError::TooFewRows { from, to, rows, needed: ROWS, data_from, data_to })
}

/// Least value of the largest strain that a fit needs: a stretch resolves strains to 1e-16, testing machines much less finely \[–\]
const LEAST_STRAIN: f64 = 1e-6;

fn check_strain(experiment: &Experiment, fitted: &[Sample]) -> Result<(), FitError> {
    let strain = fitted.iter().flat_map(|s| [s.stretch, s.second]).map(|l| (l - 1.0).abs()).fold(0.0, f64::max);
    if strain >= LEAST_STRAIN {
        return Ok(());
    }
    Err(FitError::TinyStrain { file: experiment.file.clone(), strain, least: LEAST_STRAIN })
}

fn check_volumetric(model: FittableLaw, option: &str) -> Result<String, FitError> {
    let refuse = |remedy| Err(FitError::Volumetric { option: option.into(), remedy });
    match model.law.info.choices.iter().find(|c| c.name == "volumetric") {
        None => refuse(format!("law {} has no choice of a volumetric part; omit it", model.name())),
        Some(c) if !c.options.contains(&option) => refuse(format!("take one of {}", c.options.join(", "))),
        Some(_) => Ok(option.into()),
    }
}

/// Number of stretches per mode at which a linear law is kept stable
const STABLE: u32 = 201;

/// Stretches at which a linear law is kept stable: the requested range in every mode; by default, each mode that was fitted from rest over its own
/// fitted stretches. A law is not constrained in modes without a test.
fn stable_points(asked: Option<StretchRange>, fitted: &[Sample]) -> Vec<(Mode, f64)> {
    let range = |mode: Mode| match asked {
        Some(r) => [r.from.min(1.0), r.to.max(1.0)],
        None => extent(fitted.iter().map(|s| stretch_as(mode, s)).chain([1.0])),
    };
    let of = |mode: Mode| {
        let [low, high] = range(mode);
        let at = move |k: u32| low * (high / low).powf(f64::from(k) / f64::from(STABLE - 1));
        (0..STABLE).filter(move |_| low < high).map(move |k| (mode, at(k)))
    };
    Mode::PULLED.into_iter().flat_map(of).collect()
}

/// The stretch \[–\] that a data point reaches in a mode; 1 if it does not belong to the mode. Stability depends on the principal stretches: simple
/// shear has those of the planar test, and a biaxial state counts as planar in each direction and as equibiaxial up to the stretch that is nearer to
/// rest.
fn stretch_as(mode: Mode, s: &Sample) -> f64 {
    match (mode, s.mode) {
        (Mode::Planar, Mode::SimpleShear | Mode::Biaxial) => s.stretch,
        (Mode::Equibiaxial, Mode::Biaxial) => s.stretch.min(s.second).max(1.0) * s.stretch.max(s.second).min(1.0),
        (mode, own) if mode == own => s.stretch,
        _ => 1.0,
    }
}

fn citation(source: &super::Source) -> String {
    let year = source.year.map(|y| y.to_string()).unwrap_or_default();
    let parts = [&source.authors, &source.title, &source.journal, &source.volume, &year, &source.pages, &source.url];
    parts.into_iter().filter(|p| !p.is_empty()).cloned().collect::<Vec<_>>().join(", ")
}
