//! A recorded quantity over time, and comparisons of two of them.

use crate::math::statistics::{extent, larger, range};
use crate::report::numbers::{capital, percent};
use crate::scene::{ExtremeKind, extreme, extreme_on};
use crate::study::store::record::{Series, StoredCase, StudyRecord};
use crate::wording::count;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// One column over time.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Curve {
    /// \[samples\] Time \[s\]
    pub t: Vec<f64>,
    /// \[samples\] Value
    pub f: Vec<f64>,
}

impl Curve {
    /// Returns the column of a stored series; `None` if it is absent, shorter than two samples or not finite, or if the times do not increase.
    pub fn of(series: &Series, column: &str) -> Option<Self> {
        let f = series.columns.get(column)?;
        let n = f.len().min(series.t_s.len());
        let ok = n >= 2
            && f[..n].iter().chain(&series.t_s[..n]).all(|v| v.is_finite())
            && series.t_s[..n].windows(2).all(|w| w[1] > w[0]);
        ok.then(|| Self { t: series.t_s[..n].to_vec(), f: f[..n].to_vec() })
    }

    /// Interpolates linearly; the value is constant outside the samples.
    pub fn at(&self, t: f64) -> f64 {
        let k = self.t.partition_point(|v| *v < t).clamp(1, self.t.len() - 1);
        let (a, b) = (self.t[k - 1], self.t[k]);
        let s = ((t - a) / (b - a)).clamp(0.0, 1.0);
        self.f[k - 1] * (1.0 - s) + self.f[k] * s
    }

    /// The sample times of `self` within the time span of `other` \[s\].
    pub fn common(&self, other: &Self) -> Vec<f64> {
        let (Some(first), Some(last)) = (other.t.first(), other.t.last()) else { return vec![] };
        let slack = 1e-9 * last.abs();
        self.t.iter().copied().filter(|t| *t >= first - slack && *t <= last + slack).collect()
    }

    /// Returns ∮ f dx over the last cycle of x, and its ratio to the area of the bounding box of that cycle. A cycle ends with the curve and starts
    /// where x was last at the same value (the nearest one within 1 % of its range, since a slack cable does not return exactly), and x covers at least
    /// 90 % of its range in between. `None` if there is no such cycle, or if `x` has different sample times.
    pub fn hysteresis(&self, x: &Self) -> Option<(f64, f64)> {
        if self.t != x.t {
            return None;
        }
        let range = |v: &[f64]| range(v.iter().copied());
        let (whole, end) = (range(&x.f), x.f.len() - 1);
        let off = |k: usize| (x.f[k] - x.f[end]).abs();
        let back = |k: &usize| off(*k) <= 0.01 * whole && range(&x.f[*k..]) >= 0.9 * whole;
        let last = (0..end).rev().find(back).filter(|_| whole > 0.0)?;
        let start = (0..=last).rev().take_while(back).min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
        let area: f64 = (start..end).map(|k| 0.5 * (self.f[k] + self.f[k + 1]) * (x.f[k + 1] - x.f[k])).sum();
        let around = range(&x.f[start..]) * range(&self.f[start..]);
        (around > 0.0).then_some((area, area.abs() / around))
    }

    /// Value of largest magnitude, with its sign.
    pub fn peak(&self) -> f64 {
        self.f.iter().copied().fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m })
    }

    /// The initial value, or 0 if it is small compared with the largest one. A quantity that does not start at zero, such as a position, is judged by
    /// its changes.
    pub fn start(&self) -> f64 {
        starts_elsewhere(self.f[0], self.peak()).unwrap_or(0.0)
    }

    /// Largest change from the start, with its sign; for a curve that starts at zero, the value of largest magnitude.
    pub fn largest_change(&self) -> f64 {
        let start = self.start();
        self.f.iter().map(|v| v - start).fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m })
    }

    /// ‖f − f₀‖₂ with f₀ of [`Curve::start`]: the norm to which distances of curves are relative.
    pub fn size_of_changes(&self) -> f64 {
        let start = self.start();
        let changes: Vec<f64> = self.f.iter().map(|v| v - start).collect();
        l2(&self.t, &changes)
    }

    /// Error of linear interpolation between the samples: a quarter of the defect when every second sample is left out.
    pub fn interpolation_error(&self) -> f64 {
        (1..self.t.len().saturating_sub(1))
            .map(|k| {
                let s = (self.t[k] - self.t[k - 1]) / (self.t[k + 1] - self.t[k - 1]);
                (self.f[k] - (1.0 - s) * self.f[k - 1] - s * self.f[k + 1]).abs() / 4.0
            })
            .fold(0.0, larger)
    }

    /// Largest |f(t + T) − f(t)| over the last two cycles, relative to the range of f. The period T is the time between the last two maxima of separate
    /// cycles; `None` with fewer than two cycles.
    pub fn cycle_defect(&self) -> Option<f64> {
        let [lo, hi] = extent(self.f.iter().copied());
        let (low, high) = (lo + 0.3 * (hi - lo), lo + 0.7 * (hi - lo));
        // One peak per excursion above `high`; a new one counts only after f has been below `low`
        let (mut peaks, mut armed): (Vec<usize>, bool) = (vec![], true);
        for (k, f) in self.f.iter().enumerate() {
            match (*f > high, armed) {
                (true, true) => {
                    peaks.push(k);
                    armed = false;
                }
                (true, false) if *f > self.f[*peaks.last()?] => *peaks.last_mut()? = k,
                _ if *f < low => armed = true,
                _ => {}
            }
        }
        let [.., a, b] = peaks[..] else { return None };
        let period = self.t[b] - self.t[a];
        let end = *self.t.last()?;
        let defect = (self.t.iter())
            .filter(|t| **t >= end - 2.0 * period - 1e-9 * period && **t <= end - period + 1e-9 * period)
            .map(|t| (self.at(t + period) - self.at(*t)).abs())
            .fold(0.0, larger);
        (hi > lo && end - self.t[0] >= 2.0 * period * (1.0 - 1e-6)).then_some(defect / (hi - lo))
    }
}

