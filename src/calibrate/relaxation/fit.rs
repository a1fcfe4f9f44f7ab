//! From a request to a Prony series with intervals.

use super::error::RelaxationError;
use super::long_term::{self, Beyond};
use super::response::{Record, TestKind};
use super::result::{RelaxationFit, RelaxationTerm, RelaxationWarning};
use super::retardation::moduli;
use super::search::{self, Series, Weighted};
use super::table::{self, RelaxationRequest, TermChoice};
use crate::calibrate::constant_format::number_text;
use crate::calibrate::judgement::errors;
use crate::calibrate::{Bounded, CurveSet, FitSummary, MeasuredCurves};
use crate::math::statistics::{root, t_quantile};
use nalgebra::{DMatrix, DVector};

/// Residual relative to the response below which it is rounding \[–\]
const ROUNDING: f64 = 1e-9;
/// Largest number of data points in a figure
const SHOWN: usize = 2000;
/// Number of points of a curve
const POINTS: usize = 201;

/// Reads a table and fits a series to it.
pub fn fit_relaxation(request: &RelaxationRequest) -> Result<RelaxationFit, RelaxationError> {
    fit_record(&table::read(request)?, &request.terms)
}

/// Fits a series to a record.
pub fn fit_record(record: &Record, terms: &TermChoice) -> Result<RelaxationFit, RelaxationError> {
    check_rows(record, 3)?;
    check_ramp(record)?;
    let (times, criteria, free) = times(record, terms)?;
    let (series, weighted) = settled(record, &times, free)?;
    let constants = 1 + series.terms.len() * if free { 2 } else { 1 };
    check_rows(record, constants)?;
    if series.terms.is_empty() {
        let elastic = weighted.criterion(&series.residual, 1);
        return Err(elastic_response(record, elastic, elastic));
    }
    if record.kind == TestKind::Creep && series.constant <= 0.0 {
        return Err(RelaxationError::NoInstant { file: record.file.clone() });
    }
    let jacobian = jacobian(&weighted, &series, free);
    let target = record.values().component_mul(&weighted.weight).norm();
    let rounding = series.residual.norm() <= ROUNDING * target;
    let specimens = record.specimen_of_rows();
    let fitted = weighted.target() - &series.residual;
    let errors = errors::of_specimens(&jacobian, (&series.residual, &fitted), &specimens, &record.curves(), rounding);
    let native = native(&series, free);
    let answer = answer(record, &series, &native, free);
    let by = derivatives(record, &series, &native, free);
    let covariance = &by * &errors.covariance * by.transpose();
    let t = if errors.free > 0 { t_quantile(0.95, errors.free) } else { f64::INFINITY };
    let half = |k: usize| if rounding { 0.0 } else { t * root(covariance[(k, k)]) };
    let bounded = |k: usize| Bounded { value: answer[k], interval: [answer[k] - half(k), answer[k] + half(k)] };
    let n = series.terms.len();
    let term = |k: usize| {
        let (g, ln) = (3 + k, 3 + n + k);
        let tau = answer[ln].exp();
        RelaxationTerm {
            g: bounded(g).within(0.0, 1.0),
            tau: Bounded { value: tau, interval: [tau * (-half(ln)).exp(), tau * half(ln).exp()] },
        }
    };
    let beyond = Beyond { record, series: &series, weighted: &weighted };
    let lowest = if rounding { f64::INFINITY } else { beyond.lowest(&jacobian) };
    let mut fit = RelaxationFit {
        data: joined(record, |r| &r.file),
        data_sha256: joined(record, |r| &r.sha256),
        experiment: record.kind,
        version: env!("CARGO_PKG_VERSION"),
        rows: record.values().len(),
        span: record.span(),
        ramp: matches!(record.kind, TestKind::Relaxation | TestKind::Creep).then_some(record.ramp),
        unit: unit(record),
        instantaneous: bounded(0).within(0.0, f64::INFINITY),
        long_term: long_term::widened(bounded(1), lowest).within(0.0, f64::INFINITY),
        long_term_share: long_term::widened(bounded(2), lowest / answer[0]).within(0.0, 1.0),
        terms: (0..n).map(term).collect(),
        criteria,
        chosen_by: chosen_by(terms),
        dropped: series.dropped.clone(),
        errors: errors.model,
        degrees: errors.free,
        misfit: series.residual.norm() / target,
        warnings: vec![],
        summary: FitSummary {
            title: format!("Prony series from {}", joined(record, |r| &r.file)),
            answer: String::new(),
            constants: vec![],
            method: vec![],
            messages: vec![],
            notes: record.notes.clone(),
            file: "prony.toml".into(),
            curves: curves(record, &series, &weighted.weight),
        },
    };
    fit.warnings = warnings(record, &series, &fit, free);
    put_into_words(&mut fit);
    Ok(fit)
}

