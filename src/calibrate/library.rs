//! A library of law files: each with its constants, their intervals, the range of its data, its stability, and its stiffness.
//!
//! The stiffness of a law that is fitted as incompressible is that of an incompressible material, so that laws of different kinds can be compared:
//! the shear modulus μ₀ at rest, and the nominal stress in uniaxial tension at λ = 2, which suppliers call the 100 % modulus. Foams, laws that are
//! not fitted, and laws given by constants other than those of a fit have the stiffness and the volume change of their file. Ogden's constants are
//! listed in Ogden's convention, whichever convention the file uses.

use super::constant_format::{largest_stress, within_size};
use super::fittable_law::unit;
use super::judgement::certificate::{StableRange, certificate, ranges};
use super::{FitError, FittableLaw, Mode, interval_of, provenance_pair, read_law_file};
use crate::material::registry::{self, Given};
use crate::material::{LoadCase, Parameter};
use crate::math::units::Dimension;
use crate::storage::{self, TEXT_LIMIT};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A constant as given in a law file.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ListedConstant {
    pub symbol: &'static str,
    /// \[SI\]
    pub value: f64,
    pub unit: &'static str,
    /// 95 % interval \[SI\], if the file has one; an open end is infinite
    pub interval: Option<[f64; 2]>,
}

/// A law file of a library.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ListedLaw {
    pub file: PathBuf,
    pub law: &'static str,
    pub constants: Vec<ListedConstant>,
    /// Range of stretches of the data, if the file states it
    pub fitted_stretch: Option<[f64; 2]>,
    /// Shear modulus at rest \[Pa\]
    pub shear_modulus: f64,
    /// Nominal stress in uniaxial tension at λ = 2 \[Pa\]; infinite if the law is not defined there
    pub stress_at_2: f64,
    /// Whether λ = 2 was within the data
    pub measured_at_2: bool,
    /// Stretches over which the law is materially stable in uniaxial, equibiaxial and planar tests, examined up to principal stretches of 1.5 times
    /// the data and at least 3 \[–\]
    pub stable: [f64; 2],
    /// Mode that limits the stable stretches at their lower and upper end; `None` if no mode does within the examined range
    pub stable_modes: [Option<&'static str>; 2],
    /// Range of stability of every mode
    pub stability: Vec<StableRange>,
    /// Number of warnings of the fit
    pub warnings: usize,
    /// Table from which the constants were determined
    pub data: Option<String>,
    pub source: Option<String>,
}

/// The law files of a folder.
#[derive(Clone, PartialEq, Debug)]
pub struct Library {
    pub laws: Vec<ListedLaw>,
    /// Files with a law, or with errors, that are not listed, each with the reason
    pub skipped: Vec<(PathBuf, String)>,
    /// TOML files of other kinds, which have no key `law`
    pub others: Vec<PathBuf>,
}

/// Lists the laws among the TOML files of a folder and its subfolders, by file. Refuses a folder without any.
pub fn library(folder: &Path) -> Result<Library, FitError> {
    let mut found = Library { laws: vec![], skipped: vec![], others: vec![] };
    for path in toml_files(folder)? {
        match listed(&path) {
            Ok(law) => found.laws.push(law),
            Err(_) if is_other(&path) => found.others.push(path),
            Err(reason) => found.skipped.push((path, reason)),
        }
    }
    if found.laws.is_empty() {
        return Err(FitError::NoLaws { path: folder.into(), skipped: found.passed_over(folder) });
    }
    Ok(found)
}