/// √(1/T ∫ d² dt) by the trapezoidal rule.
pub fn l2(t: &[f64], d: &[f64]) -> f64 {
    let sum: f64 = (1..t.len()).map(|k| 0.5 * (t[k] - t[k - 1]) * (d[k].powi(2) + d[k - 1].powi(2))).sum();
    (sum / (t[t.len() - 1] - t[0])).sqrt()
}

/// Largest lag that the first order can resolve, relative to the time scale of the curve \[–\].
const FIRST_ORDER: f64 = 0.5;
/// If the slope is proportional to the curve within this relative tolerance, a lag cannot be told from a change of amplitude \[–\].
const ALIKE: f64 = 1e-6;

/// Lag of `f` behind `g` \[s\]; `None` if the curves differ by more than a small shift, or if a shift cannot be told from a factor.
pub fn lag(t: &[f64], f: &[f64], g: &[f64]) -> Option<f64> {
    let (mut gg, mut gs, mut ss, mut dg, mut ds, mut sum) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for k in 1..t.len() {
        let dt = t[k] - t[k - 1];
        let slope = (g[k] - g[k - 1]) / dt;
        let change = |y: &[f64]| 0.5 * (y[k] + y[k - 1]) - g[0];
        let mean = change(g);
        let difference = change(f) - mean;
        gg += mean * mean * dt;
        gs += mean * slope * dt;
        ss += slope * slope * dt;
        dg += difference * mean * dt;
        ds += difference * slope * dt;
        sum += mean * dt;
    }
    let determinant = gg * ss - gs * gs;
    if determinant.partial_cmp(&(ALIKE * gg * ss)) != Some(Ordering::Greater) {
        return None;
    }
    // + 0 avoids a negative zero
    let lag = (gs * dg - gg * ds) / determinant + 0.0;
    let varies = ((gg - sum * sum / (t[t.len() - 1] - t[0])).max(0.0) / ss).sqrt();
    (lag.abs() <= FIRST_ORDER * varies).then_some(lag)
}

/// Peak of a quantity: the value farthest from the first one, over all recorded times of the run. A quantity that does not start at zero, such as the
/// length of a cable, is judged by its largest change.
pub fn peak(case: &StoredCase, quantity: &str) -> Option<f64> {
    let farthest = farthest(case, quantity)?;
    Some(farthest - start(case, quantity).unwrap_or(0.0)).filter(|v| v.is_finite())
}

/// The value farthest from the first one. A series may hold only some of the recorded times of the run; the extreme over all of them is in the record.
fn farthest(case: &StoredCase, quantity: &str) -> Option<f64> {
    let recorded = case.record.probes.get(quantity).map(|p| p.peak);
    recorded.or_else(|| Some(extreme(Curve::of(&case.series, quantity)?.f)?.value))
}

/// The initial value of a quantity, if it is not negligible compared with its largest value.
pub fn start(case: &StoredCase, quantity: &str) -> Option<f64> {
    let first = *case.series.columns.get(quantity)?.first()?;
    starts_elsewhere(first, farthest(case, quantity)?)
}

/// The first value, if it is not negligible compared with the largest one.
fn starts_elsewhere(first: f64, largest: f64) -> Option<f64> {
    (first.abs() > 1e-3 * largest.abs().max(first.abs())).then_some(first)
}

/// Share of the largest change by which the written rows of a quantity may miss its extreme without a warning \[–\].
const MISSED: f64 = 0.01;