/// A text of every specimen, joined by commas.
fn joined(record: &Record, of: fn(&Record) -> &String) -> String {
    record.specimens().map(|r| of(r).as_str()).collect::<Vec<_>>().join(", ")
}

/// Describes the result in words.
fn put_into_words(fit: &mut RelaxationFit) {
    let (n, [first, last]) = (fit.terms.len(), fit.span);
    let plural = if n == 1 { "" } else { "s" };
    let mut answer = format!(
        "Prony series of {n} term{plural} from {} ({}): {} values, {} s to {} s, misfit {:.2} % rms",
        fit.data,
        fit.experiment.name(),
        fit.rows,
        number_text(first),
        number_text(last),
        100.0 * fit.misfit
    );
    if !fit.is_determined() {
        answer += "; the long-term modulus is not determined";
    }
    let unit = &fit.unit;
    // The held strain is not in the data of a relaxation.
    let of = match (fit.experiment, unit.as_str()) {
        (TestKind::Relaxation, "N") => "force at the held strain",
        (TestKind::Relaxation, "Pa") => "stress at the held strain",
        _ => "modulus",
    };
    let mut constants = vec![
        [format!("instantaneous {of}"), fit.instantaneous.words(unit)],
        [format!("long-term {of}"), fit.long_term.words(unit)],
        ["long-term share".into(), fit.long_term_share.words("–")],
    ];
    for (k, term) in fit.terms.iter().enumerate() {
        constants.push([format!("g{}", k + 1), term.g.words("–")]);
        constants.push([format!("tau{}", k + 1), term.tau.words("s")]);
    }
    let errors = fit.errors.words(fit.experiment.responses());
    let mut method = vec![format!("95 % intervals: {errors}; Student's t with {} degrees of freedom", fit.degrees)];
    method.push(format!("terms: {}", fit.chosen_by));
    if fit.criteria.len() > 1 {
        let least = fit.criteria.iter().copied().fold(f64::INFINITY, f64::min);
        let one = |(n, c): (usize, &f64)| format!("{:.1} with {n}", c - least);
        let all: Vec<String> = fit.criteria.iter().enumerate().map(one).collect();
        method.push(format!("criterion above its least value, by number of terms: {}", all.join(", ")));
    }
    let messages = fit.warnings.iter().map(ToString::to_string).collect();
    fit.summary = FitSummary { answer, constants, method, messages, ..fit.summary.clone() };
}

fn check_rows(record: &Record, constants: usize) -> Result<(), RelaxationError> {
    let rows = record.values().len();
    if rows >= constants + 2 {
        return Ok(());
    }
    Err(RelaxationError::TooFewRows { file: record.file.clone(), rows, constants })
}

