//! Determines the times and the number of terms of a series from the data.
//!
//! For N = 0, 1, 2, … terms the times are found by least squares with nonnegative factors: Levenberg–Marquardt in ln τ on the residual with the
//! factors eliminated (Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973), from several starts. The number of terms minimises the Bayesian information
//! criterion (Schwarz, Ann. Statist. 6, 1978) with first-order autocorrelated errors,
//!
//! n ln(S(ρ)/n) − ln(1 − ρ²) + k ln n, S(ρ) = (1 − ρ²)r₁² + Σ(rⱼ − ρ rⱼ₋₁)²
//!
//! summed over the curves, with the most likely ρ ≥ 0 of each and k = 1 + 2N constants: a pattern that correlated noise explains adds no term. ρ
//! leaves at least three independent values of a curve, n(1 − ρ)/(1 + ρ) ≥ 3; otherwise noise would explain its mean too, such as the loss modulus of
//! every dynamic test.
//!
//! Errors of a dynamic test are proportional to the moduli of a series with two times per decade, fitted to the test: measured moduli would couple
//! each weight to the error of its own value, and with them the relative residual of a loss modulus against zero would be the same everywhere.
//!
//! Limits: the search uses at most [`ROWS`] data points of all specimens, spaced in proportion to ln t; the answer is refined with all of them. No
//! time is shorter than a third of the first or longer than three times the last one that the data resolve.

use super::error::RelaxationError;
use super::response::{Record, TestKind};
use crate::math::nonnegative::dense_weights;
use nalgebra::{DMatrix, DVector};

/// Largest number of data points in the search
const ROWS: usize = 1000;
/// Largest number of terms
const MOST: usize = 12;
/// Factor by which the times may exceed the range of the data
const BEYOND: f64 = 3.0;
/// Ratio of two times below which they count as one
const SAME: f64 = 1.02;
/// Largest number of iterations of a refinement, and the relative decrease of the sum of squares below which it ends
const ITERATIONS: usize = 60;
const SETTLED: f64 = 1e-13;
/// Residual relative to the response below which it is rounding \[–\]
const ROUNDING: f64 = 1e-10;
/// Least number of independent values of a curve that a correlation leaves
const LEFT: f64 = 3.0;
/// Number of times per decade of the series that weights a dynamic test, and the number of its fits
const DENSE: f64 = 2.0;
const PASSES: usize = 2;

/// A series with its residual.
#[derive(Clone, Debug)]
pub struct Series {
    /// c₀
    pub constant: f64,
    /// (cᵢ, τᵢ \[s\]), ascending in τ; cᵢ > 0
    pub terms: Vec<(f64, f64)>,
    /// Times without a factor \[s\]
    pub dropped: Vec<f64>,
    /// w(y − series)
    pub residual: DVector<f64>,
}

/// A weighted record.
pub struct Weighted<'a> {
    pub record: &'a Record,
    /// w of each value
    pub weight: DVector<f64>,
}

