//! Columns by their content: time, strain, frequency, moduli, pressure, volume, for tests that are not tensile curves.

use super::names::{self, Condition, StrainKind, VolumeKind};
use super::table::{self, Decimal, Line};
use crate::math::units::Dimension;
use crate::storage::columns::{Rows, TableError, units_below};
use crate::storage::{self, DATA_LIMIT};
use crate::wording::{all, first};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Content of a column.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Role {
    Time,
    Strain,
    Stress,
    Frequency,
    Storage,
    Loss,
    TanDelta,
    /// Strain across the load
    Lateral,
    Pressure,
    /// Volume relative to the undeformed volume, or its relative change
    Volume,
}

impl Role {
    const ALL: [Self; 10] = [
        Self::Time,
        Self::Strain,
        Self::Stress,
        Self::Frequency,
        Self::Storage,
        Self::Loss,
        Self::TanDelta,
        Self::Lateral,
        Self::Pressure,
        Self::Volume,
    ];

    /// The name in flags and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Strain => "strain",
            Self::Stress => "stress",
            Self::Frequency => "frequency",
            Self::Storage => "storage",
            Self::Loss => "loss",
            Self::TanDelta => "tan_delta",
            Self::Lateral => "lateral",
            Self::Pressure => "pressure",
            Self::Volume => "volume",
        }
    }

    /// Whether a column of this name holds this content.
    pub(super) fn names(self, name: &str) -> bool {
        let lower = name.to_lowercase();
        let symbol = lower.split(['[', '(', ' ', '_']).next().unwrap_or_default().to_string();
        let is = |symbols: &[&str]| symbols.contains(&symbol.as_str());
        let tells = |any: &[&str]| any.iter().any(|w| lower.contains(w));
        let tan = names::is_tan_delta(name);
        let is_angle = tells(&["angle", "winkel"]);
        let loss = is(&["e''", "g''", "e\"", "g\"", "e″", "g″"]) || (tells(&["loss", "verlust"]) && !tan && !is_angle);
        let storage = is(&["e'", "g'", "e′", "g′"]) || tells(&["storage", "speicher"]);
        match self {
            Self::Time => names::is_time(name) || is(&["t"]),
            Self::Strain => names::strain(name).is_some(),
            Self::Stress => names::stress(name).is_some() || (tells(&["modul"]) && !loss && !storage),
            Self::Frequency => tells(&["freq", "fréq", "omega", "pulsation"]) || is(&["f", "ω"]),
            Self::Storage => storage,
            Self::Loss => loss,
            Self::TanDelta => tan,
            Self::Lateral => tells(&["lateral", "transverse", "querdehnung", "transversal"]),
            Self::Pressure => tells(&["pressure", "pression"]) || (tells(&["druck"]) && !tells(&["kraft", "spannung"])),
            Self::Volume => tells(&["volume", "volumen", "volumetric", "v/v0"]) || is(&["j"]),
        }
    }

    /// An example of a unit for a column of this name.
    fn example(self, name: &str) -> &'static str {
        match self {
            Self::Volume if names::volume(name) == Some(VolumeKind::Ratio) => "1",
            Self::Time => "s",
            Self::Strain | Self::Lateral | Self::Volume => "%",
            Self::Stress | Self::Storage | Self::Loss | Self::Pressure => "MPa",
            Self::Frequency => "Hz",
            Self::TanDelta => "1",
        }
    }
}

impl FromStr for Role {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|r| r.name() == word).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|r| r.name()).collect();
            format!("\"{word}\" is no content of a column; known: {}", known.join(", "))
        })
    }
}

