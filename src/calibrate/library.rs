//! A library of law files: each with its constants, their intervals, the range of its data, its stability, and its stiffness.
//!
//! The stiffness of a fitted law is that of an incompressible material, so that laws of different kinds can be compared: the shear modulus μ₀ at rest, and
//! the nominal stress in uniaxial tension at λ = 2, which suppliers call the 100 % modulus.

use super::constant_format::within;
use super::judgement::certificate::certificate;
use super::{FitError, Mode, Model, read_law_file};
use crate::material::registry;
use crate::math::units::{self, Dimension};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A constant as a law file gives it.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ListedConstant {
    pub symbol: &'static str,
    /// \[SI\]
    pub value: f64,
    pub unit: &'static str,
    /// 95 % interval \[SI\], where the file has one
    pub interval: Option<[f64; 2]>,
}

/// A law file of a library.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ListedLaw {
    pub file: PathBuf,
    pub law: &'static str,
    pub constants: Vec<ListedConstant>,
    /// Stretches of the data, where the file says so
    pub fitted_stretch: Option<[f64; 2]>,
    /// Shear modulus at rest \[Pa\]
    pub shear_modulus: f64,
    /// Nominal stress in uniaxial tension at λ = 2 \[Pa\]; infinite where the law ends before
    pub stress_at_2: f64,
    /// λ = 2 was within the data
    pub measured_at_2: bool,
    /// Stretches in uniaxial tension over which the law is materially stable, as far as 1.5 times the data and at least 3 \[–\]
    pub stable: [f64; 2],
    /// Number of warnings of the fit
    pub warnings: usize,
    /// Table from which the constants come
    pub data: Option<String>,
    pub source: Option<String>,
}

/// The fitted laws among the TOML files of a folder and its folders, by file. Refuses a folder without any; other TOML files are passed over.
pub fn library(folder: &Path) -> Result<Vec<ListedLaw>, FitError> {
    let mut found = vec![];
    let mut folders = vec![folder.to_path_buf()];
    while let Some(at) = folders.pop() {
        let entries = std::fs::read_dir(&at).map_err(|source| FitError::Read { path: at.clone(), source })?;
        for path in entries.flatten().map(|e| e.path()) {
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.extend(listed(&path));
            }
        }
    }
    if found.is_empty() {
        return Err(FitError::NoLaws { path: folder.into() });
    }
    found.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(found)
}

