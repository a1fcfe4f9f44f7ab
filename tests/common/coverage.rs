//! How often the 95 % intervals of drawn tests hold the truth, and how wide they are.
//!
//! Of n draws with a probability of 95 % the part that holds has the standard deviation √(0.95·0.05/n): 1.5 % of 200, 2.2 % of 100, 3.1 % of 50, 4.9 % of 20. Accepted are 95 − 3 % and two
//! of them, 178, 88, 43 and 17 draws; fewer do with a probability of 0.02, 0.15, 0.3 and 1.6 %.
//!
//! That many hold however wide the intervals are. So their median half-width is compared with the scatter of the values between the draws, of which it is t, 2 of many degrees of freedom: intervals that cover by their
//! width alone fail, and so do those that are too narrow, from fewer draws than their count needs. The scatter of n normal values has the standard deviation 1/√(2n): 5 % of 200, 7 % of 100, 10 % of 50.

use durometer::math::statistics::{deviation, mean, median};

/// A value with its interval.
pub type Found = (f64, [f64; 2]);

/// The median half-width of the intervals.
pub fn median_half(found: &[Found]) -> f64 {
    median(&found.iter().map(|(_, [low, high])| 0.5 * (high - low)).collect::<Vec<f64>>())
}

/// Of one number over draws.
#[derive(Debug)]
pub struct Coverage {
    draws: usize,
    /// Draws whose interval holds the truth \[%\]
    pub covered: f64,
    /// Mean error \[%\]
    pub bias: f64,
    /// Standard deviation of the mean error \[%\]
    pub bias_error: f64,
    /// Median half-width over the standard deviation between the draws
    pub wide: f64,
}

impl Coverage {
    pub fn of(truth: f64, found: &[Found]) -> Self {
        let values: Vec<f64> = found.iter().map(|(value, _)| *value).collect();
        let held = found.iter().filter(|(_, [low, high])| (*low..=*high).contains(&truth)).count();
        Self {
            draws: found.len(),
            covered: 100.0 * held as f64 / found.len() as f64,
            bias: 100.0 * (mean(&values) / truth - 1.0),
            bias_error: 100.0 * deviation(&values) / truth.abs() / (found.len() as f64).sqrt(),
            wide: median_half(found) / deviation(&values),
        }
    }

    /// Whether enough intervals hold the truth.
    pub fn holds(&self) -> bool {
        let deviation = 100.0 * (0.95 * 0.05 / self.draws as f64).sqrt();
        self.covered >= 95.0 - 3.0 - 2.0 * deviation
    }

    /// Whether enough intervals hold the truth, of a width between these multiples of the scatter.
    pub fn holds_within(&self, [narrowest, widest]: [f64; 2]) -> bool {
        self.holds() && narrowest <= self.wide && self.wide <= widest
    }
}

/// The number of draws: this one, or the one that the environment asks for by `DUROMETER_DRAWS`.
pub fn draws(usual: u64) -> u64 {
    std::env::var("DUROMETER_DRAWS").ok().and_then(|n| n.parse().ok()).unwrap_or(usual)
}