impl Weighted<'_> {
    /// w y of each value.
    pub fn target(&self) -> DVector<f64> {
        self.record.values().component_mul(&self.weight)
    }

    /// w φ of each time, φ₀ first.
    pub fn matrix(&self, times: &[f64]) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = std::iter::once(None)
            .chain(times.iter().map(|t| Some(*t)))
            .map(|tau| self.record.column(tau).component_mul(&self.weight))
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// Factors at these times, with the residual. The columns of `near` have positive factors at similar times.
    fn factors(&self, times: &[f64], near: Option<&[usize]>) -> Result<(DVector<f64>, DVector<f64>), RelaxationError> {
        let (a, y) = (self.matrix(times), self.target());
        let c = dense_weights(&a, &y, near).map_err(|e| RelaxationError::Solver { status: e.status })?;
        let residual = y - a * &c;
        Ok((c, residual))
    }

    /// The series with these times; times without a factor are dropped.
    pub fn with_times(&self, times: &[f64]) -> Result<Series, RelaxationError> {
        let mut times = times.to_vec();
        times.sort_by(f64::total_cmp);
        let (c, residual) = self.factors(&times, None)?;
        let of = |kept: bool| {
            let own = times.iter().zip(c.iter().skip(1)).filter(move |(_, c)| (**c > 0.0) == kept);
            own.map(|(t, c)| (*c, *t)).collect::<Vec<_>>()
        };
        Ok(Series { constant: c[0], terms: of(true), dropped: of(false).iter().map(|d| d.1).collect(), residual })
    }

    /// The series after moving the times to the nearest minimum, within bounds.
    pub fn refined(&self, times: &[f64], [low, high]: [f64; 2]) -> Result<Series, RelaxationError> {
        let clamp = |u: f64| u.clamp(low.ln(), high.ln());
        let natural = |u: &[f64]| u.iter().map(|u| u.exp()).collect::<Vec<f64>>();
        let mut u: Vec<f64> = times.iter().map(|t| clamp(t.ln())).collect();
        let (mut c, mut r) = self.factors(&natural(&u), None)?;
        let (mut damping, size) = (1e-3, self.target().norm_squared());
        for _ in 0..ITERATIONS {
            if u.is_empty() || r.norm_squared() <= ROUNDING * ROUNDING * size {
                break;
            }
            let positive: Vec<usize> = (0..c.len()).filter(|k| c[*k] > 0.0).collect();
            let mut columns = Vec::new();
            for k in 0..u.len() {
                let h = if u[k] + 1e-5 > high.ln() { -1e-5 } else { 1e-5 };
                let mut moved = u.clone();
                moved[k] += h;
                columns.push((self.factors(&natural(&moved), Some(&positive))?.1 - &r) / h);
            }
            let j = DMatrix::from_columns(&columns);
            let (h, g) = (j.tr_mul(&j), j.tr_mul(&r));
            let before = r.norm_squared();
            let mut better = false;
            while damping < 1e8 {
                let mut damped = h.clone();
                (0..u.len()).for_each(|k| damped[(k, k)] += damping * h[(k, k)].max(1e-12 * size));
                let Some(step) = damped.cholesky().map(|c| c.solve(&g)) else {
                    damping *= 10.0;
                    continue;
                };
                let next: Vec<f64> = u.iter().zip(&step).map(|(u, s)| clamp(u - s.clamp(-1.5, 1.5))).collect();
                let (factors, residual) = self.factors(&natural(&next), Some(&positive))?;
                if residual.norm_squared() < before {
                    (u, c, r, better) = (next, factors, residual, true);
                    damping = (0.2 * damping).max(1e-9);
                    break;
                }
                damping *= 10.0;
            }
            if !better || before - r.norm_squared() <= SETTLED * before {
                break;
            }
        }
        self.with_times(&merged(natural(&u)))
    }

    /// Information criterion of a series with `constants` constants.
    pub fn criterion(&self, residual: &DVector<f64>, constants: usize) -> f64 {
        let floor = ROUNDING * ROUNDING * self.target().norm_squared();
        let rows = residual.len() as f64;
        let one = |curve: &Vec<usize>| {
            let n = curve.len() as f64;
            let r: Vec<f64> = curve.iter().map(|k| residual[*k]).collect();
            let at = |rho: f64| {
                let pairs: f64 = r.windows(2).map(|w| (w[1] - rho * w[0]).powi(2)).sum();
                let sum = ((1.0 - rho * rho) * r[0] * r[0] + pairs).max(floor / rows * n);
                n * (sum / n).ln() - (1.0 - rho * rho).ln()
            };
            let most = ((n - LEFT) / (n + LEFT)).clamp(0.0, 0.99);
            (0..100).map(|k| at(most * f64::from(k) / 99.0)).fold(f64::INFINITY, f64::min)
        };
        self.record.curves().iter().map(one).sum::<f64>() + constants as f64 * rows.ln()
    }
}

/// Times in ascending order; of those that are nearly equal only one is kept.
fn merged(mut times: Vec<f64>) -> Vec<f64> {
    times.sort_by(f64::total_cmp);
    times.dedup_by(|b, a| *b < SAME * *a);
    times
}

/// Shortest and longest time that a series may have.
pub fn bounds(record: &Record) -> [f64; 2] {
    let [first, last] = record.span();
    [first.max(record.ramp / 10.0) / BEYOND, last * BEYOND]
}

/// Initial weights: equal ones; for a dynamic test those of errors proportional to each fitted modulus, for both storage and loss.
pub fn first_weights(record: &Record) -> Result<DVector<f64>, RelaxationError> {
    let all = record.values();
    if record.kind != TestKind::Dynamic {
        let largest = all.amax();
        return Ok(all.map(|_| 1.0 / largest));
    }
    let [low, high] = bounds(record);
    let times = spread(low, high, DENSE);
    let mut weighted = Weighted { record, weight: all.map(|y| 1.0 / y.abs()) };
    for _ in 0..PASSES {
        let residual = weighted.with_times(&times)?.residual;
        let weight = DVector::from_fn(all.len(), |k, _| {
            let fitted = all[k] - residual[k] / weighted.weight[k];
            1.0 / if fitted > 0.0 { fitted } else { all[k].abs() }
        });
        weighted.weight = weight;
    }
    Ok(weighted.weight)
}

