//! Which column is the stretch, which the nominal stress, and in which unit.

use super::FitError;
use super::table::Line;
use crate::math::units::{self, Dimension};
use serde::{Deserialize, Serialize};

/// What a strain column holds: λ, or e = λ − 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StrainKind {
    Stretch,
    Engineering,
}

impl std::str::FromStr for StrainKind {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "stretch" => Ok(Self::Stretch),
            "engineering" => Ok(Self::Engineering),
            _ => Err(format!("\"{word}\" is not a kind of strain; known: stretch, engineering")),
        }
    }
}

/// Columns and units as stated by a card or by the user; what is `None` is detected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnChoice {
    pub strain: Option<String>,
    pub strain_kind: Option<StrainKind>,
    /// `%`, or `1` for none
    pub strain_unit: Option<String>,
    pub stress: Option<String>,
    pub stress_unit: Option<String>,
    pub mode: Option<String>,
}

impl ColumnChoice {
    /// This choice, completed by another one.
    pub fn or(&self, other: &Self) -> Self {
        Self {
            strain: self.strain.clone().or_else(|| other.strain.clone()),
            strain_kind: self.strain_kind.or(other.strain_kind),
            strain_unit: self.strain_unit.clone().or_else(|| other.strain_unit.clone()),
            stress: self.stress.clone().or_else(|| other.stress.clone()),
            stress_unit: self.stress_unit.clone().or_else(|| other.stress_unit.clone()),
            mode: self.mode.clone().or_else(|| other.mode.clone()),
        }
    }
}

/// The columns of a table with their names and their factors to SI.
#[derive(Clone, Debug)]
pub struct Columns {
    pub strain: usize,
    pub strain_name: String,
    pub strain_kind: StrainKind,
    pub strain_factor: f64,
    pub stress: usize,
    pub stress_name: String,
    pub stress_unit: String,
    pub stress_factor: f64,
    pub mode: Option<usize>,
    /// Assumptions for the audit log
    pub notes: Vec<String>,
}

fn words(name: &str) -> Vec<String> {
    name.to_lowercase().split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).map(String::from).collect()
}

fn has(words: &[String], any: &[&str]) -> bool {
    words.iter().any(|w| any.contains(&w.as_str()))
}

/// 0: not a strain column; 1: strain without a word on its kind; 2: engineering strain; 3: stretch.
fn strain_rank(name: &str) -> u8 {
    let w = words(name);
    if has(&w, &["true", "log", "logarithmic", "hencky", "rate", "stress"]) {
        0
    } else if has(&w, &["stretch", "lambda", "λ"]) {
        3
    } else if has(&w, &["strain"]) {
        if has(&w, &["engineering", "eng", "nominal"]) { 2 } else { 1 }
    } else {
        0
    }
}

/// 0: not a stress column; 1: stress without a word on its kind; 2: nominal stress.
fn stress_rank(name: &str) -> u8 {
    let w = words(name);
    if !has(&w, &["stress"]) || has(&w, &["true", "cauchy"]) {
        0
    } else if has(&w, &["engineering", "eng", "nominal", "pk1", "piola"]) {
        2
    } else {
        1
    }
}

/// The cells of the highest rank above zero.
fn best(cells: &[String], rank: fn(&str) -> u8) -> Vec<usize> {
    let top = cells.iter().map(|c| rank(c)).max().unwrap_or(0);
    if top == 0 { Vec::new() } else { (0..cells.len()).filter(|&i| rank(&cells[i]) == top).collect() }
}

fn named(cells: &[String], name: &str) -> Vec<usize> {
    (0..cells.len()).filter(|&i| cells[i].eq_ignore_ascii_case(name.trim())).collect()
}

fn candidates(cells: &[String], choice: &ColumnChoice) -> (Vec<usize>, Vec<usize>) {
    let strain = choice.strain.as_ref().map_or_else(|| best(cells, strain_rank), |n| named(cells, n));
    let stress = choice.stress.as_ref().map_or_else(|| best(cells, stress_rank), |n| named(cells, n));
    (strain, stress)
}

/// True where a line names both columns.
pub fn is_header(line: &Line, choice: &ColumnChoice) -> bool {
    let (strain, stress) = candidates(&line.cells, choice);
    strain.iter().any(|s| stress.iter().any(|t| s != t))
}

