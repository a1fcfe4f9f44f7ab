//! The time at which a held body is released.

use super::curve::Curve;
use super::error::MotionError;
use super::plateau::Plateau;

/// Number of consecutive rows that must exceed the limit, so that a single outlier is not a release
const STAYS: usize = 3;

/// Side of the held level on which a departure counts.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Side {
    #[default]
    Either,
    /// Smaller values: a body that falls, although it may first be lifted by hand
    Below,
    Above,
}

/// Rule by which the release is found.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleaseRule {
    /// Multiple of the standard deviation of a row within the plateau \[–\]
    pub factor: f64,
    /// Smallest departure that counts, in the unit of the curve
    pub threshold: f64,
    pub side: Side,
}

impl Default for ReleaseRule {
    fn default() -> Self {
        Self { factor: 5.0, threshold: 0.0, side: Side::Either }
    }
}

/// The release that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Release {
    /// Time of the last row within the limit \[s\]
    pub time_s: f64,
    /// Index of this row of the curve
    pub row: usize,
    /// Time of the next row \[s\]; the release is between the two
    pub next_s: f64,
    /// Departure of the next row from the mean of the plateau that had to be exceeded, in the unit of the curve
    pub limit: f64,
}

/// Finds the last row before the curve leaves a held plateau by more than max(factor × deviation, threshold) for three rows. The deviation is that of
/// one sample in the plateau divided by the square root of the number of samples of the row, because a plateau of averaged rows may be followed by
/// single samples.
///
/// # Errors
/// The curve stays within the limit.
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
