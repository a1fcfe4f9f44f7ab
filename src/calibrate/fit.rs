//! From a request to a result: choose rows, fit, judge.

use super::misfit::residuals;
use super::neo_hookean::ROUNDING;
use super::result::INTERVAL_ASSUMPTION;
use super::{
    AuditKind, Experiment, FitCurves, FitError, FitOptions, FitRequest, FitResult, FitWarning, Fittable, LawFit,
    Misfit, Mode, Partner, Prediction, PredictionKind, RangeRow, Residual, Sample, StretchRange, Validity, fittable,
    statistics,
};

/// Reads a table and fits a law to it.
pub fn fit(request: &FitRequest) -> Result<FitResult, FitError> {
    // A misspelt law is refused before a file is read.
    fittable(&request.options.law)?;
    let stated = match request.options.modes[..] {
        [one] => Some(one),
        _ => None,
    };
    let experiment = Experiment::read(&request.data, request.card.as_deref(), &request.columns, stated)?;
    fit_experiment(&experiment, &request.options)
}

/// Fits a law to a table that was read already.
pub fn fit_experiment(experiment: &Experiment, options: &FitOptions) -> Result<FitResult, FitError> {
    let law = fittable(&options.law)?;
    let partner = options.partner.map(|p| p.check()).transpose()?;
    let modes = choose_modes(experiment, &options.modes)?;
    let range = options.range.unwrap_or(StretchRange::ALL);
    let is_fitted = |s: &Sample| modes.contains(&s.mode) && range.contains(s.stretch) && s.is_informative();
    let fitted: Vec<Sample> = experiment.samples.iter().copied().filter(is_fitted).collect();
    check_rows(experiment, &modes, range, &fitted, law)?;
    let answer = (law.fit)(&fitted)?;
    let values: Vec<f64> = answer.estimates.iter().map(|e| e.value).collect();
    let stress = |mode, stretch| (law.stress)(&values, mode, stretch);
    let own = residuals(&fitted, stress);
    let misfit = Misfit::of(&own).expect("the rows were counted");
    let samples: Vec<Sample> = experiment.samples.iter().copied().filter(Sample::is_informative).collect();
    let all = residuals(&samples, stress);
    let stretch = extent(own.iter().map(|r| r.stretch));
    let predictions = predictions(&all, &modes, range);
    let range_dependence = range_dependence(experiment, &modes, range.from, law);
    let mut result = FitResult {
        law: law.name,
        formula: law.formula,
        law_source: law.source,
        data: experiment.file.clone(),
        data_sha256: experiment.sha256.clone(),
        data_source: experiment.card.as_ref().map(|c| citation(&c.source)).filter(|c| !c.is_empty()),
        version: env!("CARGO_PKG_VERSION"),
        asked_range: options.range,
        stretch,
        rows: fitted.len(),
        interval_assumption: INTERVAL_ASSUMPTION,
        partner,
        misfit,
        validity: validity(&all, &modes, options.tolerance),
        range_spread: range_spread(&range_dependence, &answer, stretch[1]),
        range_dependence,
        solver_check: answer.check,
        warnings: vec![],
        curves: FitCurves::new(
            format!("{} fitted to {}", law.name, experiment.file),
            law,
            &values,
            &experiment.samples,
            &all,
            is_fitted,
            stretch,
        ),
        audit: experiment.audit.clone(),
        parameters: answer.estimates.clone(),
        predictions,
        residuals: own,
        modes,
    };
    result.warnings = warnings(&result, &answer, experiment, options.tolerance);
    Ok(result)
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

fn extent(stretches: impl Iterator<Item = f64>) -> [f64; 2] {
    stretches.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s), b.max(s)])
}

