//! From a request to a result: choose data points, fit, judge.

use super::bootstrap::bootstrap;
use super::certificate::certificate;
use super::judgement::{predictions, validity, warnings};
use super::misfit::residuals;
use super::result::interval_assumption;
use super::solve::{LawFit, LawSetting, solve};
use super::specimen::scatter;
use super::statistics::extent;
use super::{
    Experiment, FitCurves, FitError, FitOptions, FitRequest, FitResult, Misfit, Mode, Model, Otherwise, RangeRow,
    Sample, StretchRange, Weighting, noise, profile,
};
use crate::material::principal::invariants;

/// Reads a table and fits a law to it.
pub fn fit(request: &FitRequest) -> Result<FitResult, FitError> {
    // A law that does not exist is refused before a file is read.
    Model::new(&request.options.law, request.options.terms)?;
    fit_experiment(&read(request)?, &request.options)
}

/// The tables of a request as one.
pub(super) fn read(request: &FitRequest) -> Result<Experiment, FitError> {
    let stated = match request.options.modes[..] {
        [one] => Some(one),
        _ => None,
    };
    let files = std::iter::once(&request.data).chain(&request.more);
    let one = |path: &std::path::PathBuf| {
        Experiment::read(path, request.card.as_deref(), &request.columns, stated)?.prepare(&request.preparation)
    };
    Experiment::pool(files.map(one).collect::<Result<_, _>>()?)
}

/// Fits a law to a table that was read already.
pub fn fit_experiment(experiment: &Experiment, options: &FitOptions) -> Result<FitResult, FitError> {
    let model = Model::new(&options.law, options.terms)?;
    let partner = options.partner.map(|p| p.check()).transpose()?;
    let volumetric = options.volumetric.as_ref().map(|v| check_volumetric(model, v)).transpose()?;
    let choice = choose(experiment, options)?;
    let setting = choice.setting(experiment, options, model)?;
    let Choice { modes, range, fitted, stretch } = choice;
    let is_fitted = |s: &Sample| modes.contains(&s.mode) && range.contains(s.stretch) && s.is_informative();
    let answer = solve(&setting, &fitted, None)?;
    let groups = by_specimen(&fitted, experiment.specimens.len());
    let stress = |s: &Sample| model.at(&answer.values, s);
    let own = residuals(&fitted, stress);
    let misfit = Misfit::of(&own).expect("the data points were counted");
    let samples: Vec<Sample> = experiment.samples.iter().copied().filter(Sample::is_informative).collect();
    let all = residuals(&samples, stress);
    let range_dependence = range_dependence(experiment, &modes, range.from, &setting, &answer);
    let principal = |s: &Sample| s.stretches().into_iter().fold(s.stretch, f64::max).max(1.0 / s.stretch);
    let largest = experiment.samples.iter().map(principal).fold(1.0, f64::max);
    let curves = FitCurves::new(
        format!("{} fitted to {}", model.label(), experiment.file),
        model,
        &answer.values,
        &experiment.samples,
        &all,
        is_fitted,
        stretch,
    );
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
        parameters: answer.identified.estimates.clone(),
        interval_assumption: interval_assumption(options.weighting, options.loss),
        profile: profile::intervals(model, &fitted, &answer),
        bootstrap: bootstrap(&setting, &groups, &answer, options.bootstrap),
        scatter: scatter(&setting, &experiment.specimens, &groups, &answer)?,
        otherwise: otherwise(experiment, &setting, &fitted, &answer, is_fitted),
        unidentified: answer.identified.directions.clone(),
        stability: certificate(model, &answer.values, answer.modulus, largest),
        partner,
        volumetric,
        misfit,
        validity: validity(&all, &modes, options.tolerance),
        predictions: predictions(&all, &modes, range),
        range_spread: range_spread(&range_dependence, &answer, stretch[1]),
        range_dependence,
        solver_check: answer.check,
        warnings: vec![],
        residuals: own,
        curves,
        audit: experiment.audit.clone(),
        modes,
    };
    result.warnings = warnings(&result, &answer, model, experiment, options.tolerance);
    Ok(result)
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
        let found = solve(setting, &rows, None).ok()?;
        let law = |s: &Sample| setting.model.at(&answer.values, s);
        let change: f64 = fitted.iter().map(|s| (setting.model.at(&found.values, s) - law(s)).powi(2)).sum();
        let size: f64 = fitted.iter().map(|s| law(s).powi(2)).sum();
        let parameters = found.identified.estimates;
        let change = (change / size).sqrt();
        Some(Otherwise { treatment: a.treatment, unasked: a.unasked, rows: rows.len(), parameters, change })
    };
    experiment.alternatives.iter().filter_map(one).collect()
}

/// Rows of each specimen.
fn by_specimen(rows: &[Sample], specimens: usize) -> Vec<Vec<Sample>> {
    (0..specimens).map(|k| rows.iter().filter(|s| s.specimen == k).copied().collect()).collect()
}

/// The data points of a fit.
pub(super) struct Choice {
    pub modes: Vec<Mode>,
    pub range: StretchRange,
    pub fitted: Vec<Sample>,
    /// Smallest and largest fitted λ
    pub stretch: [f64; 2],
}

/// Chooses modes and data points as requested; refuses too few of them.
pub(super) fn choose(experiment: &Experiment, options: &FitOptions) -> Result<Choice, FitError> {
    let modes = choose_modes(experiment, &options.modes)?;
    let range = options.range.unwrap_or(StretchRange::ALL);
    let is_fitted = |s: &Sample| modes.contains(&s.mode) && range.contains(s.stretch) && s.is_informative();
    let fitted: Vec<Sample> = experiment.samples.iter().copied().filter(is_fitted).collect();
    check_rows(experiment, &modes, range, &fitted)?;
    let stretch = extent(fitted.iter().map(|s| s.stretch));
    Ok(Choice { modes, range, fitted, stretch })
}

