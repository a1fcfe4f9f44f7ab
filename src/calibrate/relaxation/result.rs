//! A fitted Prony series with its intervals, warnings and descriptions.

use super::error::RelaxationError;
use super::response::TestKind;
use crate::calibrate::constant_format::number_text;
use crate::calibrate::{Bounded, ErrorModel, FitSummary};
use crate::storage;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// A term: share g \[–\] of the instantaneous modulus and relaxation time τ \[s\].
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct RelaxationTerm {
    pub g: Bounded,
    pub tau: Bounded,
}

/// Warnings about the use of a fitted series.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RelaxationWarning {
    /// The modulus is still falling at the end of the data
    NoPlateau { end: f64, slope: f64 },
    /// The interval of the long-term modulus is wide
    LongTerm { interval: [f64; 2] },
    /// The long-term modulus vanishes
    Liquid,
    /// A time at the limit of what the data resolve
    TimeAtLimit { tau: f64 },
    /// A time shorter than the first data point
    Early { tau: f64, first: f64 },
    /// A time of the list that has no share
    NoShare { tau: f64 },
}

impl RelaxationWarning {
    /// Whether the long-term modulus is not determined by the data.
    fn is_undetermined(&self) -> bool {
        matches!(self, Self::NoPlateau { .. } | Self::LongTerm { .. } | Self::Liquid)
    }
}

impl fmt::Display for RelaxationWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPlateau { end, slope } => write!(
                f,
                "the data do not determine the long-term modulus: they end at {} s without a plateau, where the modulus falls by {:.1} % a decade; \
                 use the series for shorter times only, or measure longer",
                number_text(*end),
                100.0 * slope
            ),
            Self::LongTerm { interval: [low, high] } => write!(
                f,
                "the data do not determine the long-term modulus: its interval reaches from {} to {} in its unit",
                number_text(*low),
                number_text(*high)
            ),
            Self::Liquid => f.write_str(
                "nothing is left in the long run: the series is that of a liquid, and the effect viscoelastic refuses it; measure longer",
            ),
            Self::TimeAtLimit { tau } => {
                write!(f, "the time {} s lies at the end of what the data resolve: its own value is not determined", number_text(*tau))
            }
            Self::Early { tau, first } => write!(
                f,
                "the time {} s is shorter than that of the first data point, {} s: its share is an extrapolation",
                number_text(*tau),
                number_text(*first)
            ),
            Self::NoShare { tau } => write!(f, "the time {} s got no share: the bound g ≥ 0 holds it at zero, and the intervals are those of the others", number_text(*tau)),
        }
    }
}

/// A Prony series fitted to a test.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RelaxationFit {
    pub data: String,
    pub data_sha256: String,
    pub experiment: TestKind,
    pub version: &'static str,
    /// Number of fitted values; storage and loss count separately
    pub rows: usize,
    /// Shortest and longest time of the data \[s\]; for a dynamic test 1/ω
    pub span: [f64; 2],
    /// Duration of the loading \[s\], if it is stated
    pub ramp: Option<f64>,
    /// Unit of the moduli: `Pa`, `N`, `1`, `of the law`, `of the held stress`
    pub unit: String,
    /// G₀
    pub instantaneous: Bounded,
    /// G∞
    pub long_term: Bounded,
    /// G∞/G₀
    pub long_term_share: Bounded,
    /// Terms, ascending in τ
    pub terms: Vec<RelaxationTerm>,
    /// Criterion of 0, 1, 2, … terms, as far as they were tried
    pub criteria: Vec<f64>,
    pub chosen_by: String,
    /// Times of a list that have no share \[s\]
    pub dropped: Vec<f64>,
    pub errors: ErrorModel,
    /// Degrees of freedom of Student's t
    pub degrees: usize,
    /// Weighted rms of the residual relative to that of the data \[–\]
    pub misfit: f64,
    pub warnings: Vec<RelaxationWarning>,
    /// Description, data and curve
    pub summary: FitSummary,
}

impl RelaxationFit {
    /// G(t)/G₀ of the series \[–\] after a step.
    pub fn share_at(&self, t: f64) -> f64 {
        self.long_term_share.value + self.terms.iter().map(|a| a.g.value * (-t / a.tau.value).exp()).sum::<f64>()
    }

    /// Whether the data determine the long-term modulus.
    pub fn is_determined(&self) -> bool {
        !self.warnings.iter().any(RelaxationWarning::is_undetermined)
    }

    /// Writes the result as JSON.
    pub fn write_json(&self, path: &Path) -> Result<(), RelaxationError> {
        let text = serde_json::to_string_pretty(self).expect("numbers, texts and lists can be written");
        storage::write(path, text.as_bytes()).map_err(|source| RelaxationError::Write { path: path.into(), source })
    }
}

impl fmt::Display for RelaxationFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.summary.fmt(f)
    }
}