/// One row more than parameters, and stretches other than 1.
fn check_rows(
    experiment: &Experiment,
    modes: &[Mode],
    range: StretchRange,
    fitted: &[Sample],
    law: &Fittable,
) -> Result<(), FitError> {
    let needed = law.parameters.len() + 1;
    let rows = fitted.iter().filter(|s| s.stretch != 1.0).count();
    if rows >= needed {
        return Ok(());
    }
    let own = experiment.samples.iter().filter(|s| modes.contains(&s.mode)).map(|s| s.stretch);
    let [data_from, data_to] = extent(own);
    let (from, to) = if range == StretchRange::ALL { (data_from, data_to) } else { (range.from, range.to) };
    Err(FitError::TooFewRows { from, to, rows, needed, data_from, data_to })
}

fn citation(source: &super::Source) -> String {
    let year = source.year.map(|y| y.to_string()).unwrap_or_default();
    let parts = [&source.authors, &source.title, &source.journal, &source.volume, &year, &source.pages, &source.url];
    parts.into_iter().filter(|p| !p.is_empty()).cloned().collect::<Vec<_>>().join(", ")
}

fn predictions(all: &[Residual], modes: &[Mode], range: StretchRange) -> Vec<Prediction> {
    let mut found = Vec::new();
    let mut add = |kind, mode, rows: Vec<Residual>| {
        if let Some(misfit) = Misfit::of(&rows) {
            found.push(Prediction { kind, mode, stretch: extent(rows.iter().map(|r| r.stretch)), misfit });
        }
    };
    for mode in Mode::ALL {
        let pick = |keep: &dyn Fn(&Residual) -> bool| {
            all.iter().filter(|r| r.mode == mode && keep(r)).copied().collect::<Vec<_>>()
        };
        if modes.contains(&mode) {
            add(PredictionKind::OutsideRange, mode, pick(&|r| !range.contains(r.stretch)));
        } else {
            add(PredictionKind::OtherModeInRange, mode, pick(&|r| range.contains(r.stretch)));
            if range != StretchRange::ALL {
                add(PredictionKind::OtherMode, mode, pick(&|_| true));
            }
        }
    }
    found
}

/// Rows of the range table at most
const RANGE_ROWS: usize = 24;

