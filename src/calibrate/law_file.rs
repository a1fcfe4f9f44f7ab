//! `law.toml`: a law block that a scene includes, with its provenance.
//!
//! ```toml
//! law = "neo_hookean"
//! mu = "362000.5 Pa"
//! nu = 0.45              # only if it was given: the fit does not determine it
//! [provenance]
//! data = "…"
//! ```

use super::{AuditKind, FitError, FitResult, Loss, Partner, Weighting};
use crate::math::units::{self, Dimension};
use crate::storage::{self, TEXT_LIMIT};
use std::path::Path;
use toml::{Table, Value};

/// Relative rounding that a value at an end of its interval may have \[–\]
const ROUNDING: f64 = 1e-9;

impl FitResult {
    /// Text of the law file. Numbers have all their digits; there is no date, so that the same fit gives the same file.
    pub fn law_text(&self) -> String {
        let mut root = Table::new();
        // A number without a unit is written as one
        let quantity =
            |value: f64, unit: &str| if unit == "Pa" { Value::from(format!("{value} Pa")) } else { value.into() };
        root.insert("law".into(), self.law.into());
        for e in &self.parameters {
            root.insert(e.name.into(), quantity(e.value, e.unit));
        }
        let terms = self.poisson.iter().flat_map(|p| (1..=self.terms).map(move |n| (n, p.ratio.value)));
        terms.for_each(|(n, nu)| drop(root.insert(format!("nu{n}"), nu.into())));
        match self.partner {
            Some(Partner::Nu(nu)) => drop(root.insert("nu".into(), nu.into())),
            Some(Partner::Kappa(kappa)) => drop(root.insert("kappa".into(), quantity(kappa, "Pa"))),
            None => {}
        }
        if let Some(volumetric) = &self.volumetric {
            root.insert("volumetric".into(), volumetric.clone().into());
        }
        let texts = |items: Vec<String>| Value::from(items);
        let mut p = Table::new();
        p.insert("data".into(), self.data.clone().into());
        p.insert("sha256".into(), self.data_sha256.clone().into());
        if let Some(source) = &self.data_source {
            p.insert("source".into(), source.clone().into());
        }
        p.insert("mode".into(), texts(self.modes.iter().map(|m| m.name().to_string()).collect()));
        if let Some(range) = self.asked_range {
            p.insert("asked_stretch".into(), Value::from(vec![range.from, range.to]));
        }
        match self.weighting {
            Weighting::Absolute => {}
            Weighting::Relative => drop(p.insert("weighting".into(), "relative".into())),
            Weighting::Noise => drop(p.insert("weighting".into(), "noise".into())),
        }
        let changed = self.audit.of(AuditKind::Changed).map(|e| e.message.clone()).collect::<Vec<_>>();
        if !changed.is_empty() {
            p.insert("changed".into(), texts(changed));
        }
        if self.loss == Loss::Huber {
            p.insert("loss".into(), "huber".into());
        }
        p.insert("fitted_stretch".into(), Value::from(self.stretch.to_vec()));
        p.insert("rows".into(), i64::try_from(self.rows).expect("a table has fewer rows").into());
        for e in &self.parameters {
            let ends: Vec<Value> = e.interval.iter().map(|x| quantity(*x, e.unit)).collect();
            p.insert(format!("{}_interval", e.name), ends.into());
        }
        if let Some(poisson) = &self.poisson {
            let from = if poisson.measured { "lateral strain" } else { "given" };
            p.insert("poisson".into(), from.into());
            p.insert("poisson_interval".into(), poisson.ratio.interval.to_vec().into());
        }
        for (e, [low, high]) in self.parameters.iter().zip(&self.range_spread) {
            let ends = vec![quantity(*low, e.unit), quantity(*high, e.unit)];
            p.insert(format!("{}_over_shorter_ranges", e.name), ends.into());
        }
        for (e, [low, high]) in self.parameters.iter().zip(&self.in_use) {
            let ends = vec![quantity(*low, e.unit), quantity(*high, e.unit)];
            p.insert(format!("{}_interval_in_use", e.name), ends.into());
        }
        p.insert("errors".into(), self.errors.to_string().into());
        if !self.measurement.is_empty() {
            let stated =
                self.measurement.iter().map(|c| format!("{} ± {:e} {}", c.error, c.half_width, c.error.unit()));
            p.insert("measurement".into(), texts(stated.collect()));
        }
        if !self.slack.is_empty() {
            p.insert("slack".into(), Value::from(self.slack.iter().map(|s| s.strain).collect::<Vec<f64>>()));
        }
        p.insert("interval".into(), self.interval_assumption.clone().into());
        p.insert("rms".into(), quantity(self.misfit.rms_pa, "Pa"));
        p.insert("rms_relative".into(), self.misfit.rms_relative.into());
        p.insert("warnings".into(), texts(self.warnings.iter().map(ToString::to_string).collect()));
        p.insert("durometer".into(), self.version.into());
        p.extend(self.correlation_table());
        root.insert("provenance".into(), p.into());
        toml::to_string(&root).expect("a table of strings, numbers and arrays can be written")
    }

