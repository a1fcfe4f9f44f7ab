//! Fits the constants of softening by least squares: P = η(W(λ), W_m) P_law(λ), with the law of the first loading, and a permanent set if the data
//! show one.

use super::curves::sets;
use super::error::SofteningFitError;
use super::path::{CyclicPath, divide};
use super::result::{SofteningFit, summary};
use super::rows::FirstLoading;
use super::search::{Search, SofteningSolution};
use crate::calibrate::fit::{ChosenData, choose};
use crate::calibrate::judgement::errors::{self, Errors, directions};
use crate::calibrate::judgement::origin::Origin;
use crate::calibrate::{Bounded, CurveSet, Experiment, FitOptions, FitResult, Sample, SlackChoice, fit_experiment};
use crate::math::statistics::{root, t_quantile};
use nalgebra::{DMatrix, DVector};

/// Least number of rows below the largest stretch
const ROWS: usize = 6;
/// Ratio of the largest to the smallest peak W_m above which m and β are distinguished \[–\]
const APART: f64 = 1.2;
/// Residual relative to the stress below which it is rounding \[–\]
const ROUNDING: f64 = 1e-9;

/// Fits law and softening, with errors from the scatter of the data and without descriptions; also returns the curves of a figure.
pub(super) fn of_data(
    experiment: &Experiment,
    options: &FitOptions,
) -> Result<(FitResult, SofteningFit, Vec<CurveSet>), SofteningFitError> {
    let ChosenData { modes, range, .. } = choose(experiment, options)?;
    let path = divide(experiment, &modes, range)?;
    let rows = path.softened.len();
    if rows < ROWS {
        return Err(SofteningFitError::NoUnloading { file: experiment.file.clone(), rows, needed: ROWS });
    }
    let samples = [&path.virgin[..], &path.other].concat();
    let first = Experiment { samples, alternatives: vec![], ..experiment.clone() };
    let law = fit_experiment(&first, &FitOptions { slack: SlackChoice::No, ..options.clone() })?;
    let first = FirstLoading::of(&law)?;
    let (softening, sets) = judged(&law, &first, &path)?;
    Ok((law, softening, sets))
}

/// Bayesian information criterion (Schwarz) of a residual with first-order autocorrelated errors and `constants` constants.
fn criterion(residual: &DVector<f64>, curves: &[Vec<usize>], constants: usize, floor: f64) -> f64 {
    let rows = residual.len() as f64;
    let whole = |rho: f64| {
        let sum = errors::square(residual, curves, rho);
        rows * (sum.max(floor) / rows).ln() - curves.len() as f64 * (1.0 - rho * rho).ln()
    };
    (0..100).map(|k| whole(f64::from(k) / 100.0)).fold(f64::INFINITY, f64::min) + constants as f64 * rows.ln()
}

/// Residual of one answer with its error model, and the data that the intervals need.
struct Judged {
    answer: SofteningSolution,
    residual: DVector<f64>,
    errors: Errors,
    /// Half-widths of the 95 % intervals of all four unknowns, in units of the search
    half: [f64; 4],
}