/// TOML files of a folder and its subfolders, in order.
fn toml_files(folder: &Path) -> Result<Vec<PathBuf>, FitError> {
    let mut found = vec![];
    let mut folders = vec![folder.to_path_buf()];
    while let Some(at) = folders.pop() {
        let entries = std::fs::read_dir(&at).map_err(|source| FitError::Read { path: at.clone(), source })?;
        for path in entries.flatten().map(|e| e.path()) {
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Whether this is a TOML file without a law.
fn is_other(path: &Path) -> bool {
    let table = storage::read_text(path, TEXT_LIMIT).ok().and_then(|text| text.parse::<toml::Table>().ok());
    table.is_some_and(|table| !table.contains_key("law"))
}

/// A law with its listed constants, its stiffness and its stability.
struct Described {
    constants: Vec<(&'static Parameter, f64)>,
    shear_modulus: f64,
    stress_at_2: f64,
    stability: Vec<StableRange>,
}

/// The law of a file, or the reason why it cannot be listed.
fn listed(path: &Path) -> Result<ListedLaw, String> {
    // The error of a file would repeat its name
    let own = |e: FitError| match e {
        FitError::LawFile { message, .. } => message,
        other => other.to_string(),
    };
    let (table, provenance) = read_law_file(path).map_err(own)?;
    let mut given = registry::given(&table).map_err(|e| e.to_string())?;
    // An interval of μ in another convention does not apply to the listed μ, which depends on α too
    let converted = given.0.to_own_convention.is_some_and(|convert| convert(&mut given.1, &mut given.2));
    // For a whole specimen, whose parts stretch from rest to the largest value
    let reached = || provenance.get("largest_stretch").and_then(toml::Value::as_float).map(|largest| [1.0, largest]);
    let fitted_stretch = provenance_pair(&provenance, "fitted_stretch").or_else(reached);
    let reach = fitted_stretch.map_or(2.0, |[low, high]| high.max(1.0 / low));
    let described = match fitted(&given) {
        Some((model, values)) => incompressible(model, &values, reach)?,
        None => as_given(&given, reach)?,
    };
    let constant = |(q, value): (&'static Parameter, f64)| ListedConstant {
        symbol: q.symbol,
        value,
        unit: unit(q),
        interval: interval_of(&provenance, q.name).filter(|_| !converted || q.dimension != Dimension::PRESSURE),
    };
    let (stable, stable_modes) = common(&described.stability);
    let text = |key: &str| provenance.get(key).and_then(|v| v.as_str()).map(String::from);
    Ok(ListedLaw {
        file: path.into(),
        law: given.0.info.name,
        constants: described.constants.into_iter().map(constant).collect(),
        fitted_stretch,
        shear_modulus: described.shear_modulus,
        stress_at_2: if described.stress_at_2.is_finite() { described.stress_at_2 } else { f64::INFINITY },
        measured_at_2: fitted_stretch.is_some_and(|[low, high]| low <= 2.0 && high >= 2.0),
        stable,
        stable_modes,
        stability: described.stability,
        warnings: provenance.get("warnings").and_then(|w| w.as_array()).map_or(0, Vec::len),
        data: text("data"),
        source: text("source"),
    })
}

/// The model and the constants of a law that is given by the constants of an incompressible fit.
fn fitted((entry, values, _): &Given) -> Option<(FittableLaw, Vec<f64>)> {
    let form = entry.fit.filter(|form| !form.compressible)?;
    let given = form.parameters.iter().filter(|q| values.contains_key(q.name)).count();
    let models = form.term_counts.iter().filter_map(|n| FittableLaw::new(entry.info.name, Some(*n)).ok());
    let model = models.into_iter().find(|m| m.parameters().len() == given)?;
    let constants = model.parameters().iter().map(|q| values.get(q.name).copied()).collect::<Option<_>>()?;
    Some((model, constants))
}

/// The law as an incompressible material.
fn incompressible(model: FittableLaw, values: &[f64], reach: f64) -> Result<Described, String> {
    let shear_modulus = model.stress(values, Mode::Uniaxial, 1.0 + 1e-6) / 3e-6;
    let stability = certificate(model, values, shear_modulus, reach);
    if stability.is_empty() {
        return Err(format!("its constants make no law: the shear modulus at rest is {shear_modulus:.4} Pa"));
    }
    let stress_at_2 = model.stress(values, Mode::Uniaxial, 2.0);
    let constants = model.parameters().iter().zip(values.iter().copied()).collect();
    Ok(Described { constants, shear_modulus, stress_at_2, stability })
}

/// The law with the volume change of its file.
fn as_given((entry, values, options): &Given, reach: f64) -> Result<Described, String> {
    let law = entry.build(values, options).map_err(|e| e.to_string())?;
    let keys = entry.keys.iter().filter_map(|q| Some((q, values.get(q.name).copied()?)));
    let at_2 = LoadCase::Uniaxial.state(law.as_ref(), 2.0);
    Ok(Described {
        constants: keys.collect(),
        shear_modulus: law.small_strain().mu,
        stress_at_2: at_2.map_or(f64::INFINITY, |s| s.stress),
        stability: ranges(law.as_ref(), reach),
    })
}

/// Stretches over which the law is stable in all modes that have a stretch, and the modes that limit them.
fn common(stability: &[StableRange]) -> ([f64; 2], [Option<&'static str>; 2]) {
    // Simple shear has the principal stretches of the planar mode
    let modes = || stability.iter().filter(|r| r.mode != Mode::SimpleShear);
    let end = |r: &StableRange, lost: Option<f64>, looked: f64| (lost.unwrap_or(looked), lost.map(|_| r.mode.name()));
    let low = modes().map(|r| end(r, r.below, r.looked[0])).max_by(|a, b| a.0.total_cmp(&b.0));
    let high = modes().map(|r| end(r, r.above, r.looked[1])).min_by(|a, b| a.0.total_cmp(&b.0));
    let (low, high) = (low.unwrap_or((1.0, None)), high.unwrap_or((1.0, None)));
    ([low.0, high.0], [low.1, high.1])
}

impl Library {
    /// The files that are not listed, one per line with the reason; files of other kinds in one line. Empty if there are none.
    pub fn passed_over(&self, folder: &Path) -> String {
        let name = |path: &Path| path.strip_prefix(folder).unwrap_or(path).display().to_string();
        let mut lines: Vec<String> =
            self.skipped.iter().map(|(p, reason)| format!("not listed: {}: {reason}", name(p))).collect();
        if !self.others.is_empty() {
            let names: Vec<String> = self.others.iter().map(|p| name(p)).collect();
            lines.push(format!("not listed, without a key `law`: {}", names.join(", ")));
        }
        lines.join("\n")
    }
}

/// The laws as a table of text, one line each, and the files that are not listed.
pub fn library_text(library: &Library, folder: &Path) -> String {
    let laws = &library.laws;
    let head = [
        "law file",
        "law",
        "constants (95 % interval)",
        "fitted λ",
        "μ₀ [kPa]",
        "P at λ = 2 [kPa]",
        "stable λ (all modes)",
        "warnings",
    ];
    let stable = |l: &ListedLaw| {
        let end =
            |k: usize| format!("{:.2}{}", l.stable[k], l.stable_modes[k].map_or(String::new(), |m| format!(" ({m})")));
        format!("{} to {}", end(0), end(1))
    };
    let row = |l: &ListedLaw| {
        let size = largest_stress(l.constants.iter().map(|c| (c.value, c.unit)));
        let constant = |c: &ListedConstant| {
            let printed = within_size(size, c.value, c.unit, c.interval);
            let ends = c.interval.map_or(String::new(), |ends| format!(" ({})", printed.ends(ends)));
            format!("{} = {}{ends}", c.symbol, printed.text(c.value))
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
            stable(l),
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
    if laws.iter().any(|l| l.stable_modes != [None, None]) {
        text += "A mode in brackets loses material stability at that stretch; the other ends are those that were examined\n";
    }
    text + &library.passed_over(folder)
}