impl Choice {
    pub(super) fn setting(
        &self,
        experiment: &Experiment,
        options: &FitOptions,
        model: Model,
    ) -> Result<LawSetting, FitError> {
        let invariant = |s: &Sample| invariants(s.stretches()).0;
        let noise = match options.weighting {
            Weighting::Noise => noise::of_modes(&self.fitted, &self.modes, options.noise)?,
            Weighting::Absolute | Weighting::Relative => vec![],
        };
        Ok(LawSetting {
            model,
            weighting: options.weighting,
            noise,
            loss: options.loss,
            reach: experiment.samples.iter().map(invariant).fold(0.0, f64::max),
            stable: stable_points(options.stable, &self.modes, self.stretch),
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

/// Data points at stretches other than 1 that a fit needs for any law; with fewer data points than constants the result names the directions that they leave open.
const ROWS: usize = 2;

fn check_rows(experiment: &Experiment, modes: &[Mode], range: StretchRange, fitted: &[Sample]) -> Result<(), FitError> {
    let rows = fitted.iter().filter(|s| s.stretch != 1.0).count();
    if rows >= ROWS {
        return Ok(());
    }
    let own = experiment.samples.iter().filter(|s| modes.contains(&s.mode)).map(|s| s.stretch);
    let [data_from, data_to] = extent(own);
    let (from, to) = if range == StretchRange::ALL { (data_from, data_to) } else { (range.from, range.to) };
    Err(FitError::TooFewRows { from, to, rows, needed: ROWS, data_from, data_to })
}

fn check_volumetric(model: Model, option: &str) -> Result<String, FitError> {
    let refuse = |remedy| Err(FitError::Volumetric { option: option.into(), remedy });
    match model.law.info.choices.iter().find(|c| c.name == "volumetric") {
        None => refuse(format!("law {} has no choice of a volumetric part; omit it", model.name())),
        Some(c) if !c.options.contains(&option) => refuse(format!("take one of {}", c.options.join(", "))),
        Some(_) => Ok(option.into()),
    }
}

/// Stretches per mode at which a linear law is kept stable
const STABLE: u32 = 201;

/// As asked in every mode; else the fitted modes from rest over the fitted range.
fn stable_points(asked: Option<StretchRange>, modes: &[Mode], fitted: [f64; 2]) -> Vec<(Mode, f64)> {
    // Stability is a matter of the principal stretches: simple shear has those of the planar test
    let has = |m: &Mode| match m {
        Mode::Uniaxial => modes.contains(m),
        Mode::Planar => [Mode::Planar, Mode::SimpleShear, Mode::Biaxial].iter().any(|m| modes.contains(m)),
        _ => [Mode::Equibiaxial, Mode::Biaxial].iter().any(|m| modes.contains(m)),
    };
    let (modes, [low, high]) = match asked {
        Some(r) => (Mode::PULLED.to_vec(), [r.from.min(1.0), r.to.max(1.0)]),
        None => (Mode::PULLED.into_iter().filter(has).collect(), [fitted[0].min(1.0), fitted[1].max(1.0)]),
    };
    let at = |k: u32| low * (high / low).powf(f64::from(k) / f64::from(STABLE - 1));
    modes.iter().flat_map(|m| (0..STABLE).map(move |k| (*m, at(k)))).collect()
}

fn citation(source: &super::Source) -> String {
    let year = source.year.map(|y| y.to_string()).unwrap_or_default();
    let parts = [&source.authors, &source.title, &source.journal, &source.volume, &year, &source.pages, &source.url];
    parts.into_iter().filter(|p| !p.is_empty()).cloned().collect::<Vec<_>>().join(", ")
}

/// Rows of the range table at most
const RANGE_ROWS: usize = 24;

/// The fit repeated with every end of the range that the data offer (about 24 of them where there are more).
fn range_dependence(
    experiment: &Experiment,
    modes: &[Mode],
    from: f64,
    setting: &LawSetting,
    answer: &LawFit,
) -> Vec<RangeRow> {
    let own = |s: &&Sample| modes.contains(&s.mode) && s.stretch >= from && s.is_informative();
    let mut samples: Vec<Sample> = experiment.samples.iter().filter(own).copied().collect();
    samples.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
    let needed = setting.model.parameters().len() + 1;
    let last_of_stretch = |&n: &usize| n == samples.len() || samples[n].stretch > samples[n - 1].stretch;
    let ends: Vec<usize> = (needed..=samples.len()).filter(last_of_stretch).collect();
    let step = ends.len().div_ceil(RANGE_ROWS).max(1);
    let chosen = ends.iter().rev().step_by(step).rev();
    chosen
        .filter_map(|&n| {
            let part = &samples[..n];
            let found = solve(setting, part, Some(answer)).ok()?;
            let misfit = Misfit::of(&residuals(part, |s| setting.model.at(&found.values, s)))?;
            Some(RangeRow {
                to: part[n - 1].stretch,
                rows: n,
                parameters: found.identified.estimates,
                rms_pa: misfit.rms_pa,
                rms_relative: misfit.rms_relative,
            })
        })
        .collect()
}

/// Smallest and largest value of each parameter over the ranges that end within the fitted one.
fn range_spread(rows: &[RangeRow], answer: &LawFit, to: f64) -> Vec<[f64; 2]> {
    let spread = |(k, e): (usize, &super::Estimate)| {
        let inside = rows.iter().filter(|r| r.to <= to).map(|r| r.parameters[k].value);
        extent(inside.chain([e.value]))
    };
    answer.identified.estimates.iter().enumerate().map(spread).collect()
}
