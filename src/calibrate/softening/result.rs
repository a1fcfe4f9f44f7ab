//! Fitted constants of softening: intervals, descriptions, and `mullins.toml`, which the effect `mullins` includes.

use super::error::SofteningFitError;
use crate::calibrate::intake::accuracy::SharedError;
use crate::calibrate::{Bounded, CurveSet, ErrorModel, Estimate, FitResult, FitSummary, MeasuredCurves};
use crate::storage;
use serde::Serialize;
use std::fmt;
use std::path::Path;
use toml::{Table, Value};

/// Constants of softening with their 95 % intervals.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct SofteningFit {
    pub data: String,
    pub data_sha256: String,
    /// Law of the first loading and its constants
    pub law: &'static str,
    pub constants: Vec<Estimate>,
    pub version: &'static str,
    /// Number of fitted rows, those below the largest previous stretch
    pub rows: usize,
    /// Number of rows of the first loading, to which the law was fitted
    pub first_loading: usize,
    pub r: Bounded,
    /// \[Pa\]
    pub m: Bounded,
    pub beta: Bounded,
    /// Share of the largest ln λ that remains without stress \[–\]; if no set is shown, the range that the data allow
    pub set: Bounded,
    /// Whether the scatter of the data excludes a set of zero, so that the constants are those with the set
    pub has_set: bool,
    /// Whether r is at its bound: nearly the whole stress is lost somewhere
    pub at_bound: bool,
    /// m + βW_m \[Pa\] if all cycles reach one stretch: the data determine this sum, and neither m nor β
    pub scale: Option<Bounded>,
    pub errors: ErrorModel,
    /// Degrees of freedom of Student's t
    pub degrees: usize,
    /// Rms of the residual relative to that of the stress \[–\]
    pub misfit: f64,
    /// Largest W \[J/m³\]
    pub largest_energy: f64,
    /// Share of the largest W that the first cycle loses \[–\]
    pub lost: f64,
    /// Description, data and curve
    pub summary: FitSummary,
}

/// A summary without descriptions, data and curve, which are added once they are known.
pub fn summary() -> FitSummary {
    let curves = MeasuredCurves {
        x_label: "stretch [–]".into(),
        y_label: "nominal stress".into(),
        y_unit: "Pa".into(),
        log_x: false,
        log_y: false,
        sets: vec![],
    };
    let (title, answer, file) = (String::new(), String::new(), "mullins.toml".into());
    FitSummary { title, answer, constants: vec![], method: vec![], messages: vec![], notes: vec![], file, curves }
}

impl SofteningFit {
    /// Whether the data determine r, m and β.
    pub fn is_determined(&self) -> bool {
        let wide = |b: &Bounded| b.half_width().is_nan() || b.half_width() > b.value;
        !(self.at_bound || self.scale.is_some() || wide(&self.r) || wide(&self.m) && wide(&self.beta))
    }