/// Refuses a specimen whose data end before the loading does.
fn check_ramp(record: &Record) -> Result<(), RelaxationError> {
    let last = |r: &Record| r.x.last().copied().unwrap_or(0.0);
    let of_time = matches!(record.kind, TestKind::Relaxation | TestKind::Creep);
    match record.specimens().find(|r| of_time && r.ramp > 0.0 && last(r) <= r.ramp) {
        None => Ok(()),
        Some(r) => Err(RelaxationError::LongRamp { file: r.file.clone(), ramp: r.ramp, last: last(r) }),
    }
}

/// The error for data that an elastic response describes, with its criterion and that of the series.
fn elastic_response(record: &Record, elastic: f64, series: f64) -> RelaxationError {
    let remedy = match record.kind {
        TestKind::Relaxation | TestKind::Creep => {
            "check --ramp and --start; if they are right, the effect viscoelastic is not needed in this range of time"
        }
        TestKind::History | TestKind::Dynamic => "the effect viscoelastic is not needed in this range of time",
    };
    RelaxationError::Elastic { file: record.file.clone(), elastic, series, remedy }
}

/// Times of the series, the criterion of each number of terms that was tried, and whether the times are unknowns.
fn times(record: &Record, terms: &TermChoice) -> Result<(Vec<f64>, Vec<f64>, bool), RelaxationError> {
    let of = |series: &Series| series.terms.iter().map(|t| t.1).collect::<Vec<f64>>();
    match terms {
        TermChoice::Times(times) => Ok((times.clone(), vec![], false)),
        TermChoice::PerDecade(n) => {
            let [first, last] = record.span();
            let decades = (last / first).log10();
            let count = ((decades * *n as f64).round() as usize).max(1) + 1;
            let at = |k: usize| first * 10_f64.powf(decades * k as f64 / (count - 1) as f64);
            Ok(((0..count).map(at).collect(), vec![], false))
        }
        TermChoice::Number(n) => {
            let found = search::by_number(record, Some(*n))?;
            let criteria = found.iter().map(|f| f.1).collect();
            Ok((of(&found.last().expect("no term is tried first").0), criteria, true))
        }
        TermChoice::Evidence => {
            let found = search::by_number(record, None)?;
            let criteria: Vec<f64> = found.iter().map(|f| f.1).collect();
            let (best, (series, least)) =
                found.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1)).expect("no term is tried first");
            if best == 0 {
                let series = criteria.get(1).copied().unwrap_or(f64::INFINITY);
                return Err(elastic_response(record, *least, series));
            }
            Ok((of(series), criteria, true))
        }
    }
}

fn chosen_by(terms: &TermChoice) -> String {
    match terms {
        TermChoice::Evidence => {
            "times by least squares, their number by the Bayesian information criterion with autocorrelated errors"
                .into()
        }
        TermChoice::Number(n) => format!("{n} times by least squares, their number as asked"),
        TermChoice::Times(_) => "times as asked".into(),
        TermChoice::PerDecade(n) => format!("{n} times a decade of the data, as asked"),
    }
}

/// Largest number of updates of the weights of storage and loss
const AGAIN: usize = 8;

/// The series fitted to all data points; for a dynamic test with weights from the residuals of storage and of loss.
fn settled<'a>(record: &'a Record, times: &[f64], free: bool) -> Result<(Series, Weighted<'a>), RelaxationError> {
    let mut weighted = Weighted { record, weight: search::first_weights(record)? };
    let bounds = search::bounds(record);
    let solve = |w: &Weighted, times: &[f64]| if free { w.refined(times, bounds) } else { w.with_times(times) };
    let mut series = solve(&weighted, times)?;
    if record.kind != TestKind::Dynamic {
        return Ok((series, weighted));
    }
    let curves = record.curves();
    let rows_of = |loss: usize| curves.iter().skip(loss).step_by(2).flatten().copied().collect::<Vec<usize>>();
    let rows = [rows_of(0), rows_of(1)];
    for _ in 0..AGAIN {
        let [storage, loss] = [0, 1].map(|k| series.residual.select_rows(&rows[k]).norm());
        if storage.min(loss) <= ROUNDING * (rows[0].len() as f64).sqrt() {
            break;
        }
        let ratio = (storage / loss).clamp(0.1, 10.0);
        if (ratio - 1.0).abs() < 1e-4 {
            break;
        }
        rows[1].iter().for_each(|k| weighted.weight[*k] *= ratio);
        let times: Vec<f64> = if free { series.terms.iter().map(|t| t.1).collect() } else { times.to_vec() };
        series = solve(&weighted, &times)?;
    }
    Ok((series, weighted))
}

