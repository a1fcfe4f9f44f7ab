//! The request for a fit.

use super::{Accuracy, Bounded, ColumnChoice, FitError, Mode, Partner, Preparation, SlackChoice};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A closed range of stretch λ \[–\], written `1..1.6`.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct StretchRange {
    pub from: f64,
    pub to: f64,
}

impl StretchRange {
    /// Every stretch
    pub const ALL: Self = Self { from: 0.0, to: f64::INFINITY };

    pub fn contains(self, stretch: f64) -> bool {
        self.from <= stretch && stretch <= self.to
    }
}

impl FromStr for StretchRange {
    type Err = FitError;

    fn from_str(text: &str) -> Result<Self, FitError> {
        let refuse = |reason| FitError::Range { text: text.into(), reason };
        let (from, to) = text.split_once("..").ok_or_else(|| refuse("has no \"..\""))?;
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let (Some(from), Some(to)) = (number(from), number(to)) else {
            return Err(refuse("needs a number on both sides"));
        };
        if from <= 0.0 {
            Err(refuse("a stretch is positive (1 is undeformed)"))
        } else if from >= to {
            Err(refuse("the first stretch must be the smaller one"))
        } else {
            Ok(Self { from, to })
        }
    }
}

/// Poisson's ratio of a law that is fitted as compressible.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Poisson {
    /// Without an interval if it was given without its accuracy
    pub ratio: Bounded,
    /// Whether it is from lateral strain; otherwise it was given
    pub measured: bool,
    /// Limits of its use
    pub doubts: Vec<String>,
}

/// The measure in which the errors of the data points are equal.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// Every pascal has the same weight
    Absolute,
    /// Every per cent has the same weight; below 5 % of the largest stress of the mode, every pascal
    Relative,
    /// Every standard deviation of the noise of its mode has the same weight
    Noise,
}

/// Loss function of a residual, which determines the weight of data points far from the law.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// The square of the residual
    #[default]
    Squares,
    /// Huber's loss: the square of the residual up to 1.345 robust standard deviations, linear beyond
    Huber,
}

impl FromStr for Weighting {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "absolute" => Ok(Self::Absolute),
            "relative" => Ok(Self::Relative),
            "noise" => Ok(Self::Noise),
            _ => Err(format!("\"{word}\" is not a weighting; known: absolute, relative, noise")),
        }
    }
}

impl FromStr for Loss {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "squares" => Ok(Self::Squares),
            "huber" => Ok(Self::Huber),
            _ => Err(format!("\"{word}\" is not a loss; known: squares, huber")),
        }
    }
}

/// Choice of the data, the law and the method of a fit.
#[derive(Clone, Debug)]
pub struct FitOptions {
    /// Name of a law of [`super::fittable_laws`]
    pub law: String,
    /// Number of terms; by default the usual number of the law
    pub terms: Option<usize>,
    /// Modes that are fitted together; if empty, the only mode of the table (a table with several modes is refused)
    pub modes: Vec<Mode>,
    /// Fitted range of stretch; `None`: all data points. No other default is defensible without knowing the use of the law; the dependence of the
    /// answer on the range is part of the result.
    pub range: Option<StretchRange>,
    pub weighting: Weighting,
    /// Standard deviation of the stress \[Pa\] for [`Weighting::Noise`]; `None`: estimated from the data of each mode
    pub noise: Option<f64>,
    pub loss: Loss,
    /// Stretches over which a linear law is kept stable in every mode; `None`: the fitted modes over the fitted range
    pub stable: Option<StretchRange>,
    /// The constant that complements the law; `None`: the law file lacks it and the scene has to add it
    pub partner: Option<Partner>,
    /// Poisson's ratio of a law that is fitted as compressible, if it has already been found; otherwise `partner` gives it
    pub poisson: Option<Poisson>,
    /// Volumetric part of the law file; `None`: the scene has to add it
    pub volumetric: Option<String>,
    /// 95 % half-widths of the errors that all data points share, in addition to those of the card
    pub accuracy: Accuracy,
    /// Strain offsets that are fitted with the constants
    pub slack: SlackChoice,
    /// Relative misfit up to which the law describes the data \[–\]
    pub tolerance: f64,
    /// Approximate number of ends of the range for which the fit is repeated, to show its dependence on the range; with 0 it is not repeated, which
    /// takes about a third of the time
    pub ranges: usize,
    /// Flag that is set from outside to stop the fit
    pub stop: Option<Arc<AtomicBool>>,
}

impl FitOptions {
    pub fn new(law: &str) -> Self {
        Self {
            law: law.into(),
            terms: None,
            modes: vec![],
            range: None,
            weighting: Weighting::Absolute,
            noise: None,
            loss: Loss::Squares,
            stable: None,
            partner: None,
            poisson: None,
            volumetric: None,
            accuracy: Accuracy::default(),
            slack: SlackChoice::Auto,
            tolerance: 0.1,
            ranges: 24,
            stop: None,
        }
    }
}

/// A fit as the command line requests it.
#[derive(Clone, Debug)]
pub struct FitRequest {
    pub data: PathBuf,
    /// Tables of further specimens of the same test
    pub more: Vec<PathBuf>,
    /// The card; by default the `card.toml` next to the table, if it names the table
    pub card: Option<PathBuf>,
    pub columns: ColumnChoice,
    pub preparation: Preparation,
    pub options: FitOptions,
}

impl FitRequest {
    pub fn new(data: impl Into<PathBuf>, law: &str) -> Self {
        Self {
            data: data.into(),
            more: vec![],
            card: None,
            columns: ColumnChoice::default(),
            preparation: Preparation::default(),
            options: FitOptions::new(law),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_two_ascending_positive_stretches() {
        assert_eq!("1..1.6".parse::<StretchRange>().expect("valid"), StretchRange { from: 1.0, to: 1.6 });
        for (text, reason) in [
            ("1", "no \"..\""),
            ("1..", "both sides"),
            ("0..2", "positive"),
            ("2..1", "smaller"),
            ("a..b", "both sides"),
        ] {
            let message = text.parse::<StretchRange>().expect_err(text).to_string();
            assert!(message.contains(reason), "{text}: {message}");
        }
    }

    #[test]
    fn an_incompressible_partner_is_refused() {
        assert!(Partner::Nu(0.49).check().is_ok());
        assert!(Partner::Nu(0.5).check().expect_err("0.5").to_string().contains("below 0.5"));
        assert!(Partner::Kappa(-1.0).check().is_err());
        assert!(Partner::Nu(f64::NAN).check().is_err());
    }
}