    /// Adds the descriptions to the data and lines of the figure.
    pub(super) fn with_words(mut self, law: &FitResult, stated: &[SharedError], sets: Vec<CurveSet>) -> Self {
        let determined = self.is_determined();
        let s = &mut self.summary;
        s.title = format!("Softening from {}", self.data);
        s.answer = format!(
            "Softening of {} from {}: {} data points below their largest stretch, misfit {:.2} % rms; the first cycle to the largest stretch loses {:.1} % of its energy",
            law.label,
            self.data,
            self.rows,
            100.0 * self.misfit,
            100.0 * self.lost
        );
        s.constants = vec![
            ["r".into(), self.r.words("–")],
            ["m".into(), self.m.words("Pa")],
            ["beta".into(), self.beta.words("–")],
        ];
        s.method = vec![
            format!(
                "95 % intervals: {}; Student's t with {} degrees of freedom, with the errors of the constants of the law{}",
                self.errors,
                self.degrees,
                match stated.iter().map(|kind| kind.name()).collect::<Vec<_>>() {
                    names if names.is_empty() => String::new(),
                    names => format!(", and the stated errors of the {}", names.join(", the ")),
                }
            ),
            format!(
                "the law of the first loading was fitted to {} data points at or above every stretch before them",
                self.first_loading
            ),
        ];
        if self.has_set && self.set.interval[0] == 0.0 {
            s.messages
                .push("the set of the specimen is within the stated errors of the measurement: it may be none".into());
        }
        if self.has_set {
            s.constants.push(["set".into(), self.set.words("–")]);
            s.messages.push(format!(
                "the specimen keeps a set: {} of the largest logarithmic strain stays without stress. r, m and beta are those next to this set; the effect mullins has none, so that scenes return to rest: treat the specimen before the test by a larger cycle, or use the law within the strains above the set",
                self.set.words("–")
            ));
        } else {
            s.method.push(format!(
                "no permanent set is shown: at most {:.4} of the largest logarithmic strain (95 %)",
                self.set.interval[1]
            ));
        }
        if let Some(scale) = &self.scale {
            s.constants.push(["m + beta W_m".into(), scale.words("Pa")]);
        }
        if self.at_bound {
            s.messages.push("r is at its bound of 1: the unloading loses nearly the whole stress, as with slack, which this effect does not describe".into());
        } else if let Some(scale) = &self.scale {
            s.messages.push(format!(
                "all cycles reach the same stretch: the data determine m + beta W_m = {} only, W_m = {:.4} Pa. m with beta = 0 is taken, which holds for cycles to this stretch; cycles to several stretches tell m and beta apart",
                scale.words("Pa"),
                self.largest_energy
            ));
        } else if !determined {
            s.messages.push(
                "the data do not determine the constants of softening: an interval is wider than its value".into(),
            );
        }
        if self.misfit > 0.1 {
            s.messages.push(format!(
                "the softening misses the data by {:.0} % rms: unloading and reloading differ",
                100.0 * self.misfit
            ));
        }
        s.curves.sets = sets;
        self
    }

    /// Text of `mullins.toml`. Numbers have all their digits; there is no date, so that the same fit gives the same file.
    fn text(&self) -> String {
        let pascal = |v: f64| Value::from(format!("{v} Pa"));
        let mut softening = Table::new();
        softening.insert("r".into(), self.r.value.into());
        softening.insert("m".into(), pascal(self.m.value));
        softening.insert("beta".into(), self.beta.value.into());
        let mut p = Table::new();
        p.insert("data".into(), self.data.clone().into());
        p.insert("sha256".into(), self.data_sha256.clone().into());
        p.insert("law".into(), self.law.into());
        for e in &self.constants {
            p.insert(e.name.into(), if e.unit == "Pa" { pascal(e.value) } else { e.value.into() });
        }
        p.insert("rows".into(), i64::try_from(self.rows).expect("a table has fewer rows").into());
        p.insert("r_interval".into(), self.r.interval.to_vec().into());
        p.insert("m_interval".into(), self.m.interval.map(pascal).to_vec().into());
        p.insert("beta_interval".into(), self.beta.interval.to_vec().into());
        if let Some(scale) = &self.scale {
            p.insert("m_plus_beta_W_m".into(), pascal(scale.value));
            p.insert("m_plus_beta_W_m_interval".into(), scale.interval.map(pascal).to_vec().into());
        }
        p.insert("set".into(), if self.has_set { self.set.value } else { 0.0 }.into());
        p.insert("set_interval".into(), self.set.interval.to_vec().into());
        p.insert("errors".into(), self.errors.to_string().into());
        p.insert("misfit".into(), self.misfit.into());
        p.insert("determined".into(), self.is_determined().into());
        let texts = [&self.summary.messages[..], &self.summary.notes[..]].concat();
        p.insert("warnings".into(), texts.into());
        p.insert("durometer".into(), self.version.into());
        let root = Table::from_iter([
            ("softening".to_string(), softening.into()),
            ("provenance".to_string(), Value::Table(p)),
        ]);
        toml::to_string(&root).expect("a table of strings, numbers and arrays can be written")
    }

    /// Writes the file that the effect `mullins` includes.
    pub fn write_softening(&self, path: &Path) -> Result<(), SofteningFitError> {
        write(path, &self.text())
    }

    /// Writes the result as JSON.
    pub fn write_json(&self, path: &Path) -> Result<(), SofteningFitError> {
        write(path, &serde_json::to_string_pretty(self).expect("numbers, texts and lists can be written"))
    }
}

fn write(path: &Path, text: &str) -> Result<(), SofteningFitError> {
    storage::write(path, text.as_bytes()).map_err(|source| SofteningFitError::Write { path: path.into(), source })
}

impl fmt::Display for SofteningFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.summary.fmt(f)
    }
}