    /// The table `correlation` of the constants by pairs of names, `C10_C01`; `None` for a single constant, and if it says nothing about the
    /// intervals.
    fn correlation_table(&self) -> Option<(String, Value)> {
        let name = |k: usize| self.parameters[k].name;
        let of_row = |(a, row): (usize, &Vec<f64>)| {
            let others = row.iter().enumerate().skip(a + 1);
            others.map(|(b, r)| (correlation_key(name(a), name(b)), Value::from(*r))).collect::<Vec<_>>()
        };
        let all: Table = self.correlation.iter().enumerate().flat_map(of_row).collect();
        (!all.is_empty() && self.open_signs.is_empty()).then(|| ("correlation".into(), all.into()))
    }

    /// Writes `law.toml`.
    pub fn write_law(&self, path: &Path) -> Result<(), FitError> {
        storage::write(path, self.law_text().as_bytes()).map_err(|source| FitError::Write { path: path.into(), source })
    }
}

/// Reads the law block and the provenance (empty if there is none).
pub fn read_law_file(path: &Path) -> Result<(Table, Table), FitError> {
    let refuse = |message: String| FitError::LawFile { path: path.into(), message };
    let text = storage::read_text(path, TEXT_LIMIT).map_err(|source| FitError::Read { path: path.into(), source })?;
    let mut law: Table = toml::from_str(&text).map_err(|e| refuse(e.to_string()))?;
    let provenance = match law.remove("provenance") {
        None => Table::new(),
        Some(Value::Table(t)) => t,
        Some(_) => return Err(refuse("provenance must be a table, [provenance]".into())),
    };
    match law.get("law") {
        Some(Value::String(_)) => Ok((law, provenance)),
        _ => Err(refuse("has no law; write for example law = \"neo_hookean\"".into())),
    }
}

/// A pressure \[Pa\] or a number of the provenance, with `-inf Pa` for the open end of an interval.
fn provenance_number(value: &Value) -> Option<f64> {
    let text = |text: &str| match text.split_whitespace().next()? {
        "inf" => Some(f64::INFINITY),
        "-inf" => Some(f64::NEG_INFINITY),
        _ => units::parse(text, Dimension::PRESSURE).ok(),
    };
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).or_else(|| text(value.as_str()?))
}

/// Two numbers of the provenance, such as `fitted_stretch`.
pub fn provenance_pair(provenance: &Table, key: &str) -> Option<[f64; 2]> {
    let [a, b] = provenance.get(key)?.as_array()?.as_slice() else { return None };
    Some([provenance_number(a)?, provenance_number(b)?])
}

/// The 95 % interval of a constant \[SI\]; `None` if the file has none. An end that the data leave open is infinite; both are infinite if the file
/// states why there is no interval. The terms of a foam share Poisson's ratio and its interval.
pub fn interval_of(provenance: &Table, constant: &str) -> Option<[f64; 2]> {
    if provenance.contains_key(&format!("{constant}_without_interval")) {
        return Some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let of_poisson = || provenance_pair(provenance, "poisson_interval").filter(|[low, high]| high > low);
    provenance_pair(provenance, &format!("{constant}_interval"))
        .or_else(|| is_poisson_of_term(constant).then(of_poisson).flatten())
}

/// The interval of a constant with this value \[SI\]; `None` if the value lies outside it, so that it is not the value of the file.
pub fn interval_at(provenance: &Table, constant: &str, value: f64) -> Option<[f64; 2]> {
    let slack = ROUNDING * value.abs();
    interval_of(provenance, constant).filter(|[low, high]| (low - slack..=high + slack).contains(&value))
}

/// Key of the correlation of two constants.
pub fn correlation_key(a: &str, b: &str) -> String {
    format!("{a}_{b}")
}

/// Correlation of two constants \[–\], zero if the file has none.
pub fn correlation_of(provenance: &Table, a: &str, b: &str) -> f64 {
    let known = |key: String| provenance.get("correlation")?.get(key)?.as_float();
    known(correlation_key(a, b)).or_else(|| known(correlation_key(b, a))).unwrap_or(0.0)
}

/// Whether this constant is Poisson's ratio of one term of a foam, such as `nu2`.
pub fn is_poisson_of_term(constant: &str) -> bool {
    constant.strip_prefix("nu").is_some_and(|term| term.parse::<usize>().is_ok())
}

/// Reads the law block alone, as a scene includes it: `law` and the constants.
pub fn read_law_table(path: &Path) -> Result<Table, FitError> {
    read_law_file(path).map(|(law, _)| law)
}