/// Reasons why the columns of a table were not read.
#[derive(Debug, thiserror::Error)]
pub enum ColumnError {
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("{file}: no line names columns of {}; the nearest one has {}. Name a column by --column, for example --column {}=NAME", missing.join(", "), found.join(", "), missing.first().and_then(|m| m.split(' ').next()).unwrap_or("time"))]
    Columns { file: String, missing: Vec<&'static str>, found: Vec<String> },
    #[error("{file}: there is no column \"{name}\", which --column {role} names; the nearest line of names has {}", found.join(", "))]
    NoColumn { file: String, role: &'static str, name: String, found: Vec<String> },
    #[error("--{flag} {role} has no effect here: the test has {}; leave it out", all(contents))]
    Idle { flag: &'static str, role: &'static str, contents: Vec<&'static str> },
    #[error("{file}: {} could be the column of {role}; choose one with --column {role}=NAME", candidates.join(" and "))]
    Ambiguous { file: String, role: &'static str, candidates: Vec<String> },
    #[error("{file}: column \"{column}\" has no unit; pass --unit {role}=… such as --unit {role}={example}")]
    NoUnit { file: String, column: String, role: &'static str, example: &'static str },
    #[error("{file}: column \"{column}\": \"{unit}\" is no unit of {role}; {remedy}")]
    Unit { file: String, column: String, unit: String, role: &'static str, remedy: String },
    #[error(
        "{file}: column \"{column}\" is an angular frequency by its name, and one in cycles by its unit; pass --unit frequency=rad/s or --unit frequency={unit}"
    )]
    Angular { file: String, column: String, unit: String },
    #[error("{file}: {} cells are no numbers: {}; remove or mend these lines", cells.len(), first(cells))]
    Cells { file: String, cells: Vec<String> },
}

/// The columns that a test needs, with the statements about them.
pub struct Wanted<'a> {
    pub all: &'a [Role],
    /// Contents of which the test needs one in addition
    pub one: &'a [Role],
    /// Names of columns, or numbers such as `#3`
    pub columns: &'a BTreeMap<Role, String>,
    pub units: &'a BTreeMap<Role, String>,
    /// Contents that may have no unit
    pub unitless: &'a [Role],
}

/// A column that was read, in SI units.
pub struct ReadColumn {
    pub name: String,
    pub unit: String,
    pub dimension: Option<Dimension>,
    pub values: Vec<f64>,
}

impl ReadColumn {
    /// Whether most of its numbers are positive.
    pub fn is_positive(&self) -> bool {
        self.values.iter().filter(|v| **v > 0.0).count() > self.values.len() / 2
    }

    /// Whether the column is a stretch, which has no sign.
    pub fn is_stretch(&self) -> bool {
        names::strain(&self.name).is_some_and(|r| r.1 == StrainKind::Stretch)
    }

    /// Changes the sign of every number, with a note.
    pub fn turn(&mut self, notes: &mut Vec<String>) {
        self.values.iter_mut().for_each(|v| *v = -*v);
        notes.push(format!("column \"{}\" counts compression as positive; its sign was changed", self.name));
    }
}

/// A table that was read.
pub struct ReadTable {
    /// Name of the file
    pub file: String,
    pub sha256: String,
    pub columns: BTreeMap<Role, ReadColumn>,
    /// Line of each value
    pub lines: Vec<u64>,
    pub notes: Vec<String>,
    /// Columns of temperature and amplitude, which are conditions of the test
    pub conditions: Vec<ConditionColumn>,
}

/// A condition of the test in each line that records it, in the unit of the table.
pub struct ConditionColumn {
    pub name: String,
    pub condition: Condition,
    pub values: Vec<Option<f64>>,
}

/// Reads the wanted columns of a file.
pub fn read(path: &Path, wanted: &Wanted) -> Result<ReadTable, ColumnError> {
    let contents = || wanted.all.iter().chain(wanted.one);
    for (flag, stated) in [("column", wanted.columns), ("unit", wanted.units)] {
        if let Some(role) = stated.keys().find(|role| !contents().any(|own| own == *role)) {
            return Err(ColumnError::Idle {
                flag,
                role: role.name(),
                contents: contents().map(|r| r.name()).collect(),
            });
        }
    }
    let bytes = storage::read(path, DATA_LIMIT).map_err(|source| ColumnError::Read { path: path.into(), source })?;
    let file = path.file_name().map_or_else(|| path.into(), PathBuf::from).display().to_string();
    let (text, encoding) = table::decode(&bytes).map_err(|what| TableError::NotText { file: file.clone(), what })?;
    let reader = Reader { file: &file, wanted };
    let (delimiter, lines, at, columns) = reader.find_columns(&text)?;
    let mut notes: Vec<String> =
        encoding.map(|e| format!("the file is not UTF-8; it was read as {e}")).into_iter().collect();
    let units = units_below(&lines, at, |l| !l.cells.iter().any(|c| table::is_number(c)));
    let rows = Rows::under(&file, delimiter, &lines, at, units.unwrap_or(at) + 1)?;
    let columns = reader.numbers(&lines[at].cells, units.map(|k| &lines[k].cells), &rows, &columns)?;
    for (role, column) in &columns {
        let unit = if column.unit == "1" { String::new() } else { format!(" in {}", column.unit) };
        notes.push(format!("\"{}\" was read as {}{unit}", column.name, role.name()));
    }
    let conditions = conditions(&lines[at].cells, &rows.body);
    let lines = rows.body.iter().map(|l| l.number).collect();
    Ok(ReadTable { sha256: storage::sha256(&bytes), file, columns, lines, notes, conditions })
}

fn conditions(names: &[String], body: &[&Line]) -> Vec<ConditionColumn> {
    let one = |(k, name): (usize, &String)| {
        let condition = names::condition(name)?;
        let cell = |l: &&Line| l.cells.get(k).cloned().unwrap_or_default();
        let cells: Vec<String> = body.iter().map(cell).collect();
        let decimal = Decimal::of(cells.iter().map(String::as_str)).ok()?;
        let values = cells.iter().map(|c| table::number(c, decimal).ok()).collect();
        Some(ConditionColumn { name: name.clone(), condition, values })
    };
    names.iter().enumerate().filter_map(one).collect()
}

struct Reader<'a> {
    file: &'a str,
    wanted: &'a Wanted<'a>,
}