/// Returns a warning for each quantity whose written rows miss its extreme over the whole run.
pub fn missed_extremes(study: &StudyRecord, cases: &[StoredCase]) -> Vec<String> {
    let missed = |case: &StoredCase, name: &str| {
        let written = Curve::of(&case.series, name)?;
        let (first, of_run) = (written.f[0], case.record.probes.get(name)?);
        let of_rows = extreme_on(of_run.peak_is, written.f).map_or(first, |e| e.value);
        let share = (of_run.peak - of_rows).abs() / (of_run.peak - first).abs();
        (share > MISSED).then_some(share)
    };
    let mut labels = BTreeMap::new();
    for (name, label) in study.quantities.values().flatten().map(|q| (&q.name, &q.label)) {
        labels.entry(name).or_insert(label);
    }
    let warning = |(name, label): (&String, &String)| {
        let shares: Vec<f64> = cases.iter().filter_map(|case| missed(case, name)).collect();
        let most = shares.iter().copied().reduce(f64::max)?;
        Some(format!(
            "{}: the written rows of {} of {} miss the extreme, by up to {}; peaks are of all rows, but curves, norms and figures are of these: write more rows \
             with `series.every` of [output].",
            capital(label),
            shares.len(),
            count(cases.len(), "case"),
            percent(most)
        ))
    };
    labels.into_iter().filter_map(warning).collect()
}

/// Wording for a peak that is a change.
pub const CHANGE: &str = "largest change of";

/// Wording for the peak of a quantity over some cases: [`extreme_word`], or [`CHANGE`] if it is a change.
pub fn peak_words<'a>(cases: impl IntoIterator<Item = &'a StoredCase>, quantity: &str) -> &'static str {
    let cases: Vec<&StoredCase> = cases.into_iter().collect();
    match cases.iter().any(|c| start(c, quantity).is_some()) {
        true => CHANGE,
        false => extreme_word(cases, quantity),
    }
}

/// Word for the recorded extreme of a quantity over some cases: `maximum`, `minimum`, or `extreme` if the cases differ.
pub fn extreme_word<'a>(cases: impl IntoIterator<Item = &'a StoredCase>, quantity: &str) -> &'static str {
    let kinds = cases.into_iter().filter_map(|c| Some(c.record.probes.get(quantity)?.peak_is));
    let mut kinds = kinds.filter(|kind| *kind != ExtremeKind::Constant);
    match kinds.next() {
        Some(kind) if kinds.all(|k| k == kind) => kind.name(),
        _ => "extreme",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sin(2πt) over one and a quarter periods compared with the shifted wave, a multiple of it and an unrelated curve, and a ramp with a steeper one.
    #[test]
    fn a_lag_is_a_small_shift_and_no_factor() {
        let t: Vec<f64> = (0..=1250).map(|k| 1e-3 * f64::from(k)).collect();
        let of = |y: &dyn Fn(f64) -> f64| t.iter().map(|t| y(*t)).collect::<Vec<_>>();
        let wave = |t: f64| (std::f64::consts::TAU * t).sin();
        let g = of(&wave);
        let shifted = lag(&t, &of(&|t| wave(t - 0.01)), &g).expect("a small shift");
        assert!((shifted / 0.01 - 1.0).abs() < 0.02, "{shifted}");
        assert!(lag(&t, &of(&|t| 3.0 * wave(t)), &g).expect("a factor").abs() < 1e-12);
        let elsewhere =
            [wave as fn(f64) -> f64, |t| 3.0 * (std::f64::consts::TAU * t).sin()].map(|y| of(&|t| 20.0 + y(t)));
        assert!(lag(&t, &elsewhere[1], &elsewhere[0]).expect("a factor of the change").abs() < 1e-9);
        assert_eq!(lag(&t, &of(&|t| -5.0 * (std::f64::consts::TAU * t).cos()), &g), None);
        assert!(lag(&t, &of(&|t| 7.0 * t), &of(&|t| t)).expect("a ramp").abs() < 1e-12);
        assert_eq!(lag(&t, &g, &of(&|_| 2.0)), None, "a constant has no lag");
    }

    #[test]
    fn a_curve_with_a_gap_has_no_errors_of_the_rest() {
        let t: Vec<f64> = (0..=300).map(|k| 0.01 * f64::from(k)).collect();
        let f = t.iter().map(|t| (std::f64::consts::TAU * t).sin()).collect();
        let mut curve = Curve { t, f };
        assert!(curve.cycle_defect().expect("three cycles") < 1e-9 && curve.interpolation_error() < 1e-3);
        curve.f[200] = f64::NAN;
        assert!(curve.cycle_defect().is_none() && curve.interpolation_error().is_nan());
    }
}
