//! Plateaus of a curve: the held states, and the final one.
//!
//! A plateau is a longest stretch of time in which all values except single outliers lie within ±tolerance of one level. Its mean and drift are
//! least-squares estimates with errors that may be correlated from one row to the next (see `calibrate::judgement::errors`).

use super::curve::{Curve, median_of_three};
use super::error::MotionError;
use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors::{self, ErrorModel};
use crate::math::statistics::{extent, t_quantile};
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

/// Smallest number of rows of a plateau
const LEAST: usize = 6;
/// Number of rows on each side of a single outlier
const AROUND: usize = 3;
/// Residual relative to the values below which it is rounding \[–\]
const ROUNDING: f64 = 1e-12;

/// Change over a plateau relative to its deviation below which it counts as zero \[–\]
const NOTHING: f64 = 0.1;

/// Rule by which plateaus are found.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateauRule {
    /// Shortest duration, as a share of that of the curve \[–\]
    pub least: f64,
    /// Half of the largest range of the values of a plateau, in the unit of the curve; if `None`, the larger of the two below
    pub tolerance: Option<f64>,
    /// Tolerance as a share of the range of the whole curve \[–\]
    pub fraction: f64,
    /// Tolerance as a multiple of the noise \[–\]
    pub factor: f64,
}

impl Default for PlateauRule {
    fn default() -> Self {
        Self { least: 0.02, tolerance: None, fraction: 0.005, factor: 5.0 }
    }
}

impl PlateauRule {
    /// Returns the shortest duration of a plateau of a curve \[s\].
    pub fn least_s(&self, curve: &Curve) -> f64 {
        self.least * (curve.time_s[curve.time_s.len() - 1] - curve.time_s[0])
    }

    /// Returns the tolerance for a curve, in its unit.
    pub fn tolerance_of(&self, curve: &Curve) -> f64 {
        self.tolerance.unwrap_or_else(|| (self.fraction * curve.range()).max(self.factor * curve.noise()))
    }
}

/// A held state.
#[derive(Clone, Debug, PartialEq)]
pub struct Plateau {
    /// First and last time \[s\]
    pub window_s: [f64; 2],
    pub rows: usize,
    /// Mean with its 95 % interval by Student's t
    pub mean: Bounded,
    /// Standard deviation of the values about the mean, √(Σ w(v − v̄)²/Σ w · n/(n − 1)) with the samples w of the n rows, for comparison with the
    /// values, a tolerance or a drift
    pub deviation: f64,
    /// Standard deviation of one sample, √(Σ w(v − v̄)²/(n − 1)), if the samples of a row are independent: that of a row of w samples is smaller by
    /// √w
    pub sample_deviation: f64,
    /// Standard uncertainty of the mean
    pub uncertainty: f64,
    /// Rate of change with its 95 % interval \[unit/s\]
    pub drift: Bounded,
    /// Correlation of neighbouring rows \[–\]
    pub correlation: f64,
    /// Number of independent rows with the same information about the mean
    pub effective: f64,
}

/// Reason to doubt the level of a plateau.
#[derive(Clone, Debug, PartialEq)]
pub enum PlateauDoubt {
    /// The interval of the drift does not contain zero, and the change is above a tenth of the deviation
    Drifts { change: f64, duration_s: f64, deviation: f64 },
}

