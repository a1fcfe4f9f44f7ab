//! Several specimens of one test: the mean and scatter of the constants, and a specimen that is an outlier.
//!
//! Each specimen is fitted separately. The level of specimen i is Σ Pᵢ P̂/Σ P̂², with its smoothed curve Pᵢ (below) and the stresses P̂ of the fit to
//! all rows, at 11 stretches of each test that all specimens reached: a measure of its overall stiffness. Over its own stretches, the level of a
//! specimen that broke earlier would be the misfit of the law there. One specimen is named if max |level − mean|/s exceeds Grubbs' bound (k − 1)/√k ·
//! √(t²/(k − 2 + t²)), t = t₁₋₀.₀₂₅/ₖ(k − 2).
//!
//! The stress of the next specimen is expected in P̄(λ) ± t₀.₉₇₅(k − 1) s(λ)√(1 + 1/k), with mean and standard deviation of the k curves at λ (Hahn &
//! Meeker, *Statistical Intervals*, 1991, ch. 4; exact for normal scatter). The curve of a specimen is its law plus the least-squares line through
//! its residuals near λ (a local linear regression: Cleveland, J. Am. Stat. Assoc. 74, 1979, 829–836), so that the band holds whether or not the law
//! describes the data.
//!
//! Source: Grubbs, Ann. Math. Statist. 21 (1950) 27–58. Limits: at most one specimen is named, and only among specimens in the same tests; two
//! outliers are not detected, nor is a specimen whose curve has a different shape but the same level.

use super::estimate::Estimate;
use crate::calibrate::sample::tests;
use crate::calibrate::solve::{LawFit, LawSetting, Pattern, solve};
use crate::calibrate::{FitError, FittableLaw, Mode, Sample};
use crate::math::statistics::{self, deviation, extent};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// One specimen, fitted separately.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Specimen {
    pub file: String,
    pub rows: usize,
    pub parameters: Vec<Estimate>,
    /// Its stresses relative to those of the fit to all data points \[–\], at the stretches that all specimens reached; `None` if there are none
    pub level: Option<f64>,
}

/// The interval in which the stress of another specimen is expected.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Band {
    pub mode: Mode,
    /// λ \[–\]
    pub stretch: f64,
    /// Mean of the measured curves, smoothed along λ \[Pa\]
    pub mean: f64,
    /// 95 % interval \[Pa\]
    pub interval: [f64; 2],
}

/// Scatter between specimens.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Scatter {
    pub specimens: Vec<Specimen>,
    /// Mean of each constant over the specimens \[SI\]
    pub means: Vec<f64>,
    /// Standard deviation of each constant between specimens \[SI\]
    pub deviations: Vec<f64>,
    /// Stress of the next specimen
    pub next: Vec<Band>,
    /// File of the specimen that is an outlier
    pub outlier: Option<String>,
}

/// Scatter between the specimens, and the tests of the residuals of each specimen separately; `None` with one specimen, and if the specimens were
/// tested in different modes or on different sides of rest. `groups`: the fitted data points of each specimen.
pub fn scatter(
    setting: &LawSetting,
    names: &[String],
    groups: &[Vec<Sample>],
    answer: &LawFit,
) -> Result<Option<(Scatter, Vec<Pattern>)>, FitError> {
    let k = groups.len();
    if k < 2 || groups.iter().any(|rows| places(rows) != places(&groups[0])) {
        return Ok(None);
    }
    let one = |(name, rows): (&String, &Vec<Sample>)| {
        if rows.len() < setting.model.parameters().len() {
            return Err(FitError::ShortSpecimen { file: name.clone(), rows: rows.len() });
        }
        let fit = solve(&setting.of(rows), rows, Some(answer))?;
        let parameters = fit.identified.estimates.clone();
        Ok((Specimen { file: name.clone(), rows: rows.len(), parameters, level: None }, fit))
    };
    let (mut specimens, fits): (Vec<Specimen>, Vec<LawFit>) =
        names.iter().zip(groups).map(one).collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    let of = |j: usize| specimens.iter().map(|s| s.parameters[j].value).collect::<Vec<_>>();
    let columns: Vec<Vec<f64>> = (0..answer.values.len()).map(of).collect();
    let means: Vec<f64> = columns.iter().map(|c| c.iter().sum::<f64>() / k as f64).collect();
    let deviations: Vec<f64> = columns.iter().map(|c| deviation(c)).collect();
    let levels = levels(setting, groups, &fits, answer);
    specimens.iter_mut().zip(levels.iter().flatten()).for_each(|(s, level)| s.level = Some(*level));
    let outlier = levels.and_then(|levels| apart(&levels)).map(|i| specimens[i].file.clone());
    let patterns: Vec<Pattern> = fits.iter().map(|f| f.pattern).collect();
    let next = next(setting, groups, &fits);
    Ok(Some((Scatter { specimens, means, deviations, next, outlier }, patterns)))
}

/// Modes of the data points, each with its side of rest.
fn places(rows: &[Sample]) -> BTreeSet<(Mode, bool)> {
    tests(rows).into_iter().map(|test| (test.mode, test.compression)).collect()
}