/// `None` of a file that is no law file, or whose law has no form for fits.
fn listed(path: &Path) -> Option<ListedLaw> {
    let (table, provenance) = read_law_file(path).ok()?;
    let (entry, values, _) = registry::given(&table).ok()?;
    let form = entry.fit?;
    let named = |q: &crate::material::Parameter| values.get(q.name).copied();
    let given: Vec<f64> = form.parameters.iter().map_while(named).collect();
    let terms = form
        .term_counts
        .iter()
        .copied()
        .find(|n| Model::new(entry.info.name, Some(*n)).is_ok_and(|m| m.parameters().len() == given.len()))?;
    let model = Model::new(entry.info.name, Some(terms)).ok()?;
    let ratios: Vec<f64> = model.poisson_keys().filter_map(|k| values.get(&k).copied()).collect();
    // Terms of different ratios are no fit of this program
    if ratios.windows(2).any(|w| w[0] != w[1]) {
        return None;
    }
    let model = ratios.first().map_or(model, |nu| model.with_poisson(*nu));
    // Ogden's constants are those of the fit in its own convention only
    let other = table.get("convention").is_some_and(|c| c.as_str() != Some("ogden"));
    let pascal = |v: &toml::Value| match v {
        toml::Value::String(text) => units::parse(text, Dimension::PRESSURE).ok(),
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(n) => Some(*n as f64),
        _ => None,
    };
    let pair = |v: &toml::Value| {
        let [a, b] = v.as_array()?.as_slice() else { return None };
        Some([pascal(a)?, pascal(b)?])
    };
    let constant = |(q, value): (&crate::material::Parameter, &f64)| ListedConstant {
        symbol: q.symbol,
        value: *value,
        unit: super::model::unit(q),
        interval: provenance.get(&format!("{}_interval", q.name)).and_then(pair),
    };
    // Of a whole specimen, whose parts stretch from rest to the largest value
    let reached = || provenance.get("largest_stretch").and_then(toml::Value::as_float).map(|largest| [1.0, largest]);
    let fitted_stretch = provenance.get("fitted_stretch").and_then(pair).or_else(reached);
    let modulus = model.stress(&given, Mode::Uniaxial, 1.0 + 1e-6) / (2e-6 * (1.0 + model.nu));
    let reach = fitted_stretch.map_or(2.0, |[low, high]| high.max(1.0 / low));
    let stable = certificate(model, &given, modulus, reach).into_iter().find(|r| r.mode == "uniaxial")?;
    let stress = model.stress(&given, Mode::Uniaxial, 2.0);
    let text = |key: &str| provenance.get(key).and_then(|v| v.as_str()).map(String::from);
    (!other).then(|| ListedLaw {
        file: path.into(),
        law: model.name(),
        constants: model.parameters().iter().zip(&given).map(constant).collect(),
        fitted_stretch,
        shear_modulus: modulus,
        stress_at_2: if stress.is_finite() { stress } else { f64::INFINITY },
        measured_at_2: fitted_stretch.is_some_and(|[low, high]| low <= 2.0 && high >= 2.0),
        stable: [stable.below.unwrap_or(stable.looked[0]), stable.above.unwrap_or(stable.looked[1])],
        warnings: provenance.get("warnings").and_then(|w| w.as_array()).map_or(0, Vec::len),
        data: text("data"),
        source: text("source"),
    })
}

/// The laws as a table of text, one line each.
pub fn library_text(laws: &[ListedLaw], folder: &Path) -> String {
    let head = [
        "law file",
        "law",
        "constants (95 % interval)",
        "fitted λ",
        "μ₀ [kPa]",
        "P at λ = 2 [kPa]",
        "stable λ",
        "warnings",
    ];
    let row = |l: &ListedLaw| {
        let constant = |c: &ListedConstant| {
            let (factor, unit, n) = within(c.value, c.unit, c.interval);
            let unit = if unit == "–" { String::new() } else { format!(" {unit}") };
            let ends =
                c.interval.map_or(String::new(), |[a, b]| format!(" ({:.n$} to {:.n$})", factor * a, factor * b));
            format!("{} = {:.n$}{unit}{ends}", c.symbol, factor * c.value)
        };
        let range = |r: [f64; 2]| format!("{:.2} to {:.2}", r[0], r[1]);
        let mark = if l.measured_at_2 { "" } else { " *" };
        [
            l.file.strip_prefix(folder).unwrap_or(&l.file).display().to_string(),
            l.law.to_string(),
            l.constants.iter().map(constant).collect::<Vec<_>>().join(", "),
            l.fitted_stretch.map_or("–".into(), range),
            format!("{:.1}", 1e-3 * l.shear_modulus),
            format!("{:.1}{mark}", 1e-3 * l.stress_at_2),
            range(l.stable),
            l.warnings.to_string(),
        ]
    };
    let rows: Vec<[String; 8]> = std::iter::once(head.map(String::from)).chain(laws.iter().map(row)).collect();
    let width = |k: usize| rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 8] = std::array::from_fn(width);
    let line = |r: &[String; 8]| {
        let cells = r.iter().zip(widths).map(|(c, w)| format!("{c:w$}")).collect::<Vec<_>>();
        cells.join("  ").trim_end().to_string() + "\n"
    };
    let mut text: String = rows.iter().map(line).collect();
    if laws.iter().any(|l| !l.measured_at_2) {
        text += "* extrapolated: the data do not reach λ = 2\n";
    }
    text
}
