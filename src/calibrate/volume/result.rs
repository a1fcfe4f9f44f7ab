//! Poisson's ratio or the bulk modulus with its interval, as a description and as a file.

use super::error::VolumeError;
use super::line::{Line, Points};
use super::request::VolumeTest;
use crate::calibrate::constant_format::stress_text;
use crate::calibrate::{Bounded, CurveSet, ErrorModel, FitSummary, MeasuredCurves};
use crate::material::VolumetricKind;
use crate::storage;
use crate::wording;
use serde::Serialize;
use std::fmt;
use std::path::Path;
use toml::{Table, Value};

/// Files of a fit, and notes on reading them.
#[derive(Clone, Debug, Default)]
pub struct Data {
    pub files: Vec<String>,
    pub sha256: Vec<String>,
    /// Specimen of each row, counted from 0
    pub specimen: Vec<usize>,
    pub notes: Vec<String>,
}

/// A volumetric part that was tried.
pub struct Tried {
    kind: VolumetricKind,
    kappa: f64,
    misfit: f64,
    /// Whether it lies within the errors of the best one, whose interval includes its own
    allowed: bool,
}

impl Tried {
    pub fn of(kind: VolumetricKind, line: &Line, allowed: bool) -> Self {
        Self { kind, kappa: -line.slope.value, misfit: line.misfit, allowed }
    }
}

/// A fit of the change of volume.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct VolumeFit {
    pub data: String,
    pub data_sha256: String,
    pub test: VolumeTest,
    pub version: &'static str,
    pub rows: usize,
    /// ν \[–\] from a lateral strain, κ \[Pa\] from a bulk test
    pub value: Bounded,
    /// Offset of the line of each specimen: of ln λ_t \[–\], or of the pressure \[Pa\]
    pub offsets: Vec<Bounded>,
    /// Volumetric part of a bulk test
    pub volumetric: Option<&'static str>,
    pub errors: ErrorModel,
    pub misfit: f64,
    /// The interval reaches 0.5, or zero, so that the data give only a bound
    pub bound_only: bool,
    /// Description, data and curve
    pub summary: FitSummary,
    /// Abscissas of the data points: ln λ \[–\] for a lateral strain
    #[serde(skip)]
    pub(in crate::calibrate) abscissas: Vec<f64>,
}

/// Misfit below which a bend is rounding \[–\]
const ROUNDING: f64 = 1e-9;

/// Share of noise in the variance up to which intervals that include its effect keep their coverage \[–\]
const KNOWN: f64 = 0.2;

/// Misfit above which the line does not describe the data: more than a quarter of the variance remains \[–\]
const MOST: f64 = 0.5;

/// Messages about the limits of the use of the value.
fn messages(lateral: bool, bound_only: bool, value: &Bounded, line: &Line) -> Vec<String> {
    let mut messages = vec![];
    if bound_only && lateral {
        messages.push(format!(
            "the interval reaches 0.5: the lateral strain gives no bulk modulus, only nu ≥ {:.4}; measure pressure over volume, or the lateral strain more exactly",
            value.interval[0]
        ));
    } else if bound_only {
        messages.push("the interval of kappa reaches zero: the data do not determine it".into());
    }
    if line.misfit > MOST {
        let (what, law) = if lateral { ("lateral strain", "constant ratio") } else { ("pressure", "bulk modulus") };
        messages.push(format!(
            "the line leaves {:.0} % rms of the variation of the {what}: the data do not show a {law}; check the columns, measure more exactly, or use another range",
            100.0 * line.misfit
        ));
    }
    let scatter = line.errors.deviations.get(line.offsets.len()).copied().unwrap_or(0.0);
    if line.attenuation * line.slope.value.abs() > scatter {
        let (what, of) = if lateral { ("nu", "strain") } else { ("kappa", "volume") };
        let held = if line.attenuation > KNOWN {
            "more than its interval is sure to hold"
        } else {
            "which its interval holds"
        };
        messages.push(format!(
            "noise in the {of} may make {what} up to {:.1} % too small, {held}: measure the {of} more exactly, or give the means of several rows",
            100.0 * line.attenuation
        ));
    }
    let [a, b] = line.bend.interval;
    if a * b > 0.0 && line.misfit > ROUNDING {
        messages.push(if lateral {
            format!("ln λ_t bends over ln λ ({:.3e} of its square): the logarithmic Poisson's ratio is not constant over these strains; use a smaller range for small strains", line.bend.value)
        } else {
            "the pressure bends over the volume more than the volumetric part says; use a smaller range, or another part".into()
        });
    }
    messages
}

/// Data and line for a figure.
fn curves(lateral: bool, data: &Data, Points { x, y, specimen }: &Points, line: &Line) -> MeasuredCurves {
    let fitted = |k: usize| y[k] - line.residual[k];
    let set = |(one, file): (usize, &String)| {
        let own: Vec<usize> = (0..x.len()).filter(|k| specimen[*k] == one).collect();
        let mut order = own.clone();
        order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
        CurveSet {
            label: if data.files.len() == 1 { "measured".into() } else { file.clone() },
            measured: own.iter().map(|k| [x[*k], y[*k]]).collect(),
            fitted: order.iter().map(|k| [x[*k], fitted(*k)]).collect(),
            residuals: own.iter().map(|k| [x[*k], line.residual[*k]]).collect(),
            lines: vec![],
        }
    };
    let sets = data.files.iter().enumerate().map(set).collect();
    MeasuredCurves {
        x_label: if lateral { "ln λ [–]".into() } else { "U′(J)/κ [–]".into() },
        y_label: if lateral { "ln of the lateral stretch".into() } else { "pressure".into() },
        y_unit: if lateral { "1".into() } else { "Pa".into() },
        log_x: false,
        log_y: false,
        sets,
    }
}

