//! Judgement of a fit: predictions, range of validity, warnings.

use super::certificate::{self, CASES};
use super::solve::{LawFit, ROUNDING, median};
use super::statistics::extent;
use super::{
    AuditKind, Estimate, Experiment, FitResult, FitWarning, Loss, Misfit, Mode, Model, Partner, Prediction,
    PredictionKind, Residual, SolverCheck, StableRange, StretchRange, Treatment, Validity, statistics,
};
use crate::material::FitTerms;

pub fn predictions(all: &[Residual], modes: &[Mode], range: StretchRange) -> Vec<Prediction> {
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

/// Data points before a range can be judged: the first ones are small, and mostly noise.
const LEAST_ROWS: usize = 3;

pub fn validity(all: &[Residual], modes: &[Mode], tolerance: f64) -> Validity {
    let side = |tension: bool| {
        let on_side =
            |r: &&Residual| modes.contains(&r.mode) && if tension { r.stretch > 1.0 } else { r.stretch < 1.0 };
        let mut rows: Vec<_> = all.iter().filter(on_side).collect();
        rows.sort_by(|a, b| (a.stretch - 1.0).abs().total_cmp(&(b.stretch - 1.0).abs()));
        let (mut r2, mut p2, mut reached) = (0.0, 0.0, None);
        let first = LEAST_ROWS.min(rows.len());
        for (k, row) in rows.iter().enumerate() {
            r2 += row.residual.powi(2);
            p2 += row.measured.powi(2);
            // A range beyond one where the fit was bad is not to be trusted.
            if k + 1 >= first {
                if r2 > tolerance * tolerance * p2 {
                    break;
                }
                reached = Some(row.stretch);
            }
        }
        reached
    };
    Validity { tolerance, compression_to: side(false), tension_to: side(true) }
}

/// Each of two tests at this level: together at most 5 % false alarms \[–\]
const LEVEL: f64 = 0.025;

pub fn warnings(
    result: &FitResult,
    answer: &LawFit,
    model: Model,
    experiment: &Experiment,
    tolerance: f64,
) -> Vec<FitWarning> {
    let mut found = Vec::new();
    if !result.unidentified.is_empty() {
        found.push(FitWarning::Unidentifiable { directions: result.unidentified.clone() });
    }
    found.extend(cycles(result));
    found.extend(may_be_zero(result));
    found.extend(held(answer));
    found.extend(unstable(result, model));
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
    let other = |p: &&Prediction| p.kind == PredictionKind::OtherModeInRange;
    for p in result.predictions.iter().filter(other).filter(|p| p.misfit.rms_relative > tolerance) {
        let Misfit { bias_relative, rms_relative, .. } = p.misfit;
        found.push(FitWarning::CrossMode { mode: p.mode, bias_relative, rms_relative });
    }
    if let ([mode], true) = (&result.modes[..], result.parameters.len() > 1 && experiment.modes().len() == 1) {
        found.push(FitWarning::OneMode { mode: *mode });
    }
    // Neighbours of several specimens differ by the scatter between them, and lines would not say of which file
    if result.loss == Loss::Squares && experiment.specimens.len() == 1 {
        found.extend(outliers(&result.residuals));
    }
    found.extend(result.scatter.as_ref().and_then(|s| {
        let one = s.specimens.iter().find(|one| Some(&one.file) == s.outlier.as_ref())?;
        Some(FitWarning::Specimen { file: one.file.clone(), level: one.level })
    }));
    found.extend(narrow(result));
    if let Some(SolverCheck::Starts { starts, agree: 1 }) = result.solver_check
        && starts > 2
    {
        found.push(FitWarning::Starts { starts });
    }
    let shear = model.law(&answer.values, 1e5 * answer.modulus).ok().map(|law| law.small_strain().mu);
    found.extend(shear.and_then(|mu| stiffness(mu, &experiment.stress_unit)));
    let doubts = experiment.audit.of(AuditKind::Doubt);
    found.extend(doubts.map(|e| FitWarning::Data { message: e.message.clone() }));
    found.extend(compressible(result, model, shear));
    found
}

/// The answer of a choice of data points that was not requested: the last loading, else every data point.
fn cycles(result: &FitResult) -> Option<FitWarning> {
    let unasked = || result.otherwise.iter().filter(|o| o.unasked);
    let other = unasked().find(|o| o.treatment == Treatment::LastLoading).or_else(|| unasked().next())?;
    let all: Vec<_> = other.parameters.iter().map(|e| format!("{} = {}", e.symbol, e.print(e.value))).collect();
    Some(FitWarning::Cycles { treatment: other.treatment, change: other.change, answer: all.join(", ") })
}

/// Constants with a finite interval that contains zero, of laws that do not need them.
fn may_be_zero(result: &FitResult) -> Option<FitWarning> {
    let holds_zero =
        |e: &&Estimate| e.std_error.is_finite() && e.value != 0.0 && e.interval[0] <= 0.0 && e.interval[1] >= 0.0;
    let symbols: Vec<_> = result.parameters.iter().filter(holds_zero).map(|e| e.symbol).collect();
    (!symbols.is_empty()).then_some(FitWarning::MayBeZero { symbols })
}

/// Ratio of the widths from which on the interval of the covariance is called too narrow \[–\]
const WIDER: f64 = 1.5;

/// The constant whose bootstrap interval is widest against the one of the covariance.
fn narrow(result: &FitResult) -> Option<FitWarning> {
    let b = result.bootstrap.as_ref()?;
    let width = |i: &[f64; 2]| i[1] - i[0];
    let of = |(e, i): (&Estimate, &[f64; 2])| (e.symbol, width(i) / width(&e.interval));
    let all = result.parameters.iter().zip(&b.intervals).filter(|(e, _)| width(&e.interval) > 0.0).map(of);
    let (symbol, ratio) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (ratio > WIDER).then(|| FitWarning::Narrow { symbol, ratio, drawn: b.drawn.clone() })
}

/// One warning per mode in which a cone holds the answer back.
fn held(answer: &LawFit) -> Vec<FitWarning> {
    let of = |mode: Mode| {
        let range = extent(answer.active.iter().filter(|(m, _)| *m == mode).map(|(_, s)| *s));
        (range[0] <= range[1]).then_some(FitWarning::Held { mode, range })
    };
    Mode::ALL.into_iter().filter_map(of).collect()
}

/// Modes in which material stability ends within the principal stretches that the fitted data points reach in their direction.
fn unstable(result: &FitResult, model: Model) -> Option<FitWarning> {
    let reach = result.stretch[1].max(1.0 / result.stretch[0]);
    let of = |r: &StableRange| {
        let (case, _) = CASES.into_iter().find(|(_, name)| *name == r.mode)?;
        let [low, high] = certificate::range(case, reach);
        let above = r.above.filter(|a| *a <= high);
        above.or(r.below.filter(|b| *b >= low)).map(|at| (r.mode, at))
    };
    let lost: Vec<_> = result.stability.iter().filter_map(of).collect();
    let linear = matches!(model.form.terms, FitTerms::Linear(_));
    (!lost.is_empty()).then_some(FitWarning::Unstable { lost, reach, linear })
}

/// Robust standard deviations off the neighbours, part of the own stress and of the largest one from which on a data point is an outlier \[–\]
const OFF: f64 = 8.0;
const PART: f64 = 0.5;
const SMALL: f64 = 0.05;
/// Fewer data points have no neighbourhood
const FEW: usize = 10;

/// Data points whose residual differs from the median of their neighbours' (two on each side, same mode): a misfit of the law is smooth, an
/// outlier is not.
fn outliers(rows: &[Residual]) -> Option<FitWarning> {
    let off = |k: usize| {
        let near = rows[k.saturating_sub(2)..(k + 3).min(rows.len())].iter().filter(|r| r.mode == rows[k].mode);
        (rows[k].residual - median(&near.map(|r| r.residual).collect::<Vec<_>>())).abs()
    };
    let all: Vec<f64> = (0..rows.len()).map(off).collect();
    if rows.len() < FEW {
        return None;
    }
    let largest = rows.iter().map(|r| r.measured.abs()).fold(0.0, f64::max);
    let limit = (OFF * 1.4826 * median(&all)).max(SMALL * largest);
    let is_off = |(r, off): (&Residual, &f64)| *off > limit && *off > PART * r.measured.abs();
    let mut lines: Vec<u64> = rows.iter().zip(&all).filter(|p| is_off(*p)).map(|(r, _)| r.line).collect();
    lines.sort_unstable();
    (!lines.is_empty()).then_some(FitWarning::Outliers { lines })
}

/// Relative change of the stiffness in tension by lateral stress below which there is no warning \[–\]
const STIFFNESS_CHANGE: f64 = 0.01;

/// A compressible law with the fitted shear modulus μ has E = 2(1 + ν)μ in tension where the data, taken as incompressible, had 3μ.
fn compressible(result: &FitResult, model: Model, mu: Option<f64>) -> Option<FitWarning> {
    let chosen = model.law.info.choices.iter().any(|c| c.name == "volumetric" && c.default.is_none());
    let needs_volumetric = chosen && result.volumetric.is_none();
    let nu = match (result.partner, mu) {
        (None, _) => return Some(FitWarning::NoPartner { volumetric: needs_volumetric }),
        (Some(Partner::Nu(nu)), _) => nu,
        (Some(Partner::Kappa(kappa)), Some(mu)) => (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu)),
        (Some(Partner::Kappa(_)), None) => return None,
    };
    let slope_relative = 2.0 * (1.0 + nu) / 3.0 - 1.0;
    (slope_relative.abs() > STIFFNESS_CHANGE).then_some(FitWarning::Compressible { nu, slope_relative })
}

/// Shear moduli of rubbers \[Pa\], from the softest silicones to nearly hard compounds
const RUBBER: std::ops::RangeInclusive<f64> = 1e3..=1e7;

/// A stiffness outside the range of rubbers: usually a unit that was misread.
fn stiffness(mu: f64, unit: &str) -> Option<FitWarning> {
    use crate::math::units::{Dimension, parse};
    if RUBBER.contains(&mu) {
        return None;
    }
    let pascal = |unit: &str| parse(&format!("1 {unit}"), Dimension::PRESSURE);
    // A force has another unit
    let read_as = pascal(unit).ok();
    let fits = |other: &&str| {
        pascal(other).ok().zip(read_as).is_some_and(|(factor, read_as)| RUBBER.contains(&(mu / read_as * factor)))
    };
    let instead = ["MPa", "kPa", "Pa"].into_iter().find(fits);
    Some(FitWarning::Stiffness { mu_pa: mu, unit: unit.into(), instead })
}