impl Plateau {
    /// Evaluates the plateau over a given window \[s\].
    ///
    /// # Errors
    /// Fewer than six rows.
    pub fn over(curve: &Curve, window_s: [f64; 2]) -> Result<Self, MotionError> {
        let cut = curve.window(window_s);
        let n = cut.value.len();
        let [from_s, to_s] = window_s;
        if n < LEAST {
            return Err(MotionError::TooShort { found: n, needed: LEAST, from_s, to_s, step_s: curve.time_step() });
        }
        let total: f64 = cut.samples.iter().sum();
        let centre = cut.time_s.iter().zip(&cut.samples).map(|(t, w)| t * w).sum::<f64>() / total;
        let mean = cut.value.iter().zip(&cut.samples).map(|(v, w)| v * w).sum::<f64>() / total;
        let (level, level_errors) = line(&cut, |_| vec![1.0], mean);
        let (sloped, errors) = line(&cut, |t| vec![1.0, t - centre], mean);
        let squares: f64 = cut.value.iter().zip(&cut.samples).map(|(v, w)| w * (v - mean).powi(2)).sum();
        let (correlation, effective) = match level_errors.model {
            ErrorModel::Correlated { rho, effective, .. } => (rho, effective),
            _ => (0.0, n as f64),
        };
        let bounded = |value: f64, e: &errors::Errors, k: usize| {
            let half = if e.deviations[k] == 0.0 { 0.0 } else { t_quantile(0.95, e.free.max(1)) * e.deviations[k] };
            Bounded { value, interval: [value - half, value + half] }
        };
        Ok(Self {
            window_s: [cut.time_s[0], cut.time_s[n - 1]],
            rows: n,
            mean: bounded(mean + level[0], &level_errors, 0),
            deviation: (squares / total * n as f64 / (n - 1) as f64).sqrt(),
            sample_deviation: (squares / (n - 1) as f64).sqrt(),
            uncertainty: level_errors.deviations[0],
            drift: bounded(sloped[1], &errors, 1),
            correlation,
            effective,
        })
    }

    /// Duration \[s\].
    pub fn duration_s(&self) -> f64 {
        self.window_s[1] - self.window_s[0]
    }

    /// Returns the reason to doubt its level, if there is one.
    pub fn doubt(&self) -> Option<PlateauDoubt> {
        let [low, high] = self.drift.interval;
        let duration_s = self.duration_s();
        let change = self.drift.value * duration_s;
        let seen = (low > 0.0 || high < 0.0) && change.abs() > NOTHING * self.deviation;
        seen.then_some(PlateauDoubt::Drifts { change, duration_s, deviation: self.deviation })
    }
}

/// Least-squares fit of the values minus a level by functions of time, with the errors of the coefficients.
fn line(curve: &Curve, columns: impl Fn(f64) -> Vec<f64>, level: f64) -> (DVector<f64>, errors::Errors) {
    let n = curve.value.len();
    let rows: Vec<Vec<f64>> = curve.time_s.iter().map(|t| columns(*t)).collect();
    let root = |i: usize| curve.samples[i].sqrt();
    let jacobian = DMatrix::from_fn(n, rows[0].len(), |i, k| root(i) * rows[i][k]);
    let target = DVector::from_fn(n, |i, _| root(i) * (curve.value[i] - level));
    let factors =
        svd(jacobian.clone(), true, true).solve(&target, 1e-14).unwrap_or_else(|_| DVector::zeros(rows[0].len()));
    let residual = &target - &jacobian * &factors;
    let size = level.abs() * (n as f64).sqrt() + target.norm();
    let rounding = residual.norm() <= ROUNDING * size;
    let all: Vec<usize> = (0..n).collect();
    let mut errors = errors::of_curves(&jacobian, &residual, &[all], rounding);
    if rounding {
        errors.deviations.fill(0.0);
    }
    (factors, errors)
}

/// Returns all plateaus in order of time; they do not overlap.
pub fn plateaus(curve: &Curve, rule: &PlateauRule) -> Result<Vec<Plateau>, MotionError> {
    let tolerance = rule.tolerance_of(curve);
    let reach = reaches(&without_outliers(&curve.value, tolerance), tolerance);
    let least_s = rule.least_s(curve);
    let lasts = |from: usize, to: usize| curve.time_s[to - 1] - curve.time_s[from];
    // Longest first; the parts that an accepted plateau covers are cut from the others
    let mut candidates: Vec<(usize, usize)> = reach.iter().enumerate().map(|(from, to)| (from, *to)).collect();
    candidates.sort_by(|a, b| lasts(b.0, b.1).total_cmp(&lasts(a.0, a.1)).then(a.0.cmp(&b.0)));
    let mut found: Vec<(usize, usize)> = vec![];
    for (from, to) in candidates {
        let free = found.iter().all(|(a, b)| to <= *a || *b <= from);
        if to >= from + LEAST && lasts(from, to) >= least_s && free {
            found.push((from, to));
        }
    }
    found.sort_unstable();
    found.into_iter().map(|(from, to)| Plateau::over(curve, [curve.time_s[from], curve.time_s[to - 1]])).collect()
}