/// The answer with a permanent set if its interval excludes zero, otherwise without.
fn judged(
    law: &FitResult,
    first: &FirstLoading,
    path: &CyclicPath,
) -> Result<(SofteningFit, Vec<CurveSet>), SofteningFitError> {
    let rows = &path.softened;
    let samples: Vec<Sample> = rows.iter().map(|r| r.sample).collect();
    let points = first.points(rows, 0.0)?;
    let [low, high] = points.iter().fold([f64::INFINITY, 0.0_f64], |[a, b], p| [a.min(p.peak), b.max(p.peak)]);
    let search = Search::new(first, rows, points, high, high > APART * low);
    let without = search.best();
    let size = samples.iter().map(|s| s.stress * s.stress).sum::<f64>();
    let (curves, floor) = (errors::curves(&samples), ROUNDING * ROUNDING * size);
    let constants = if search.beta { 3 } else { 2 };
    let softening = criterion(&search.residual(&without), &curves, constants, floor);
    let elastic = criterion(&search.residual(&search.elastic()), &curves, 0, floor);
    if elastic <= softening {
        return Err(SofteningFitError::None { file: law.data.clone(), elastic, softening });
    }
    let judge = |answer: SofteningSolution| judge(&search, law, answer, &samples, floor);
    let (plain, with) = (judge(without), judge(search.with_set(without)));
    let set =
        |j: &Judged| Bounded { value: j.answer.u[3], interval: [-1.0, 1.0].map(|s| j.answer.u[3] + s * j.half[3]) };
    // Zero is the end of the possible range: a set is shown if its interval excludes zero
    let shown = set(&with).interval[0] > 0.0 && with.residual.norm_squared() < plain.residual.norm_squared();
    let (found, measured) = if shown { (&with, set(&with)) } else { (&plain, set(&with).within(0.0, 1.0)) };
    let Judged { answer, residual, errors: own, half, .. } = found;
    let soft = search.softening(answer);
    let ends = |k: usize| [(answer.u[k] - half[k]).max(0.0), answer.u[k] + half[k]];
    let [low_s, high_s] = ends(0);
    let scale = Bounded { value: soft.m, interval: ends(1).map(|end| high * end) };
    // Cycles to one stretch determine only m + βW_m, of which any part may belong to β
    let (m, beta) = match search.beta {
        true => (scale, Bounded { value: soft.beta, interval: ends(2) }),
        false => {
            let most = scale.interval[1];
            (Bounded { interval: [0.0, most], ..scale }, Bounded { value: soft.beta, interval: [0.0, most / low] })
        }
    };
    let result = SofteningFit {
        data: law.data.clone(),
        data_sha256: law.data_sha256.clone(),
        law: law.law,
        constants: law.parameters.clone(),
        version: env!("CARGO_PKG_VERSION"),
        rows: rows.len(),
        first_loading: law.rows,
        r: Bounded { value: soft.r, interval: [1.0 / high_s.min(1.0), 1.0 / low_s] },
        m,
        beta,
        scale: (!search.beta).then_some(scale),
        set: measured,
        has_set: shown,
        at_bound: answer.at_bound(),
        errors: own.model,
        degrees: own.free,
        misfit: residual.norm() / size.sqrt(),
        largest_energy: high,
        lost: soft.lost(high) / high,
        summary: summary(),
    };
    let fitted: Vec<f64> = samples.iter().zip(residual.iter()).map(|(s, r)| s.stress - r).collect();
    Ok((result, sets(path, first, &soft, answer.u[3], &fitted)))
}

/// Intervals of an answer. With B = (JᵀJ)⁻¹Jᵀ for its unknowns and K = ∂(ηP_law)/∂θ for the constants θ of the law, an error δθ of the law moves the
/// unknowns by −BKδθ: half² = (t d)² + (t_θ)² (BK Σ_θ KᵀBᵀ), with the quantiles t and t_θ of the two fits, which use different data points.
fn judge(search: &Search, law: &FitResult, answer: SofteningSolution, samples: &[Sample], floor: f64) -> Judged {
    let residual = search.residual(&answer);
    let rounding = residual.norm_squared() <= floor;
    let free = search.free(&answer);
    let j = search.jacobian(&answer).select_columns(&free);
    let fitted = DVector::from_fn(samples.len(), |i, _| samples[i].stress - residual[i]);
    let errors = errors::of(&j, &residual, &fitted, &Origin::of(samples), rounding);
    let quantile = |free: usize| if free > 0 { t_quantile(0.95, free) } else { f64::INFINITY };
    let moved = directions(&j).inverse() * search.by_law(&answer);
    let p = law.covariance.len();
    let covariance = DMatrix::from_fn(p, p, |a, b| law.covariance[a][b]);
    let of_law = &moved * covariance * moved.transpose();
    let one = |k: usize| {
        let Some(at) = free.iter().position(|f| *f == k) else { return 0.0 };
        let own = if rounding { 0.0 } else { quantile(errors.free) * errors.deviations[at] };
        own.hypot(quantile(law.degrees) * root(of_law[(at, at)]))
    };
    let half = std::array::from_fn(one);
    Judged { answer, residual, errors, half }
}
