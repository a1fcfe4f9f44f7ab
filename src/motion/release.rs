//! The time at which a held body is released.

use super::curve::Curve;
use super::error::MotionError;
use super::plateau::Plateau;

/// Rows in a row that have to be beyond the limit, so that one outlier is no release
const STAYS: usize = 3;

/// Side of the held level on which a departure counts.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Side {
    #[default]
    Either,
    /// Smaller values: a body that falls, though the hand may lift it first
    Below,
    Above,
}

/// Rule by which the release is found.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleaseRule {
    /// Multiple of the deviation of a row within the plateau
    pub factor: f64,
    /// Least departure that counts, in the unit of the curve
    pub threshold: f64,
    pub side: Side,
}

impl Default for ReleaseRule {
    fn default() -> Self {
        Self { factor: 5.0, threshold: 0.0, side: Side::Either }
    }
}

/// A release.
#[derive(Clone, Debug, PartialEq)]
pub struct Release {
    /// Time of the last row within the limit \[s\]
    pub time_s: f64,
    /// Its row of the curve
    pub row: usize,
    /// Time of the next row \[s\]: the release lies between the two
    pub next_s: f64,
    /// Departure of that row from the plateau's mean that counts, in the unit of the curve
    pub limit: f64,
}

/// The last row before the curve leaves a held plateau by more than max(factor × deviation, threshold) for three rows. The deviation is that of one sample
/// in the plateau over the root of the samples of the row: single samples may follow a plateau of means.
///
/// # Errors
/// A curve that stays within the limit.
pub fn release(curve: &Curve, held: &Plateau, rule: &ReleaseRule) -> Result<Release, MotionError> {
    let limit = |k: usize| (rule.factor * held.sample_deviation / curve.samples[k].sqrt()).max(rule.threshold);
    let out = |k: usize| {
        let departure = curve.value[k] - held.mean.value;
        match rule.side {
            Side::Either => departure.abs() > limit(k),
            Side::Below => departure < -limit(k),
            Side::Above => departure > limit(k),
        }
    };
    let start = curve.rows(held.window_s).start;
    let n = curve.value.len();
    let leaves = (start + 1..n).find(|k| (*k..(k + STAYS).min(n)).all(out) && k + STAYS <= n);
    let largest = || (start..n).map(limit).fold(0.0, f64::max);
    let next = leaves.ok_or_else(|| MotionError::NoRelease { curve: curve.name.clone(), limit: largest() })?;
    Ok(Release { time_s: curve.time_s[next - 1], row: next - 1, next_s: curve.time_s[next], limit: limit(next) })
}