/// c₀, cᵢ and, if they are unknowns, ln τᵢ.
fn native(series: &Series, free: bool) -> Vec<f64> {
    let factors = std::iter::once(series.constant).chain(series.terms.iter().map(|t| t.0));
    factors.chain(series.terms.iter().filter(|_| free).map(|t| t.1.ln())).collect()
}

/// w ∂y/∂(c₀, cᵢ, ln τᵢ).
fn jacobian(weighted: &Weighted, series: &Series, free: bool) -> DMatrix<f64> {
    let times: Vec<f64> = series.terms.iter().map(|t| t.1).collect();
    let all = weighted.matrix(&times);
    if !free {
        return all;
    }
    const H: f64 = 1e-5;
    let moved = |by: f64| weighted.matrix(&times.iter().map(|t| t * by.exp()).collect::<Vec<_>>());
    let slope = (moved(H) - moved(-H)) / (2.0 * H);
    let mut columns: Vec<DVector<f64>> = all.column_iter().map(|c| c.into_owned()).collect();
    columns.extend(series.terms.iter().enumerate().map(|(k, t)| slope.column(k + 1) * t.0));
    DMatrix::from_columns(&columns)
}

/// G₀, G∞, G∞/G₀, gᵢ, ln τᵢ of the series of moduli.
fn answer(record: &Record, series: &Series, native: &[f64], free: bool) -> Vec<f64> {
    let n = series.terms.len();
    let time = |k: usize| if free { native[1 + n + k].exp() } else { series.terms[k].1 };
    let terms: Vec<(f64, f64)> = (0..n).map(|k| (native[1 + k], time(k))).collect();
    let (long, terms) = match record.kind {
        TestKind::Creep => {
            let (long, terms) = moduli(native[0], &terms);
            let stress = record.stress.map_or(1.0, f64::abs);
            (stress * long, terms.into_iter().map(|(e, tau)| (stress * e, tau)).collect())
        }
        _ => (native[0], terms),
    };
    let instant = long + terms.iter().map(|t| t.0).sum::<f64>();
    let shares = terms.iter().map(|t| t.0 / instant);
    [instant, long, long / instant].into_iter().chain(shares).chain(terms.iter().map(|t| t.1.ln())).collect()
}