type Columns = BTreeMap<Role, usize>;

impl Reader<'_> {
    fn file(&self) -> String {
        self.file.into()
    }

    /// Delimiter, lines, index of the line with the names, and the columns.
    fn find_columns(&self, text: &str) -> Result<(char, Vec<Line>, usize, Columns), ColumnError> {
        let mut nearest: (Vec<&'static str>, Vec<String>) = (vec![], vec![]);
        for delimiter in table::DELIMITERS {
            let lines = table::split(text, delimiter);
            for (at, line) in lines.iter().enumerate().take(200) {
                // A line of numbers holds no names, unless the columns are given by number
                if line.cells.iter().any(|c| table::is_number(c)) {
                    continue;
                }
                let (columns, missing) = self.columns_of(&line.cells)?;
                if missing.is_empty() {
                    return Ok((delimiter, lines, at, columns));
                }
                let found: Vec<String> =
                    line.cells.iter().filter(|c| !c.is_empty()).map(|c| format!("\"{c}\"")).collect();
                let better = nearest.1.is_empty() || (missing.len(), nearest.1.len()) < (nearest.0.len(), found.len());
                if better && !found.is_empty() {
                    nearest = (missing, found);
                }
            }
        }
        if nearest.1.is_empty() {
            nearest = (self.wanted.all.iter().map(|r| r.name()).collect(), vec!["no line of names".into()]);
        }
        let stated = |missing: &&'static str| {
            let role = missing.parse::<Role>().ok()?;
            Some((role.name(), self.wanted.columns.get(&role)?.clone()))
        };
        let (file, (missing, found)) = (self.file(), nearest);
        Err(match missing.iter().find_map(stated) {
            Some((role, name)) => ColumnError::NoColumn { file, role, name, found },
            None => ColumnError::Columns { file, missing, found },
        })
    }

    /// The columns of a line of names, and the contents that are missing.
    fn columns_of(&self, cells: &[String]) -> Result<(Columns, Vec<&'static str>), ColumnError> {
        let (all, one) = (self.wanted.all, self.wanted.one);
        let mut columns = Columns::new();
        let stated = |name: &String| {
            let same = |cell: &str| cell.eq_ignore_ascii_case(name.trim());
            let alone = |cell: &&String| same(without_unit(cell));
            let by_unit = || {
                let found = cells.iter().position(|c| same(without_unit(c)));
                found.filter(|_| cells.iter().filter(alone).count() == 1)
            };
            let by_name = cells.iter().position(|c| same(c)).or_else(by_unit);
            let number =
                || name.trim().strip_prefix('#')?.parse::<usize>().ok()?.checked_sub(1).filter(|k| *k < cells.len());
            by_name.or_else(number)
        };
        for role in all.iter().chain(one) {
            let found: Vec<usize> = match self.wanted.columns.get(role) {
                Some(name) => stated(name).into_iter().collect(),
                None => (0..cells.len()).filter(|k| role.names(&cells[*k])).collect(),
            };
            match found[..] {
                [] => {}
                [k] => drop(columns.insert(*role, k)),
                _ => {
                    let candidates = found.iter().map(|k| format!("\"{}\" (#{})", cells[*k], k + 1)).collect();
                    return Err(ColumnError::Ambiguous { file: self.file(), role: role.name(), candidates });
                }
            }
        }
        let mut missing: Vec<&'static str> =
            all.iter().filter(|r| !columns.contains_key(r)).map(|r| r.name()).collect();
        if !one.is_empty() && !one.iter().any(|r| columns.contains_key(r)) {
            missing.push("loss or tan_delta");
        }
        if columns.contains_key(&Role::Loss) {
            columns.remove(&Role::TanDelta);
        }
        // One cell that names two contents belongs to a line with another delimiter
        let shared = |role: &&Role| columns.iter().any(|(other, k)| other < *role && columns.get(role) == Some(k));
        missing.extend(all.iter().filter(shared).map(|r| r.name()));
        Ok((columns, missing))
    }

    /// Unit of a column with its factor to SI and dimension.
    fn unit(
        &self,
        role: Role,
        name: &str,
        below: Option<&String>,
    ) -> Result<(f64, String, Option<Dimension>), ColumnError> {
        let bare = |c: &String| c.trim_matches(['(', ')', '[', ']']).trim().to_string();
        let last = || name.rsplit(['_', ' ']).next().filter(|w| *w != name).map(String::from);
        let is_own = |u: &String| factor(role, u).is_some() || names::factor(u, Dimension::ANGLE).is_some();
        // The brackets of "Tan(delta)" hold no unit
        let plain = ["(delta)", "(Delta)", "(δ)"].iter().fold(name.to_string(), |n, part| n.replace(part, ""));
        let in_name = if names::is_unitless(&plain) {
            Some("1".into())
        } else {
            names::unit(&plain).or_else(|| last().filter(is_own))
        };
        let own = in_name.or_else(|| below.map(bare).filter(|u| !u.is_empty()));
        let stated = self.wanted.units.get(&role).cloned().or(own);
        let no_unit = || ColumnError::NoUnit {
            file: self.file(),
            column: name.into(),
            role: role.name(),
            example: role.example(name),
        };
        let bare_number = self.wanted.unitless.contains(&role)
            || role == Role::TanDelta
            || role == Role::Strain && names::strain(name).is_some_and(|r| r.1 == StrainKind::Stretch);
        let dimensionless = bare_number.then_some("1");
        let unit = stated.or_else(|| dimensionless.map(String::from)).ok_or_else(no_unit)?;
        let (factor, dimension) = factor(role, &unit).ok_or_else(|| ColumnError::Unit {
            file: self.file(),
            column: name.into(),
            unit: unit.clone(),
            role: role.name(),
            remedy: remedy(role, name, &unit),
        })?;
        if !(names::is_angular(name) && dimension == Some(Dimension::FREQUENCY)) {
            return Ok((factor, unit, dimension));
        }
        match (unit.ends_with("Hz"), self.wanted.units.contains_key(&role)) {
            (true, false) => Err(ColumnError::Angular { file: self.file(), column: name.into(), unit }),
            (true, true) => Ok((factor, unit, dimension)),
            (false, _) => {
                let unit = unit.strip_prefix("1/").map_or_else(|| format!("rad {unit}"), |time| format!("rad/{time}"));
                Ok((factor, unit, Some(Dimension::ANGULAR_VELOCITY)))
            }
        }
    }

    /// The numbers of every column in SI units.
    fn numbers(
        &self,
        names: &[String],
        units: Option<&Vec<String>>,
        rows: &Rows,
        columns: &Columns,
    ) -> Result<BTreeMap<Role, ReadColumn>, ColumnError> {
        let places: Vec<usize> = columns.values().copied().collect();
        let decimal = rows.decimal(&places, None)?;
        let (mut read, mut wrong) = (BTreeMap::new(), vec![]);
        for (role, at) in columns {
            let (factor, unit, dimension) = self.unit(*role, &names[*at], units.and_then(|u| u.get(*at)))?;
            let mut values = vec![];
            for line in &rows.body {
                let cell = line.cells.get(*at).map_or("", String::as_str);
                match table::number(cell, decimal) {
                    Ok(x) if (factor * x).is_finite() => values.push(factor * x),
                    _ => wrong.push(format!("line {} \"{cell}\"", line.number)),
                }
            }
            read.insert(*role, ReadColumn { name: names[*at].clone(), unit, dimension, values });
        }
        if wrong.is_empty() { Ok(read) } else { Err(ColumnError::Cells { file: self.file(), cells: wrong }) }
    }
}