/// The fit repeated with every end of the range that the data offer (about 24 of them where there are more).
fn range_dependence(experiment: &Experiment, modes: &[Mode], from: f64, law: &Fittable) -> Vec<RangeRow> {
    let own = |s: &&Sample| modes.contains(&s.mode) && s.stretch >= from && s.is_informative();
    let mut samples: Vec<Sample> = experiment.samples.iter().filter(own).copied().collect();
    samples.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
    let needed = law.parameters.len() + 1;
    let last_of_stretch = |&n: &usize| n == samples.len() || samples[n].stretch > samples[n - 1].stretch;
    let ends: Vec<usize> = (needed..=samples.len()).filter(last_of_stretch).collect();
    let step = ends.len().div_ceil(RANGE_ROWS).max(1);
    let chosen = ends.iter().rev().step_by(step).rev();
    chosen
        .filter_map(|&n| {
            let part = &samples[..n];
            let answer = (law.fit)(part).ok()?;
            let values: Vec<f64> = answer.estimates.iter().map(|e| e.value).collect();
            let misfit = Misfit::of(&residuals(part, |mode, stretch| (law.stress)(&values, mode, stretch)))?;
            Some(RangeRow {
                to: part[n - 1].stretch,
                rows: n,
                parameters: answer.estimates,
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
    answer.estimates.iter().enumerate().map(spread).collect()
}

fn validity(all: &[Residual], modes: &[Mode], tolerance: f64) -> Validity {
    let side = |tension: bool| {
        let on_side =
            |r: &&Residual| modes.contains(&r.mode) && if tension { r.stretch > 1.0 } else { r.stretch < 1.0 };
        let mut rows: Vec<_> = all.iter().filter(on_side).collect();
        rows.sort_by(|a, b| (a.stretch - 1.0).abs().total_cmp(&(b.stretch - 1.0).abs()));
        let (mut r2, mut p2, mut reached) = (0.0, 0.0, None);
        for row in rows {
            r2 += row.residual.powi(2);
            p2 += row.measured.powi(2);
            if r2 <= tolerance * tolerance * p2 {
                reached = Some(row.stretch);
            }
        }
        reached
    };
    Validity { tolerance, compression_to: side(false), tension_to: side(true) }
}

/// Each of two tests at this level: together at most 5 % false alarms [–]
const LEVEL: f64 = 0.025;

fn warnings(result: &FitResult, answer: &LawFit, experiment: &Experiment, tolerance: f64) -> Vec<FitWarning> {
    let mut found = Vec::new();
    let rms_relative = result.misfit.rms_relative;
    if rms_relative > ROUNDING {
        let signs: Vec<bool> =
            result.residuals.iter().filter(|r| r.residual != 0.0).map(|r| r.residual > 0.0).collect();
        let (runs, runs_p) = statistics::few_runs(&signs).unzip();
        let departure_p = answer.departure_p;
        if [runs_p, departure_p].into_iter().flatten().any(|p| p < LEVEL) {
            found.push(FitWarning::Systematic { runs, runs_p, departure_p, rms_relative });
        }
    }
    if rms_relative > tolerance {
        found.push(FitWarning::Misfit { rms_relative, tolerance });
    }
    for p in result.predictions.iter().filter(|p| p.kind == PredictionKind::OtherModeInRange) {
        if p.misfit.rms_relative > tolerance {
            let Misfit { bias_relative, rms_relative, .. } = p.misfit;
            found.push(FitWarning::CrossMode { mode: p.mode, bias_relative, rms_relative });
        }
    }
    found.extend(stiffness(result, &experiment.stress_unit));
    let doubts = experiment.audit.of(AuditKind::Doubt);
    found.extend(doubts.map(|e| FitWarning::Data { message: e.message.clone() }));
    found.extend(compressible(result));
    found
}

/// Lateral stress of a compressible law that changes the slope of tension by less than this is not worth a word [–]
const SLOPE: f64 = 0.01;

/// A compressible law with the fitted μ has E = 2(1 + ν)μ in tension where the data, taken as incompressible, had 3μ.
fn compressible(result: &FitResult) -> Option<FitWarning> {
    let mu = result.parameters.iter().find(|p| p.name == "mu").map(|p| p.value);
    let nu = match (result.partner, mu) {
        (None, _) => return Some(FitWarning::NoPartner),
        (Some(Partner::Nu(nu)), _) => nu,
        (Some(Partner::Kappa(kappa)), Some(mu)) => (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu)),
        (Some(Partner::Kappa(_)), None) => return None,
    };
    let slope_relative = 2.0 * (1.0 + nu) / 3.0 - 1.0;
    (slope_relative.abs() > SLOPE).then_some(FitWarning::Compressible { nu, slope_relative })
}

/// Shear moduli of rubbers [Pa], from the softest silicones to nearly hard compounds
const RUBBER: std::ops::RangeInclusive<f64> = 1e3..=1e7;

/// A stiffness that is none of a rubber: usually a unit that was misread.
fn stiffness(result: &FitResult, unit: &str) -> Option<FitWarning> {
    use crate::math::units::{Dimension, parse};
    let mu = result.parameters.iter().find(|p| p.name == "mu")?.value;
    if RUBBER.contains(&mu) {
        return None;
    }
    let pascal = |unit: &str| parse(&format!("1 {unit}"), Dimension::PRESSURE);
    let read_as = pascal(unit).expect("the unit was parsed when the table was read");
    let fits = |other: &&str| pascal(other).is_ok_and(|factor| RUBBER.contains(&(mu / read_as * factor)));
    let instead = ["MPa", "kPa", "Pa"].into_iter().find(fits);
    Some(FitWarning::Stiffness { mu_pa: mu, unit: unit.into(), instead })
}