/// Describes the error model, and lists the volumetric parts whose intervals the interval of the best one includes.
fn interval(test: VolumeTest, line: &Line, tried: &[Tried]) -> String {
    let errors = format!("95 % interval: {}", line.errors.model.words(test.responses()));
    let like: Vec<&str> = tried.iter().skip(1).filter(|t| t.allowed).map(|t| t.kind.name()).collect();
    match tried.first().filter(|_| !like.is_empty()) {
        Some(best) => format!(
            "{errors}; it holds that of {} too, which the data do not tell from {}",
            wording::all(&like),
            best.kind.name()
        ),
        None => errors,
    }
}

/// Describes the result. `tried`: the volumetric parts, the best first.
pub fn words(data: Data, test: VolumeTest, tried: &[Tried], points: &Points, line: Line) -> VolumeFit {
    let [low, high] = line.slope.interval;
    let value = Bounded { value: -line.slope.value, interval: [-high, -low] };
    let lateral = test == VolumeTest::Lateral;
    let bound_only = if lateral { value.interval[1] >= 0.5 } else { value.interval[0] <= 0.0 };
    let (symbol, unit) = if lateral { ("nu", "–") } else { ("kappa", "Pa") };
    let what = if lateral { "Poisson's ratio" } else { "Bulk modulus" };
    let messages = messages(lateral, bound_only, &value, &line);
    let mut method = vec![interval(test, &line, tried)];
    method.push(if lateral {
        "the logarithmic (Hencky) ratio −d ln λ_t/d ln λ, which is that of small strains at the beginning".into()
    } else {
        "p = −U′(J) of the volumetric part, with an offset of the pressure".into()
    });
    for Tried { kind, kappa, misfit, .. } in tried {
        method.push(format!("{}: kappa = {}, misfit {:.3} % rms", kind.name(), stress_text(*kappa), 100.0 * misfit));
    }
    let offset_unit = if lateral { "–" } else { "Pa" };
    let file = data.files.join(", ");
    let answer = format!(
        "{what} from {file}: {symbol} = {} ({} data points, misfit {:.2} % rms)",
        value.words(unit),
        points.x.len(),
        100.0 * line.misfit
    );
    let offset = |(k, o): (usize, &Bounded)| {
        let name = if line.offsets.len() == 1 { "offset".into() } else { format!("offset of {}", data.files[k]) };
        [name, o.words(offset_unit)]
    };
    let own = [symbol.to_string(), value.words(unit)];
    let constants = std::iter::once(own).chain(line.offsets.iter().enumerate().map(offset)).collect();
    let volumetric = tried.first().map(|t| t.kind.name());
    let summary = FitSummary {
        title: format!("{what} from {file}"),
        answer,
        constants,
        method,
        messages,
        notes: data.notes.clone(),
        file: "volume.toml".into(),
        curves: curves(lateral, &data, points, &line),
    };
    VolumeFit {
        data: file,
        data_sha256: data.sha256.join(", "),
        test,
        version: env!("CARGO_PKG_VERSION"),
        rows: points.x.len(),
        value,
        offsets: line.offsets,
        volumetric,
        errors: line.errors.model,
        misfit: line.misfit,
        bound_only,
        summary,
        abscissas: points.x.clone(),
    }
}

impl VolumeFit {
    /// Whether the data determine the value and not only a bound of it, and the line describes them.
    pub fn is_determined(&self) -> bool {
        !self.bound_only && self.misfit <= MOST
    }

    /// Text of `volume.toml`: keys for the table of a law.
    fn text(&self) -> String {
        let pascal = |v: f64| Value::from(format!("{v} Pa"));
        let mut root = Table::new();
        let mut p = Table::new();
        match self.volumetric {
            None => {
                root.insert("nu".into(), self.value.value.into());
                p.insert("nu_interval".into(), self.value.interval.to_vec().into());
            }
            Some(part) => {
                root.insert("kappa".into(), pascal(self.value.value));
                root.insert("volumetric".into(), part.into());
                p.insert("kappa_interval".into(), self.value.interval.map(pascal).to_vec().into());
            }
        }
        p.insert("data".into(), self.data.clone().into());
        p.insert("sha256".into(), self.data_sha256.clone().into());
        p.insert("rows".into(), i64::try_from(self.rows).expect("a table has fewer rows").into());
        p.insert("errors".into(), self.errors.words(self.test.responses()).into());
        p.insert("misfit".into(), self.misfit.into());
        p.insert("determined".into(), self.is_determined().into());
        p.insert("warnings".into(), self.summary.messages.clone().into());
        p.insert("durometer".into(), self.version.into());
        root.insert("provenance".into(), p.into());
        toml::to_string(&root).expect("a table of strings, numbers and arrays can be written")
    }

    /// Writes the keys for the table of a law.
    pub fn write_keys(&self, path: &Path) -> Result<(), VolumeError> {
        write(path, &self.text())
    }

    /// Writes the result as JSON.
    pub fn write_json(&self, path: &Path) -> Result<(), VolumeError> {
        write(path, &serde_json::to_string_pretty(self).expect("numbers, texts and lists can be written"))
    }
}

fn write(path: &Path, text: &str) -> Result<(), VolumeError> {
    storage::write(path, text.as_bytes()).map_err(|source| VolumeError::Write { path: path.into(), source })
}

impl fmt::Display for VolumeFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.summary.fmt(f)
    }
}
