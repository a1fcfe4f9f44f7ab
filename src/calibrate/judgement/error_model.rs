//! Models of the errors of the data points, and the resulting standard errors of the constants.

use super::correlation::Correlation;
use crate::math::statistics::{extent, t_quantile};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Model of the errors of the data points.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ErrorModel {
    /// Independent errors of the data points
    #[default]
    Independent,
    /// Independent errors whose size changes with the stress
    Unequal {
        /// Larger at large stresses
        grow: bool,
    },
    /// Independent errors whose size differs between the curves
    UnequalCurves {
        /// Ratio of the largest standard deviation of a curve to the smallest \[–\]
        ratio: f64,
    },
    /// Errors that are correlated between neighbours in order of loading
    Correlated {
        /// Correlation of neighbours, averaged over its likelihood \[–\]
        rho: f64,
        /// Number of independent data points with the same information about a mean
        effective: f64,
        /// Larger at large stresses
        #[serde(default)]
        grow: bool,
    },
    /// One error for each specimen as a whole
    Specimens { specimens: usize },
    /// One error of the level of each specimen, from the tests with several specimens
    Levels {
        specimens: usize,
        /// Degrees of freedom of the scatter: specimens beyond the first of each test
        repeats: usize,
    },
}

impl ErrorModel {
    /// Whether errors grow with the stress.
    pub fn grows(self) -> bool {
        matches!(self, Self::Unequal { grow: true } | Self::Correlated { grow: true, .. })
    }

    /// Describes the model, where the errors are those of measured `responses`, such as stresses.
    pub fn words(&self, responses: &str) -> String {
        match self {
            Self::Independent => "the errors of the data points are independent".into(),
            Self::Correlated { rho, effective, grow } => {
                let size = if *grow { format!(", and larger at large {responses}") } else { String::new() };
                format!(
                    "the errors of neighbouring data points are correlated ({rho:.3}){size}: they count as {effective:.1} independent ones"
                )
            }
            Self::Unequal { grow } => {
                let side = if *grow { "larger" } else { "smaller" };
                format!("the errors of the data points are independent, and {side} at large {responses}")
            }
            Self::UnequalCurves { ratio } => format!(
                "the errors of the data points are independent, and up to {ratio:.1} times as large in one curve as in another"
            ),
            Self::Specimens { specimens } => format!("scatter between {specimens} specimens"),
            Self::Levels { specimens, repeats } => format!(
                "scatter of the level between {specimens} specimens, from {repeats} repeats of a test; tests with one specimen are taken to scatter alike"
            ),
        }
    }
}

impl fmt::Display for ErrorModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words("stresses"))
    }
}

/// Standard errors of the constants, with the error model behind them.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    pub model: ErrorModel,
    /// Standard error of each column of the Jacobian; if the data do not determine it, of the part that they determine
    pub deviations: Vec<f64>,
    /// √((JᵀJ)⁻¹ⱼⱼ): standard error for independent errors of size 1
    pub plain: Vec<f64>,
    /// Degrees of freedom of Student's t; 0 if there are as many constants as data points
    pub free: usize,
    /// Most likely correlation; the default if data points are independent
    pub correlation: Correlation,
    /// ‖r‖ of the smooth departure from the law: the part beyond the differences between neighbours, weighted like the residual
    pub smooth: f64,
    /// Standard deviation of each data point up to a factor, either that of its curve or one that grows with the stress, if the data show that they
    /// differ \[–\]
    pub sizes: Option<DVector<f64>>,
    /// Covariance of the constants, for the part that the data determine
    pub covariance: DMatrix<f64>,
}

impl Errors {
    /// Largest ratio of a standard error to the one for independent errors of this size.
    pub fn wider(&self, size: f64) -> f64 {
        let ratio = |(d, plain): (&f64, &f64)| if *plain > 0.0 && size > 0.0 { d / (size * plain) } else { 1.0 };
        self.deviations.iter().zip(&self.plain).map(ratio).filter(|r| r.is_finite()).fold(0.0, f64::max)
    }

    /// Largest rise of the sum of squares at an end of one of the 95 % intervals, (t dⱼ)²/((JᵀJ)⁻¹)ⱼⱼ, as in profiles; `None` without a degree of
    /// freedom, where no interval is finite.
    pub fn rise(&self) -> Option<f64> {
        let t = (self.free > 0).then(|| t_quantile(0.95, self.free))?;
        let limit = self.deviations.iter().zip(&self.plain).map(|(d, plain)| t * d / plain).filter(|l| l.is_finite());
        Some(limit.fold(0.0, f64::max).powi(2))
    }

    /// Ratio of the largest standard deviation of a curve to the smallest, if they differ \[–\]
    pub fn ratio(&self) -> Option<f64> {
        let of_curves = self.sizes.as_ref().filter(|_| !self.model.grows());
        let [least, most] = extent(of_curves?.iter().copied());
        Some(most / least)
    }

    /// Multiplies the standard error of each constant by a factor, and the covariance by the factors of both constants.
    pub fn scaled(mut self, factors: &[f64]) -> Self {
        self.deviations.iter_mut().zip(factors).for_each(|(d, f)| *d *= f);
        let scaled = |a: usize, b: usize| factors[a] * factors[b] * self.covariance[(a, b)];
        self.covariance = DMatrix::from_fn(factors.len(), factors.len(), scaled);
        self
    }
}
