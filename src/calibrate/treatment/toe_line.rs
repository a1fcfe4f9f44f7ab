//! The least-squares line that removes a toe, with the error of the strain at which it reaches zero stress.
//!
//! ```text
//! e₀ = ē − P̄/E,   Var e₀ = σ²/E² (1/n + (e₀ − ē)²/Σ(eᵢ − ē)²),   σ² = Σ rᵢ²/(n − 2)
//! ```
//!
//! Source: Draper & Smith, *Applied Regression Analysis* (1998), section 3.2, to first order in the error of the slope E.

use crate::math::statistics::{mean, t_quantile};

/// A line through data points.
#[derive(Clone, Copy, Debug)]
pub struct ToeLine {
    /// \[Pa\]
    pub slope: f64,
    /// Strain of zero stress \[–\]
    pub origin: f64,
    /// Half-width of its 95 % interval \[–\]; zero for two points
    pub half_width: f64,
}

impl ToeLine {
    /// The line through points of strain and stress; `None` if the stress does not rise.
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len();
        let (strains, stresses): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let (e, p) = (mean(&strains), mean(&stresses));
        let spread = strains.iter().map(|x| (x - e).powi(2)).sum::<f64>();
        let slope = points.iter().map(|(x, y)| (x - e) * (y - p)).sum::<f64>() / spread;
        if !(slope > 0.0 && slope.is_finite()) {
            return None;
        }
        let origin = e - p / slope;
        let squares = points.iter().map(|(x, y)| (y - p - slope * (x - e)).powi(2)).sum::<f64>();
        let half_width = match n.checked_sub(2).filter(|free| *free > 0) {
            None => 0.0,
            Some(free) => {
                let relative = (squares / free as f64).sqrt() / slope;
                t_quantile(0.95, free) * relative * (1.0 / n as f64 + (origin - e).powi(2) / spread).sqrt()
            }
        };
        Some(Self { slope, origin, half_width })
    }
}
