//! The part of a fit of a law in service that a page shows: description, constants, data and curve.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Measured and fitted values of one quantity, `[x, y]` in SI units.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct CurveSet {
    pub label: String,
    pub measured: Vec<[f64; 2]>,
    pub fitted: Vec<[f64; 2]>,
    /// `[x, measured − fitted]`
    pub residuals: Vec<[f64; 2]>,
    /// Lines of the fit, if they are not the fitted values joined in their order
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// Data of a figure of the fit.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct MeasuredCurves {
    pub x_label: String,
    pub y_label: String,
    pub y_unit: String,
    pub log_x: bool,
    pub log_y: bool,
    pub sets: Vec<CurveSet>,
}

/// Description, constants, data and curve of a fit.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct FitSummary {
    pub title: String,
    /// The result in a sentence
    pub answer: String,
    /// Name, value with its 95 % interval and unit
    pub constants: Vec<[String; 2]>,
    /// Method, source and intervals in sentences
    pub method: Vec<String>,
    /// Limits of the use of the numbers
    pub messages: Vec<String>,
    /// Notes on reading and on changes
    pub notes: Vec<String>,
    /// Name of the file that a scene includes
    pub file: String,
    pub curves: MeasuredCurves,
}

impl fmt::Display for FitSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.answer)?;
        let widest = self.constants.iter().map(|c| c[0].chars().count()).max().unwrap_or(0);
        for [name, words] in &self.constants {
            write!(f, "\n  {name:widest$}  {words}")?;
        }
        self.method.iter().try_for_each(|line| write!(f, "\n  {line}"))?;
        self.notes.iter().try_for_each(|note| write!(f, "\n  note: {note}"))?;
        self.messages.iter().try_for_each(|message| write!(f, "\n  warning: {message}"))
    }
}