/// ∂answer/∂native by central differences.
fn derivatives(record: &Record, series: &Series, native: &[f64], free: bool) -> DMatrix<f64> {
    let factors = 1 + series.terms.len();
    let columns: Vec<DVector<f64>> = (0..native.len())
        .map(|k| {
            let size = if k < factors { native.iter().take(factors).sum::<f64>() } else { 1.0 };
            let h = 1e-6 * if k < factors && native[k] > 0.0 { native[k] } else { size };
            let at = |by: f64| {
                let mut moved = native.to_vec();
                moved[k] += by;
                DVector::from_vec(answer(record, series, &moved, free))
            };
            (at(h) - at(-h)) / (2.0 * h)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

fn unit(record: &Record) -> String {
    match (record.kind, record.stress) {
        (TestKind::Creep, Some(_)) => "Pa".into(),
        (TestKind::Creep, None) => "of the held stress".into(),
        _ => record.unit.clone(),
    }
}

fn warnings(record: &Record, series: &Series, fit: &RelaxationFit, free: bool) -> Vec<RelaxationWarning> {
    let mut out = vec![];
    let [low, high] = search::bounds(record);
    let limit = |tau: &f64| free && ((tau / low).ln() < 1e-6 || (high / tau).ln() < 1e-6);
    let at_limit: Vec<f64> = series.terms.iter().map(|t| t.1).filter(limit).collect();
    let longest = at_limit.iter().any(|t| (high / t).ln() < 1e-6);
    out.extend(long_term::doubt(fit, longest));
    if fit.long_term.value <= 0.0 {
        out.push(RelaxationWarning::Liquid);
    }
    out.extend(at_limit.into_iter().map(|tau| RelaxationWarning::TimeAtLimit { tau }));
    let early = fit.terms.iter().filter(|t| t.tau.value < fit.span[0]).map(|t| t.tau.value);
    out.extend(early.map(|tau| RelaxationWarning::Early { tau, first: fit.span[0] }));
    out.extend(series.dropped.iter().map(|tau| RelaxationWarning::NoShare { tau: *tau }));
    out
}

/// Data and curve of each quantity for a figure.
fn curves(record: &Record, series: &Series, weight: &DVector<f64>) -> MeasuredCurves {
    let times: Vec<f64> = series.terms.iter().map(|t| t.1).collect();
    let factors: Vec<f64> = std::iter::once(series.constant).chain(series.terms.iter().map(|t| t.0)).collect();
    let dynamic = record.kind == TestKind::Dynamic;
    let grid = match record.kind {
        TestKind::History => record.clone(),
        _ => {
            let first = record.x.iter().copied().find(|x| *x > 0.0).unwrap_or(1.0);
            let last = record.x.last().copied().unwrap_or(1.0);
            let at = |k: usize| first * (last / first).powf(k as f64 / (POINTS - 1) as f64);
            Record { x: (0..POINTS).map(at).collect(), ..record.clone() }
        }
    };
    let grid = Record { more: vec![], ..grid };
    let one = DVector::from_element(if dynamic { 2 * grid.x.len() } else { grid.x.len() }, 1.0);
    let drawn = Weighted { record: &grid, weight: one }.matrix(&times) * DVector::from_vec(factors);
    let labels: &[&str] = if dynamic { &["storage modulus", "loss modulus"] } else { &["measured"] };
    let x_of = |x: f64| if dynamic { x / std::f64::consts::TAU } else { x };
    let (m, several) = (grid.x.len(), !record.more.is_empty());
    let mut sets = vec![];
    let mut from = 0;
    for r in record.specimens() {
        let n = r.x.len();
        let shown = || (0..n).step_by(n.div_ceil(SHOWN));
        sets.extend(labels.iter().enumerate().map(|(k, label)| {
            CurveSet {
                label: if several { format!("{label}, {}", r.file) } else { (*label).to_string() },
                measured: shown().map(|i| [x_of(r.x[i]), r.y[k * n + i]]).collect(),
                fitted: (0..m).step_by(m.div_ceil(SHOWN)).map(|i| [x_of(grid.x[i]), drawn[k * m + i]]).collect(),
                residuals: shown()
                    .map(|i| (i, from + k * n + i))
                    .map(|(i, at)| [x_of(r.x[i]), series.residual[at] / weight[at]])
                    .collect(),
                lines: vec![],
            }
        }));
        from += r.y.len();
    }
    let y_label = match record.kind {
        TestKind::Relaxation if record.unit == "N" => "force",
        TestKind::Relaxation if record.unit == "1" => "modulus",
        TestKind::Relaxation | TestKind::History => "stress",
        TestKind::Creep => "strain",
        TestKind::Dynamic => "modulus",
    };
    MeasuredCurves {
        x_label: if dynamic { "frequency [Hz]".into() } else { "time [s]".into() },
        y_label: y_label.into(),
        y_unit: match record.unit.as_str() {
            "of the law" => "Pa".into(),
            own => own.into(),
        },
        log_x: record.kind != TestKind::History,
        log_y: dynamic,
        sets,
    }
}
