//! Counts of error bars that hold, with the confidence interval of their share.

use crate::math::statistics::median;
use crate::study::kinds::coverage::mark::{Estimator, Mark};
use serde::Serialize;

/// Quantile of the normal distribution for an interval of 95 %.
const Z: f64 = 1.96;

/// Error bars of one group.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Share {
    pub estimator: Estimator,
    /// Property by which bars are grouped, for example `formulation` with the group `tet10_up`
    pub by: &'static str,
    pub group: String,
    pub bars: usize,
    pub hold: usize,
    /// 95 % interval of the share \[–\]
    pub interval: [f64; 2],
    /// Median of bar/|truth − value| \[–\]
    pub median_ratio: f64,
    /// Number of intervals about the corrected value with a truth that is known to within a tenth of their half-width
    pub intervals: usize,
    pub intervals_hold: usize,
}

impl Share {
    /// Counts the bars of a group; `None` without a bar that counts.
    pub fn new(estimator: Estimator, by: &'static str, group: &str, marks: &[&Mark]) -> Option<Self> {
        if marks.is_empty() {
            return None;
        }
        let hold = marks.iter().filter(|m| m.holds()).count();
        let known = || marks.iter().filter(|m| m.interval_known());
        Some(Self {
            estimator,
            by,
            group: group.into(),
            bars: marks.len(),
            hold,
            interval: wilson(hold, marks.len()),
            median_ratio: median(&marks.iter().map(|m| m.ratio()).collect::<Vec<_>>()),
            intervals: known().count(),
            intervals_hold: known().filter(|m| m.interval_holds()).count(),
        })
    }

    pub fn share(&self) -> f64 {
        self.hold as f64 / self.bars as f64
    }
}

/// Numbers of effectivities within bounds.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Effectivity {
    pub group: String,
    pub bars: usize,
    pub median: f64,
    /// Number of effectivities from 0.7 to 1.4
    pub near: usize,
    /// Number of effectivities from 0.5 to 2
    pub within: usize,
}

impl Effectivity {
    /// Counts the effectivities of a group; `None` without an estimate that counts.
    pub fn new(group: &str, marks: &[&Mark]) -> Option<Self> {
        let all: Vec<f64> = marks.iter().map(|m| m.effectivity()).collect();
        if all.is_empty() {
            return None;
        }
        let count = |lo: f64, hi: f64| all.iter().filter(|e| (lo..=hi).contains(*e)).count();
        let (near, within) = (count(0.7, 1.4), count(0.5, 2.0));
        Some(Self { group: group.into(), bars: all.len(), near, within, median: median(&all) })
    }
}

/// Returns the 95 % interval of a share of which `hold` of `n` cases hold (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209–212).
pub fn wilson(hold: usize, n: usize) -> [f64; 2] {
    let (n, p) = (n as f64, hold as f64 / n as f64);
    let z2 = Z * Z / n;
    let half = Z * (p * (1.0 - p) / n + z2 / (4.0 * n)).sqrt();
    [-half, half].map(|half| ((p + 0.5 * z2 + half) / (1.0 + z2)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wilson's interval for 9 of 10 is 0.596 to 0.982; with n of n, (z²/n)/(1 + z²/n) remains below 1.
    #[test]
    fn intervals_of_shares() {
        let [lo, hi] = wilson(9, 10);
        assert!((lo - 0.596).abs() < 1e-3 && (hi - 0.982).abs() < 1e-3, "{lo} {hi}");
        let [lo, hi] = wilson(50, 50);
        let z2 = Z * Z / 50.0;
        assert!((lo - 1.0 / (1.0 + z2)).abs() < 1e-12 && hi == 1.0);
    }
}
