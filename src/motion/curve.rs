//! A quantity over time, measured or simulated.

use super::error::MotionError;
use crate::math::statistics::{extent, median, range};
use nalgebra::{SMatrix, SVector};

/// Values at ascending times.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name with its unit at the end, such as `tip1_z_m`
    pub name: String,
    pub time_s: Vec<f64>,
    pub value: Vec<f64>,
    /// Number of samples averaged in each value
    pub samples: Vec<f64>,
}

/// Smallest number of rows for one estimate of the noise
const BLOCK: usize = 48;
/// Number of neighbouring values in a combination
const NEAR: usize = 5;
/// Largest share of the values that are outliers \[–\]
const OUTLIERS: f64 = 0.01;

type Neighbours = SVector<f64, NEAR>;

impl Curve {
    /// Builds a curve whose values are single samples.
    ///
    /// # Errors
    /// Lists of different lengths, times that do not increase, and values that are not finite.
    pub fn new(name: &str, time_s: Vec<f64>, value: Vec<f64>) -> Result<Self, MotionError> {
        let samples = vec![1.0; time_s.len()];
        Self::weighted(name, time_s, value, samples)
    }

    /// Builds a curve whose values are means of several samples.
    ///
    /// # Errors
    /// The errors of [`Curve::new`].
    pub fn weighted(name: &str, time_s: Vec<f64>, value: Vec<f64>, samples: Vec<f64>) -> Result<Self, MotionError> {
        let lengths = vec![time_s.len(), value.len(), samples.len()];
        if lengths.iter().any(|n| *n != lengths[0]) {
            return Err(MotionError::Lengths { what: "times, values and samples", lengths });
        }
        let faulty = |k: &usize| {
            let late = *k > 0 && time_s[*k] <= time_s[*k - 1];
            !time_s[*k].is_finite() || !value[*k].is_finite() || late || samples[*k].is_nan() || samples[*k] <= 0.0
        };
        if let Some(k) = (0..time_s.len()).find(faulty) {
            return Err(MotionError::NotFinite {
                what: format!("row {} of curve {name} (or its time is not after the one before)", k + 1),
            });
        }
        Ok(Self { name: name.into(), time_s, value, samples })
    }

    /// Returns the rows from time `from` to time `to` \[s\], both included to within a billionth of a second.
    pub fn window(&self, [from, to]: [f64; 2]) -> Self {
        let range = self.rows([from, to]);
        let cut = |v: &[f64]| v[range.clone()].to_vec();
        Self {
            name: self.name.clone(),
            time_s: cut(&self.time_s),
            value: cut(&self.value),
            samples: cut(&self.samples),
        }
    }

    /// Returns the index range of the rows from time `from` to time `to` \[s\].
    pub fn rows(&self, [from, to]: [f64; 2]) -> std::ops::Range<usize> {
        const ROUNDING: f64 = 1e-9;
        let start = self.time_s.partition_point(|t| *t < from - ROUNDING);
        let end = self.time_s.partition_point(|t| *t <= to + ROUNDING);
        start..end.max(start)
    }

    /// Returns the largest minus the smallest value, single outliers apart: the medians of three neighbouring values have a range, and a value that
    /// is outside of it by more than this range is an outlier, if there are no more than one in a hundred (or one).
    pub fn range(&self) -> f64 {
        let all = || self.value.iter().copied();
        let [low, high] = extent(self.value.windows(3).map(|w| median_of_three(w[0], w[1], w[2])));
        let inner = (2.0 * low - high)..=(2.0 * high - low);
        let outliers = all().filter(|v| !inner.contains(v)).count();
        if outliers as f64 > (OUTLIERS * self.value.len() as f64).max(1.0) {
            range(all())
        } else {
            range(all().filter(|v| inner.contains(v)))
        }
    }

    /// Returns the standard deviation of the noise. In each block of rows it is the smallest standard deviation of a combination of five neighbouring
    /// values whose coefficients have a sum of squares of one, the square root of the smallest eigenvalue of their covariance. For a constant level
    /// with two damped vibrations of any frequency, or a linear trend with one, there is a combination without variance, so that only noise remains
    /// (Pisarenko, Geophys. J. R. Astron. Soc. 33, 1973, 347–366). The result is the lower quartile over the blocks, because blocks in which a motion
    /// begins have more noise; it is at least that of rounding, step/√12.
    pub fn noise(&self) -> f64 {
        let rows: Vec<Neighbours> = self.value.windows(NEAR).map(Neighbours::from_column_slice).collect();
        let count = (rows.len() / BLOCK).max(1);
        let block = |k: usize| &rows[k * BLOCK..if k + 1 < count { (k + 1) * BLOCK } else { rows.len() }];
        let mut blocks: Vec<f64> = (0..count).map(|k| unpredicted(block(k))).collect();
        blocks.sort_by(f64::total_cmp);
        let quartile = blocks.get(blocks.len() / 4).copied().unwrap_or(0.0);
        quartile.max(self.step() / 12_f64.sqrt())
    }

    /// Returns the smallest difference between two values that exceeds the rounding of the arithmetic: the resolution of rounded numbers.
    fn step(&self) -> f64 {
        let mut sorted = self.value.clone();
        sorted.sort_by(f64::total_cmp);
        let least = 1e-12 * sorted.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > least).collect();
        // Values that hardly ever repeat are not rounded
        if 2 * gaps.len() > sorted.len() {
            0.0
        } else {
            gaps.into_iter().fold(f64::INFINITY, f64::min).min(range(self.value.iter().copied()))
        }
    }

    /// Median of the time steps \[s\].
    pub fn time_step(&self) -> f64 {
        median(&self.time_s.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>())
    }
}

/// Returns the middle one of three values.
pub(super) fn median_of_three(a: f64, b: f64, c: f64) -> f64 {
    a.max(b).min(a.min(b).max(c))
}

/// Square root of the smallest variance of a combination of neighbours. Their mean and the free coefficients of the combination take one degree of
/// freedom each.
fn unpredicted(rows: &[Neighbours]) -> f64 {
    let n = rows.len();
    if n <= NEAR {
        return 0.0;
    }
    let mean = rows.iter().sum::<Neighbours>() / n as f64;
    let scatter: SMatrix<f64, NEAR, NEAR> = rows.iter().map(|r| (r - mean) * (r - mean).transpose()).sum();
    (scatter.symmetric_eigenvalues().min().max(0.0) / (n - NEAR) as f64).sqrt()
}