/// A cell without its unit: `sigma` for `sigma (kPa)` or `sigma [kPa]`.
pub(super) fn without_unit(cell: &str) -> &str {
    cell.split(['(', '[']).next().unwrap_or_default().trim()
}

/// The remedy for a unit that does not fit the content: the numbers have to be converted together with the unit.
fn remedy(role: Role, name: &str, unit: &str) -> String {
    if role == Role::Strain && names::factor(unit, Dimension::LENGTH).is_some() {
        return "divide the displacement by the gauge length, and give the strain".into();
    }
    let (example, role) = (role.example(name), role.name());
    format!(
        "convert the numbers to one such as {example}, or, if that is no unit but a note, pass --unit {role}=… with the unit of the numbers"
    )
}

/// Factor to SI and dimension of a unit for a content.
fn factor(role: Role, unit: &str) -> Option<(f64, Option<Dimension>)> {
    let of = |d: Dimension| names::factor(unit, d).map(|f| (f, Some(d)));
    let none = || names::strain_factor(unit).map(|f| (f, Some(Dimension::NONE)));
    match role {
        Role::Time => of(Dimension::TIME),
        Role::Frequency => of(Dimension::FREQUENCY).or_else(|| of(Dimension::ANGULAR_VELOCITY)),
        Role::Storage | Role::Loss | Role::Pressure => of(Dimension::PRESSURE),
        Role::Stress => of(Dimension::PRESSURE).or_else(|| of(Dimension::FORCE)).or_else(none),
        Role::Strain | Role::TanDelta | Role::Lateral | Role::Volume => none(),
    }
}