/// Returns the held and the final state: the first plateau, and the longest one that reaches the end of the curve. A single plateau is the final
/// state. A curve that ends in motion has no final state, and its held state must be the plateau at its start: a later one may be a turning point of
/// the motion.
///
/// # Errors
/// There is neither a held nor a final state.
pub fn held_and_final(curve: &Curve, rule: &PlateauRule) -> Result<[Option<Plateau>; 2], MotionError> {
    let tolerance = rule.tolerance_of(curve);
    let least_s = rule.least_s(curve);
    let n = curve.value.len();
    let reach = reaches(&without_outliers(&curve.value, tolerance), tolerance);
    let lasting = |from: usize, to: usize| {
        let window = [curve.time_s[from], curve.time_s[to - 1]];
        let lasts = to - from >= LEAST && window[1] - window[0] >= least_s;
        lasts.then(|| Plateau::over(curve, window)).transpose()
    };
    let until_end = |from| lasting(from, n);
    let last = reach.iter().position(|to| *to == n).map_or(Ok(None), until_end)?;
    let first = match &last {
        Some(last) => plateaus(curve, rule)?.into_iter().next().filter(|p| p.window_s[1] < last.window_s[0]),
        None => reach.first().map_or(Ok(None), |to| lasting(0, *to))?,
    };
    match [first, last] {
        [None, None] => Err(MotionError::NoPlateau { curve: curve.name.clone(), least_s, tolerance }),
        found => Ok(found),
    }
}

/// Returns the values with outliers removed: a value between neighbours at rest, three on each side within ±tolerance of one level, is replaced by
/// the median of itself and the two adjacent values; an outlier is thus single. In a vibration with few rows per period, neighbours are not at rest.
fn without_outliers(value: &[f64], tolerance: f64) -> Vec<f64> {
    let one = |k: usize| {
        if k == 0 || k + 1 == value.len() {
            return value[k];
        }
        let near = k.saturating_sub(AROUND)..value.len().min(k + AROUND + 1);
        let [low, high] = extent(near.filter(|j| *j != k).map(|j| value[j]));
        let (a, c) = (value[k - 1], value[k + 1]);
        if high - low > 2.0 * tolerance { value[k] } else { median_of_three(a, value[k], c) }
    };
    (0..value.len()).map(one).collect()
}

/// Returns, for each row, the end of the longest stretch starting there whose values have a range of at most twice the tolerance.
fn reaches(value: &[f64], tolerance: f64) -> Vec<usize> {
    let (mut low, mut high): (VecDeque<usize>, VecDeque<usize>) = (VecDeque::new(), VecDeque::new());
    let mut end = 0;
    let mut all = Vec::with_capacity(value.len());
    for from in 0..value.len() {
        while end < value.len() {
            let v = value[end];
            let least = low.front().map_or(v, |k| value[*k].min(v));
            let most = high.front().map_or(v, |k| value[*k].max(v));
            if most - least > 2.0 * tolerance {
                break;
            }
            while low.back().is_some_and(|k| value[*k] >= v) {
                low.pop_back();
            }
            while high.back().is_some_and(|k| value[*k] <= v) {
                high.pop_back();
            }
            low.push_back(end);
            high.push_back(end);
            end += 1;
        }
        all.push(end);
        for queue in [&mut low, &mut high] {
            if queue.front() == Some(&from) {
                queue.pop_front();
            }
        }
    }
    all
}
