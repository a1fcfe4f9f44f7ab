//! A fit as stored in `fit.json`, and its constants in words.

use crate::calibrate::{
    AuditEntry, Band, Contribution, FitCurves, Loss, Misfit, Prediction, Printed, StableRange, Treatment, Validity,
    Weighting, largest_stress, within_size,
};
use crate::report::names::symbol;
use serde::{Deserialize, Deserializer};

/// The part of `fit.json` that is reported. Stresses and stiffnesses in Pa, stretches \[–\].
#[derive(Clone, Debug, Deserialize)]
pub struct StoredFit {
    /// Name of the law with the number of its terms
    pub label: String,
    pub formula: String,
    pub law_source: String,
    pub data: String,
    pub data_sha256: String,
    pub data_source: Option<String>,
    pub version: String,
    pub modes: Vec<String>,
    /// Smallest and largest fitted λ
    pub stretch: [f64; 2],
    pub rows: usize,
    pub parameters: Vec<StoredConstant>,
    pub weighting: Weighting,
    pub loss: Loss,
    pub interval_assumption: String,
    /// Intervals for use; `None` for an open end, because JSON has no infinity
    pub in_use: Vec<[Option<f64>; 2]>,
    pub measurement: Vec<Contribution>,
    pub scatter: Option<Scatter>,
    pub otherwise: Vec<Otherwise>,
    /// Given value of `nu` or `kappa` \[Pa\]
    pub partner: Option<std::collections::BTreeMap<String, f64>>,
    /// Contraction in fits that are not incompressible
    #[serde(default)]
    pub poisson: Option<Contraction>,
    pub stability: Vec<StableRange>,
    pub misfit: Misfit,
    pub validity: Validity,
    pub predictions: Vec<Prediction>,
    pub range_dependence: Vec<Range>,
    /// Range of each constant over fits to shorter ranges
    pub range_spread: Vec<[f64; 2]>,
    /// The warnings in words
    pub messages: Vec<String>,
    /// Messages that are only for information; files of earlier versions lack them
    #[serde(default)]
    notes: Vec<String>,
    /// Whether one of the messages is serious; files of earlier versions lack it
    #[serde(default)]
    doubtful: Option<bool>,
    pub curves: FitCurves,
    pub audit: Vec<AuditEntry>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredConstant {
    pub name: String,
    #[serde(deserialize_with = "with_subscripts")]
    pub symbol: String,
    pub unit: String,
    pub value: f64,
    /// Standard error; `None` if the data do not determine the constant, because JSON has no infinity
    pub std_error: Option<f64>,
    pub interval: [Option<f64>; 2],
}

/// Poisson's ratio that the lateral stretches of a fit follow.
#[derive(Clone, Debug, Deserialize)]
pub struct Contraction {
    pub ratio: Ratio,
    /// Whether it comes from a column of lateral strain, otherwise it was given
    pub measured: bool,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Ratio {
    pub value: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Scatter {
    pub specimens: Vec<Specimen>,
    pub means: Vec<f64>,
    pub deviations: Vec<f64>,
    pub next: Vec<Band>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Specimen {
    pub file: String,
    pub rows: usize,
    pub parameters: Vec<StoredConstant>,
    /// Level at which the specimens are compared; `None` if they have no stretch in common
    pub level: Option<f64>,
}

/// The fit repeated with data that were treated differently.
#[derive(Clone, Debug, Deserialize)]
pub struct Otherwise {
    pub treatment: Treatment,
    pub rows: usize,
    pub parameters: Vec<StoredConstant>,
    pub change: f64,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Range {
    pub to: f64,
    pub rows: usize,
    pub parameters: Vec<StoredConstant>,
    pub rms_relative: f64,
}

/// Reads a symbol and writes it as in a paper, `C10` as C₁₀.
fn with_subscripts<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    String::deserialize(from).map(|text| symbol(&text))
}

impl StoredFit {
    /// Whether the result is doubtful; for files that do not say so, whether there is any message.
    pub fn is_doubtful(&self) -> bool {
        self.doubtful.unwrap_or(!self.messages.is_empty())
    }

    /// Returns the messages except those that are only for information.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        self.messages.iter().filter(|message| !self.notes.contains(message)).map(String::as_str)
    }

    /// Returns unit and digits of every constant: two digits of the half-width of its interval, stresses in one unit.
    pub fn printed(&self) -> Vec<Printed<'_>> {
        let size = largest_stress(self.parameters.iter().map(|p| (p.value, p.unit.as_str())));
        self.parameters.iter().map(|p| within_size(size, p.value, &p.unit, p.ends())).collect()
    }
}

impl StoredConstant {
    /// Returns both ends of the interval, if the data determine the constant.
    pub fn ends(&self) -> Option<[f64; 2]> {
        Some([self.interval[0]?, self.interval[1]?])
    }

    /// Formats a constant as `357 kPa (95 % interval 334 to 380 kPa)`.
    pub fn words(&self, printed: &Printed) -> String {
        let value = printed.text(self.value);
        match self.ends() {
            Some(ends) => format!("{value} (95 % interval {})", printed.span(ends)),
            None => format!("{value} (not determined by the data)"),
        }
    }
}