/// A unit in a column name: in brackets, or the last word where that is a unit of pressure or a percent sign.
fn unit_in(name: &str) -> Option<String> {
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let (Some(a), Some(b)) = (name.rfind(open), name.rfind(close))
            && a < b
        {
            let unit = name[a + open.len_utf8()..b].trim();
            return (!matches!(unit, "" | "-" | "–" | "1")).then(|| unit.to_string());
        }
    }
    let is_unit = |u: &str| {
        let text = format!("1 {u}");
        units::parse(&text, Dimension::PRESSURE).is_ok() || u == "%"
    };
    let last = |c: &[char]| name.rsplit(c).next().map(str::trim).filter(|u| is_unit(u)).map(String::from);
    last(&[' ']).or_else(|| last(&['_'])).or_else(|| last(&['/', ',']))
}

/// Reads a header line found by [`is_header`].
pub fn resolve(file: &str, header: &Line, choice: &ColumnChoice) -> Result<Columns, FitError> {
    let cells = &header.cells;
    let (strain, stress) = candidates(cells, choice);
    let single = |found: &[usize], what, flag| match found {
        [one] => Ok(*one),
        many => Err(FitError::AmbiguousColumn {
            file: file.into(),
            what,
            flag,
            candidates: many.iter().map(|&i| format!("\"{}\"", cells[i])).collect(),
        }),
    };
    let strain = single(&strain, "stretch or engineering strain", "strain-column")?;
    let stress = single(&stress, "nominal stress", "stress-column")?;
    let (strain_name, stress_name) = (cells[strain].clone(), cells[stress].clone());
    let mut notes = Vec::new();
    let strain_kind = match (choice.strain_kind, strain_rank(&strain_name)) {
        (Some(kind), _) => kind,
        (None, 3) => StrainKind::Stretch,
        (None, 2) => StrainKind::Engineering,
        (None, 1) => {
            notes.push(format!("column \"{strain_name}\" is taken as engineering strain"));
            StrainKind::Engineering
        }
        _ => return Err(FitError::StrainKind { file: file.into(), column: strain_name }),
    };
    if stress_rank(&stress_name) < 2 {
        notes.push(format!("column \"{stress_name}\" is taken as nominal stress (force over undeformed area)"));
    }
    let strain_unit = choice.strain_unit.clone().or_else(|| unit_in(&strain_name)).unwrap_or_else(|| "1".into());
    let strain_factor = match strain_unit.as_str() {
        "1" | "mm/mm" | "m/m" | "in/in" => 1.0,
        "%" | "percent" | "pct" => 0.01,
        _ => {
            return Err(FitError::Unit {
                file: file.into(),
                column: strain_name,
                unit: strain_unit,
                wanted: "1, mm/mm, %",
                example: "strain (%)",
                flag: "strain-unit",
            });
        }
    };
    let stated = unit_in(&stress_name);
    let stress_unit = choice.stress_unit.clone().or_else(|| stated.clone());
    let Some(stress_unit) = stress_unit else {
        return Err(FitError::NoUnit { file: file.into(), column: stress_name });
    };
    if let Some(stated) = stated.filter(|s| *s != stress_unit) {
        notes.push(format!("column \"{stress_name}\" is read in {stress_unit} as asked, its name says {stated}"));
    }
    let stress_factor = units::parse(&format!("1 {stress_unit}"), Dimension::PRESSURE).map_err(|_| FitError::Unit {
        file: file.into(),
        column: stress_name.clone(),
        unit: stress_unit.clone(),
        wanted: "Pa, hPa, kPa, MPa, GPa, bar, psi, N/mm^2",
        example: "nominal stress (MPa)",
        flag: "stress-unit",
    })?;
    let mode = match &choice.mode {
        Some(name) => Some(*named(cells, name).first().ok_or_else(|| FitError::Columns {
            file: file.into(),
            missing: format!("the name \"{name}\""),
            found: quoted(cells),
        })?),
        None => (0..cells.len()).find(|&i| matches!(cells[i].to_lowercase().as_str(), "mode" | "loading mode")),
    };
    Ok(Columns {
        strain,
        strain_name,
        strain_kind,
        strain_factor,
        stress,
        stress_name,
        stress_unit,
        stress_factor,
        mode,
        notes,
    })
}

/// Names in quotes, empty ones left out
pub fn quoted(cells: &[String]) -> Vec<String> {
    cells.iter().filter(|c| !c.is_empty()).map(|c| format!("\"{c}\"")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_column_names() {
        for (name, unit) in [
            ("Engineering Stress (MPa)", Some("MPa")),
            ("nominal_stress_MPa", Some("MPa")),
            ("stress [N/mm^2]", Some("N/mm^2")),
            ("Stress / kPa", Some("kPa")),
            ("stress N/mm^2", Some("N/mm^2")),
            ("strain %", Some("%")),
            ("strain (-)", None),
            ("nominal stress", None),
            ("stress (mpa)", Some("mpa")),
        ] {
            assert_eq!(unit_in(name).as_deref(), unit, "{name}");
        }
    }
}
