//! Data points far from their neighbours.

use super::misfit::{Residual, residuals};
use super::warning::FitWarning;
use crate::calibrate::{Loss, Sample};
use crate::math::statistics::median;
use std::collections::BTreeSet;

/// Thresholds of an outlier \[–\]: distance from the neighbours in robust standard deviations, of stresses and of relative stresses; distance
/// relative to its own stress; and distance relative to the largest stress
const OFF: f64 = 8.0;
const PART: f64 = 0.2;
const SMALL: f64 = 0.05;
/// Least number of data points that have a neighbourhood
const FEW: usize = 10;

/// Specimen and line of data points far from their neighbours, for each specimen separately.
#[derive(Clone, Debug, Default)]
pub struct Outliers(pub BTreeSet<(usize, u64)>);

impl Outliers {
    /// The outliers among fitted data points, given the stresses of their law.
    pub fn of(samples: &[Sample], law: impl Fn(&Sample) -> f64) -> Self {
        let specimens: BTreeSet<usize> = samples.iter().map(|s| s.specimen).collect();
        let of = |specimen: usize| {
            let own: Vec<Sample> = samples.iter().filter(|s| s.specimen == specimen).copied().collect();
            outliers(&residuals(&own, &law)).into_iter().map(move |line| (specimen, line))
        };
        Self(specimens.into_iter().flat_map(of).collect())
    }

    /// The data points that count in a misfit: with Huber's loss, which limits the weight of outliers, all others.
    pub fn counted(&self, samples: &[Sample], loss: Loss) -> Vec<Sample> {
        let counts = |s: &&Sample| loss == Loss::Squares || !self.0.contains(&(s.specimen, s.line));
        samples.iter().filter(counts).copied().collect()
    }

    /// A warning for each specimen that has outliers. `names`: names of the specimens.
    pub fn warnings<'a>(&'a self, names: &'a [String], loss: Loss) -> impl Iterator<Item = FitWarning> + 'a {
        names.iter().enumerate().filter_map(move |(specimen, file)| {
            let own = self.0.iter().filter(|(of, _)| *of == specimen);
            let (file, lines): (_, Vec<u64>) = (file.clone(), own.map(|(_, line)| *line).collect());
            (!lines.is_empty()).then_some(match loss {
                Loss::Squares => FitWarning::Outliers { file, lines },
                Loss::Huber => FitWarning::LimitedOutliers { file, lines },
            })
        })
    }
}

/// Lines of one specimen whose residual differs from the median of itself and its neighbours (two on each side, same mode): a misfit of the law is
/// smooth, an outlier is not.
fn outliers(rows: &[Residual]) -> Vec<u64> {
    let off = |k: usize| {
        let near = rows[k.saturating_sub(2)..(k + 3).min(rows.len())].iter().filter(|r| r.mode == rows[k].mode);
        (rows[k].residual - median(&near.map(|r| r.residual).collect::<Vec<_>>())).abs()
    };
    let all: Vec<f64> = (0..rows.len()).map(off).collect();
    if rows.len() < FEW {
        return vec![];
    }
    let largest = rows.iter().map(|r| r.measured.abs()).fold(0.0, f64::max);
    let relative: Vec<f64> =
        rows.iter().zip(&all).map(|(r, off)| off / r.measured.abs()).filter(|v| v.is_finite()).collect();
    let limit = (OFF * 1.4826 * median(&all)).max(SMALL * largest);
    // If errors grow with the stress, large errors are not outliers
    let part = if relative.is_empty() { PART } else { (OFF * 1.4826 * median(&relative)).max(PART) };
    let is_off = |(r, off): (&Residual, &f64)| *off > limit && *off > part * r.measured.abs();
    let mut lines: Vec<u64> = rows.iter().zip(&all).filter(|p| is_off(*p)).map(|(r, _)| r.line).collect();
    lines.sort_unstable();
    lines
}
