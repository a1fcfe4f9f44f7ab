//! Tables with very many data points: means of neighbours in λ.
//!
//! If a specimen has more than 2 000 data points in a mode, groups of m neighbours in λ are replaced by one data point with the mean stretch and the
//! mean stress. The mean over a group that spans Δλ differs from the law by P″Δλ²/24: with two thousand groups up to a stretch of 8 this is below
//! 1e-6 of the largest stress. A stress that is far from the median of its group remains a separate data point, so that an outlier remains an
//! outlier.
//!
//! Limits: noise decreases with √m, and so does the reported rms misfit; variations slower than a group are unchanged.

use crate::calibrate::Sample;
use crate::math::statistics::median;

/// Largest number of data points that are used unchanged
pub const MOST: usize = 2_000;
/// Distance from the median of a group, in robust standard deviations and relative to its stress, from which on a data point is kept separate \[–\]
const OFF: f64 = 8.0;
const PART: f64 = 0.5;

/// The means of these data points of one specimen and mode, and the number of data points in each; `None` if there are few data points.
pub fn condensed(samples: &[Sample]) -> Option<(Vec<Sample>, usize)> {
    if samples.len() <= MOST {
        return None;
    }
    let size = samples.len().div_ceil(MOST);
    let mut sorted = samples.to_vec();
    sorted.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
    let mut found = Vec::with_capacity(MOST + 1);
    for group in sorted.chunks(size) {
        let middle = median(&group.iter().map(|s| s.stress).collect::<Vec<_>>());
        let off = |s: &Sample| (s.stress - middle).abs();
        let limit = OFF * 1.4826 * median(&group.iter().map(off).collect::<Vec<_>>());
        let (own, apart): (Vec<&Sample>, Vec<&Sample>) =
            group.iter().partition(|s| off(s) <= limit.max(PART * middle.abs()));
        let mean = |of: &dyn Fn(&Sample) -> f64| own.iter().map(|s| of(s)).sum::<f64>() / own.len() as f64;
        if let Some(first) = own.get(own.len() / 2) {
            found.push(Sample { stretch: mean(&|s| s.stretch), stress: mean(&|s| s.stress), ..**first });
        }
        found.extend(apart.into_iter().copied());
    }
    Some((found, size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Mode;

    #[test]
    fn means_stay_on_the_curve_and_outliers_apart() {
        let law = |l: f64| 1e5 * (l - 1.0 / (l * l));
        let at = |k: u32| 1.0 + 7.0 * f64::from(k) / 200_000.0;
        let one = |k: u32| Sample {
            mode: Mode::Uniaxial,
            stretch: at(k),
            second: 1.0,
            stress: law(at(k)) * if k == 70_000 { 10.0 } else { 1.0 },
            line: u64::from(k),
            specimen: 0,
        };
        let all: Vec<Sample> = (0..200_000).map(one).collect();
        let (means, size) = condensed(&all).expect("many");
        assert_eq!((means.len(), size), (MOST + 1, 100));
        let off = means.iter().filter(|s| (s.stress - law(s.stretch)).abs() > 1e-6 * 8e5).map(|s| s.line);
        assert_eq!(off.collect::<Vec<_>>(), [70_000]);
        assert!(condensed(&all[..MOST]).is_none());
    }
}