/// Times from `low` to `high`, evenly spaced in ln τ, with at least `a_decade` in each decade.
fn spread(low: f64, high: f64, a_decade: f64) -> Vec<f64> {
    let steps = ((high / low).log10() * a_decade).ceil().max(1.0);
    (0..=steps as usize).map(|k| low * (high / low).powf(k as f64 / steps)).collect()
}

/// The best series for each number of terms that was tried, with its criterion, starting without terms.
pub fn by_number(record: &Record, asked: Option<usize>) -> Result<Vec<(Series, f64)>, RelaxationError> {
    let rows = ROWS / record.specimens().count().min(ROWS / 100);
    let thin = levelled(record.thinned(&|r| spaced(r, rows)))?;
    let weighted = Weighted { record: &thin, weight: first_weights(&thin)? };
    let bounds = bounds(&thin);
    let none = weighted.with_times(&[])?;
    let criterion = weighted.criterion(&none.residual, 1);
    let mut found = vec![(none, criterion)];
    let most = asked.unwrap_or(MOST).min(thin.values().len().saturating_sub(3) / 2);
    let mut last = vec![];
    for n in 1..=most {
        let mut best: Option<Series> = None;
        for begin in beginnings(n, &last, bounds) {
            let series = weighted.refined(&begin, bounds)?;
            if best.as_ref().is_none_or(|b| series.residual.norm() < b.residual.norm()) {
                best = Some(series);
            }
        }
        let best = best.expect("every number of terms has a beginning");
        let count = best.terms.len();
        last = best.terms.iter().map(|t| t.1).collect();
        let criterion = weighted.criterion(&best.residual, 1 + 2 * count);
        found.push((best, criterion));
        // The search ends after three further terms without a gain, or with a term without a factor
        let least = found.iter().map(|f| f.1).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |f| f.0);
        if asked.is_none() && (count < n || n >= least + 3) {
            break;
        }
    }
    Ok(found)
}

/// Initial times: evenly spaced in ln τ, and those of the previous series with one more in each gap.
fn beginnings(n: usize, last: &[f64], [low, high]: [f64; 2]) -> Vec<Vec<f64>> {
    let (low, high) = (low.ln(), high.ln());
    let even = (0..n).map(|k| (low + (high - low) * (k as f64 + 0.5) / n as f64).exp()).collect();
    let mut out = vec![even];
    if last.len() + 1 == n {
        let ends: Vec<f64> = std::iter::once(low).chain(last.iter().map(|t| t.ln())).chain([high]).collect();
        for gap in ends.windows(2) {
            out.push(last.iter().copied().chain([(0.5 * (gap[0] + gap[1])).exp()]).collect());
        }
    }
    out
}

/// Specimens brought to one level: each is divided by its factor relative to a series for all specimens with one time per decade. Differences in
/// stiffness say nothing about the number of terms, and would hide a small term.
fn levelled(mut record: Record) -> Result<Record, RelaxationError> {
    if record.more.is_empty() {
        return Ok(record);
    }
    let [first, last] = bounds(&record);
    let times = spread(first, last, 1.0);
    let weighted = Weighted { record: &record, weight: first_weights(&record)? };
    let target = weighted.target();
    let fitted = &target - weighted.with_times(&times)?.residual;
    let specimen = record.specimen_of_rows();
    let factor = |one: usize| {
        let own = || (0..specimen.len()).filter(|i| specimen[*i] == one);
        own().map(|i| target[i] * fitted[i]).sum::<f64>() / own().map(|i| fitted[i] * fitted[i]).sum::<f64>()
    };
    let factors: Vec<f64> = (0..=record.more.len()).map(factor).map(|f| if f > 0.0 { f } else { 1.0 }).collect();
    record.y.iter_mut().for_each(|y| *y /= factors[0]);
    record.more.iter_mut().zip(&factors[1..]).for_each(|(r, f)| r.y.iter_mut().for_each(|y| *y /= f));
    Ok(record)
}

/// Data points of a specimen that the search uses: all, or `most` of them, half of them spaced evenly in the logarithm of x and half by number.
fn spaced(record: &Record, most: usize) -> Vec<usize> {
    let n = record.x.len();
    if n <= most || record.kind == TestKind::History {
        return (0..n).collect();
    }
    let from = record.x.iter().copied().find(|x| *x > 0.0).unwrap_or(1.0).ln();
    let to = record.x[n - 1].max(f64::MIN_POSITIVE).ln();
    let half = most / 2;
    let by_log = (0..half).map(|k| {
        let x = (from + (to - from) * k as f64 / (half - 1) as f64).exp();
        record.x.partition_point(|own| *own < x).min(n - 1)
    });
    let mut rows: Vec<usize> = by_log.chain((0..half).map(|k| k * (n - 1) / (half - 1))).collect();
    rows.sort_unstable();
    rows.dedup();
    rows
}
