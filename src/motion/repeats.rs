//! Repeats of an experiment, pooled.

use super::error::MotionError;
use super::tracks::Tracks;
use crate::calibrate::{Bounded, same_data};
use crate::math::statistics::{extent, t_quantile};

/// Mean of some repeats, with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Pooled {
    /// Mean with its 95 % interval by Student's t with n − 1 degrees of freedom; unbounded for a single repeat
    pub mean: Bounded,
    /// Standard deviation between repeats, with n − 1; `None` for a single repeat
    pub deviation: Option<f64>,
    /// Standard uncertainty of the mean, deviation/√n; `None` for a single repeat
    pub uncertainty: Option<f64>,
    /// Half of the largest difference
    pub half_range: f64,
    pub repeats: usize,
}

/// Refuses records that are copies of each other, also in different units or with different times.
///
/// # Errors
/// [`MotionError::SameRecord`] with the first such pair.
pub fn check_distinct(files: &[(String, &Tracks)]) -> Result<(), MotionError> {
    let numbers = |(_, tracks): &(String, &Tracks)| -> Vec<f64> {
        let points = tracks.markers.iter().flat_map(|m| &m.points);
        points.flat_map(|p| p.map_or(vec![f64::MAX], |p| p.to_vec())).collect()
    };
    same_data::first_pair(&files.iter().map(numbers).collect::<Vec<_>>()).map_or(Ok(()), |pair| {
        let [first, second] = pair.map(|k| files[k].0.clone());
        Err(MotionError::SameRecord { first, second })
    })
}

/// Pools the values of repeats.
///
/// # Errors
/// There are no values, or a value is not finite.
pub fn pooled(values: &[f64]) -> Result<Pooled, MotionError> {
    let n = values.len();
    if n == 0 || values.iter().any(|v| !v.is_finite()) {
        return Err(MotionError::NotFinite { what: format!("one of {n} repeats (or there is none)") });
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let [low, high] = extent(values.iter().copied());
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let deviation = (n > 1).then(|| (squares / (n - 1) as f64).sqrt());
    let uncertainty = deviation.map(|s| s / (n as f64).sqrt());
    let half = uncertainty.map_or(f64::INFINITY, |u| t_quantile(0.95, n - 1) * u);
    let mean = Bounded { value: mean, interval: [mean - half, mean + half] };
    Ok(Pooled { mean, deviation, uncertainty, half_range: 0.5 * (high - low), repeats: n })
}