/// The level of each specimen over the stretches that all specimens reached in each test; `None` if there are none.
fn levels(setting: &LawSetting, groups: &[Vec<Sample>], fits: &[LawFit], answer: &LawFit) -> Option<Vec<f64>> {
    let mut sums = vec![[0.0; 2]; groups.len()];
    for (mode, compression) in places(&groups[0]) {
        let has = |s: &Sample| s.mode == mode && (!Mode::PULLED.contains(&mode) || (s.stretch < 1.0) == compression);
        let at = |s: &Sample| if mode == Mode::Biaxial { s.reach().ln().abs() } else { s.stretch };
        let Some([low, high]) = shared(groups, has, at) else { continue };
        for ((rows, fit), [along, square]) in groups.iter().zip(fits).zip(&mut sums) {
            let mut add = |stress: f64, law: f64| (*along, *square) = (*along + stress * law, *square + law * law);
            // The stress of a biaxial test is not a function of one stretch
            let inside = rows.iter().filter(|s| mode == Mode::Biaxial && has(s) && (low..=high).contains(&at(s)));
            inside.for_each(|s| add(s.stress, setting.model.at(&answer.values, s)));
            for stretch in stretches([low, high]).filter(|_| mode != Mode::Biaxial) {
                let place = (stretch, (high - low) / (STRETCHES - 1) as f64);
                let law = setting.model.stress(&answer.values, mode, stretch);
                add(smoothed(setting.model, fit, rows, mode, place), law);
            }
        }
    }
    sums.iter().all(|[_, square]| *square > 0.0).then(|| sums.iter().map(|[along, square]| along / square).collect())
}

/// The range that these data points of all specimens have in common; `None` if there is none.
fn shared(groups: &[Vec<Sample>], has: impl Fn(&Sample) -> bool, at: impl Fn(&Sample) -> f64) -> Option<[f64; 2]> {
    let ends = groups.iter().map(|rows| extent(rows.iter().filter(|s| has(s)).map(&at)));
    let [low, high] = ends.fold([0.0_f64, f64::INFINITY], |[a, b], [low, high]| [a.max(low), b.min(high)]);
    (low <= high && high.is_finite()).then_some([low, high])
}

/// Evenly spread stretches of a range.
fn stretches([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..STRETCHES).map(move |i| low + (high - low) * i as f64 / (STRETCHES - 1) as f64)
}

/// Number of stretches of a range at which curves are compared
const STRETCHES: usize = 11;

/// Least number of data points of the line through the residuals near a stretch
const NEAR: usize = 4;

/// Stress of a measured curve at λ \[Pa\]: the law of the specimen plus the line through the residuals of the data points within `reach` of λ, but of
/// at least the nearest four.
fn smoothed(model: FittableLaw, fit: &LawFit, rows: &[Sample], mode: Mode, (stretch, reach): (f64, f64)) -> f64 {
    let mut near: Vec<(f64, f64, f64)> = rows
        .iter()
        .zip(&fit.share)
        .filter(|(s, _)| s.mode == mode)
        .map(|(s, share)| (s.stretch - stretch, s.stress - model.at(&fit.values, s), share * share))
        .collect();
    near.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let within = near.iter().take_while(|(off, ..)| off.abs() <= reach).count();
    near.truncate(within.max(NEAR));
    let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| near.iter().map(|p| p.2 * of(p)).sum::<f64>();
    let count = sum(&|_| 1.0);
    let (x, y) = (sum(&|p| p.0) / count, sum(&|p| p.1) / count);
    let spread = sum(&|p| (p.0 - x).powi(2));
    let slope = if spread > 0.0 { sum(&|p| (p.0 - x) * (p.1 - y)) / spread } else { 0.0 };
    model.stress(&fit.values, mode, stretch) + y - slope * x
}

/// The stress of the next specimen over the stretches that all specimens reached.
fn next(setting: &LawSetting, groups: &[Vec<Sample>], fits: &[LawFit]) -> Vec<Band> {
    let k = fits.len() as f64;
    let factor = statistics::t_quantile(0.95, fits.len() - 1) * (1.0 + 1.0 / k).sqrt();
    let of = |mode: Mode| {
        let found = shared(groups, |s| s.mode == mode, |s| s.stretch);
        let known = found.filter(|[low, high]| mode != Mode::Biaxial && low < high);
        let one = move |stretch: f64, [low, high]: [f64; 2]| {
            let place = (stretch, (high - low) / (STRETCHES - 1) as f64);
            let curve = |(rows, fit): (&Vec<Sample>, &LawFit)| smoothed(setting.model, fit, rows, mode, place);
            let all: Vec<f64> = groups.iter().zip(fits).map(curve).collect();
            let (mean, half) = (all.iter().sum::<f64>() / k, factor * deviation(&all));
            Band { mode, stretch, mean, interval: [mean - half, mean + half] }
        };
        known.into_iter().flat_map(move |range| stretches(range).map(move |stretch| one(stretch, range)))
    };
    Mode::ALL.into_iter().flat_map(of).collect()
}

/// Index of the value that Grubbs' test at 5 % identifies as an outlier.
fn apart(values: &[f64]) -> Option<usize> {
    let n = values.len();
    if n < 3 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let off = |i: &usize| (values[*i] - mean).abs();
    let farthest = (0..n).max_by(|a, b| off(a).total_cmp(&off(b)))?;
    (off(&farthest) > bound(n) * deviation(values)).then_some(farthest)
}

/// Grubbs' bound, two-sided at 5 %, for n ≥ 3 values \[–\].
fn bound(n: usize) -> f64 {
    let t2 = statistics::t_quantile(1.0 - 0.05 / n as f64, n - 2).powi(2);
    let n = n as f64;
    (n - 1.0) / n.sqrt() * (t2 / (n - 2.0 + t2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Printed tables of the two-sided test at 5 % (Grubbs & Beck, Technometrics 14, 1972: one-sided at 2.5 %), three digits.
    #[test]
    fn bounds_are_those_of_the_table() {
        for (n, g) in [(3, 1.155), (4, 1.481), (5, 1.715), (6, 1.887), (8, 2.126), (10, 2.290)] {
            assert!((bound(n) - g).abs() < 1e-3, "{n}: {}", bound(n));
        }
    }
}
