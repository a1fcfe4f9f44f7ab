//! Which columns hold strain and stress, of which kind, and in which unit.

use super::names::{self, Ranked, SURE, StrainKind, StressKind};
use super::table::{Decimal, Line, is_number};
use super::{Dimensions, FitError, Mode};
use crate::math::units::{self, Dimension};
use serde::{Deserialize, Serialize};

/// Statements of a card or the user on a table; a field that is `None` is detected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnChoice {
    pub strain: Option<String>,
    pub strain_kind: Option<StrainKind>,
    /// `%`, or `1` for none; of a displacement a length
    pub strain_unit: Option<String>,
    pub stress: Option<String>,
    pub stress_kind: Option<StressKind>,
    pub stress_unit: Option<String>,
    /// Strain and stress of the second direction of a biaxial test
    pub strain_2: Option<String>,
    pub stress_2: Option<String>,
    pub mode: Option<String>,
    pub time: Option<String>,
    pub decimal: Option<Decimal>,
    /// Of the test piece; a card has them under `[specimen]`
    #[serde(skip)]
    pub dimensions: Dimensions,
    /// `crosshead`, `extensometer` or what else; a card has it at the top
    #[serde(skip)]
    pub strain_measurement: Option<String>,
}

impl ColumnChoice {
    /// This choice, completed by another one.
    pub fn or(&self, other: &Self) -> Self {
        let text = |own: &Option<String>, other: &Option<String>| own.clone().or_else(|| other.clone());
        Self {
            strain: text(&self.strain, &other.strain),
            strain_kind: self.strain_kind.or(other.strain_kind),
            strain_unit: text(&self.strain_unit, &other.strain_unit),
            stress: text(&self.stress, &other.stress),
            stress_kind: self.stress_kind.or(other.stress_kind),
            stress_unit: text(&self.stress_unit, &other.stress_unit),
            strain_2: text(&self.strain_2, &other.strain_2),
            stress_2: text(&self.stress_2, &other.stress_2),
            mode: text(&self.mode, &other.mode),
            time: text(&self.time, &other.time),
            decimal: self.decimal.or(other.decimal),
            dimensions: self.dimensions.or(other.dimensions),
            strain_measurement: text(&self.strain_measurement, &other.strain_measurement),
        }
    }
}

/// A column with its factor to SI.
#[derive(Clone, Debug)]
pub struct Column<K> {
    pub at: usize,
    pub name: String,
    pub kind: K,
    /// "1" where none is stated
    pub unit: String,
    pub stated: bool,
    pub factor: f64,
}

/// The columns of a table.
#[derive(Clone, Debug)]
pub struct Columns {
    /// One per direction in which strain and stress are recorded
    pub axes: Vec<(Column<StrainKind>, Column<StressKind>)>,
    pub mode: Option<usize>,
    pub time: Option<usize>,
    /// \[m\], \[N\]: for who needs what the machine recorded
    pub displacement: Option<(usize, f64)>,
    pub force: Option<(usize, f64)>,
    /// Assumptions for the audit log
    pub notes: Vec<String>,
}

impl Columns {
    /// Every column that has to hold numbers
    pub fn numeric(&self) -> impl Iterator<Item = usize> + '_ {
        self.axes.iter().flat_map(|(e, p)| [e.at, p.at])
    }
}

/// The cells of the highest rank.
fn best<K>(cells: &[String], rank: fn(&str) -> Ranked<K>) -> Vec<usize> {
    let ranks: Vec<u8> = cells.iter().map(|c| rank(c).map_or(0, |r| r.0)).collect();
    let top = ranks.iter().copied().max().unwrap_or(0);
    if top == 0 { Vec::new() } else { (0..cells.len()).filter(|&i| ranks[i] == top).collect() }
}

fn named(cells: &[String], name: &str) -> Vec<usize> {
    (0..cells.len()).filter(|&i| cells[i].eq_ignore_ascii_case(name.trim())).collect()
}

fn candidates(cells: &[String], choice: &ColumnChoice) -> (Vec<usize>, Vec<usize>) {
    let pick = |name: &Option<String>, found: Vec<usize>| name.as_ref().map_or(found, |n| named(cells, n));
    (pick(&choice.strain, best(cells, names::strain)), pick(&choice.stress, best(cells, names::stress)))
}

/// The line that names both columns: the first one with numbers below, else the first one.
pub fn find_header(lines: &[Line], choice: &ColumnChoice) -> Option<usize> {
    let is_header = |line: &Line| {
        let (strain, stress) = candidates(&line.cells, choice);
        strain.iter().any(|s| stress.iter().any(|t| s != t))
    };
    let found = || (0..lines.len()).filter(|k| is_header(&lines[*k]));
    let has_numbers = |l: &Line| l.cells.iter().filter(|c| is_number(c)).count() >= 2;
    // A line of units may follow
    let above_numbers = |k: &usize| {
        let units = with_units(&lines[*k], lines.get(k + 1)).1;
        lines.get(k + 1 + usize::from(units)).is_some_and(has_numbers)
    };
    found().find(above_numbers).or_else(|| found().next())
}

/// Names with the units of a line of units below, and whether there is one.
pub fn with_units(names: &Line, below: Option<&Line>) -> (Line, bool) {
    let bare = |c: &str| c.trim_matches(['(', ')', '[', ']']).trim().to_string();
    let is_units =
        |l: &&Line| l.cells.iter().any(|c| names::is_unit(&bare(c))) && !l.cells.iter().any(|c| is_number(c));
    let Some(units) = below.filter(is_units) else { return (names.clone(), false) };
    let one = |(k, name): (usize, &String)| match units.cells.get(k).map(|c| bare(c)) {
        Some(unit) if !unit.is_empty() && names::unit(name).is_none() => format!("{name} ({unit})"),
        _ => name.clone(),
    };
    let cells = names.cells.iter().enumerate().map(one).collect();
    (Line { number: names.number, cells }, true)
}

/// Reads a header line. `mode` of every row, where it is known.
pub fn resolve(file: &str, header: &Line, choice: &ColumnChoice, mode: Option<Mode>) -> Result<Columns, FitError> {
    let cells = &header.cells;
    let (strain, stress) = candidates(cells, choice);
    let directions = if mode == Some(Mode::Biaxial) { 2 } else { 1 };
    let pick = |found: Vec<usize>, second: &Option<String>, what: &'static str, flag: &'static str| {
        let found = match second {
            Some(name) if directions == 2 => found.into_iter().take(1).chain(named(cells, name)).collect(),
            _ => found,
        };
        if found.len() == directions {
            return Ok(found);
        }
        let candidates = found.iter().map(|&i| format!("\"{}\"", cells[i])).collect();
        Err(match directions {
            1 => FitError::AmbiguousColumn { file: file.into(), what, flag, candidates },
            _ => FitError::TwoColumns { file: file.into(), what, flag, candidates },
        })
    };
    let strains = pick(strain, &choice.strain_2, "stretch, strain or displacement", "strain-column")?;
    let stresses = pick(stress, &choice.stress_2, "stress or force", "stress-column")?;
    let mut notes = Vec::new();
    let mut axes = Vec::new();
    for (e, p) in strains.into_iter().zip(stresses) {
        axes.push((
            strain_column(file, cells, e, choice, &mut notes)?,
            stress_column(file, cells, p, choice, &mut notes)?,
        ));
    }
    let absent = |name: &String| FitError::Columns {
        file: file.into(),
        missing: format!("the name \"{name}\""),
        found: quoted(cells),
    };
    let stated = |name: &String| named(cells, name).first().copied().ok_or_else(|| absent(name));
    let mode = match &choice.mode {
        Some(name) => Some(stated(name)?),
        None => (0..cells.len()).find(|&i| matches!(cells[i].to_lowercase().as_str(), "mode" | "loading mode")),
    };
    let time = match &choice.time {
        Some(name) => Some(stated(name)?),
        None => (0..cells.len()).find(|&i| names::is_time(&cells[i])),
    };
    let raw = |dimension: Dimension, is: &dyn Fn(&str) -> bool| {
        let factor = |i: usize| units::parse(&format!("1 {}", names::unit(&cells[i])?), dimension).ok();
        (0..cells.len()).filter(|i| is(&cells[*i])).find_map(|i| Some((i, factor(i)?)))
    };
    let own = |is_raw: bool, at: usize, factor: f64| is_raw.then_some((at, factor));
    let (e, p) = &axes[0];
    let displacement = own(e.kind == StrainKind::Displacement, e.at, e.factor)
        .or_else(|| raw(Dimension::LENGTH, &|n| names::strain(n).is_some_and(|r| r.1 == StrainKind::Displacement)));
    let force = own(p.kind == StressKind::Force, p.at, p.factor)
        .or_else(|| raw(Dimension::FORCE, &|n| names::stress(n).is_some_and(|r| r.1 == StressKind::Force)));
    Ok(Columns { displacement, force, axes, mode, time, notes })
}

fn strain_column(
    file: &str,
    cells: &[String],
    at: usize,
    choice: &ColumnChoice,
    notes: &mut Vec<String>,
) -> Result<Column<StrainKind>, FitError> {
    let name = cells[at].clone();
    let kind = match (choice.strain_kind, names::strain(&name)) {
        (Some(kind), _) => kind,
        (None, Some((rank, kind))) => {
            if kind == StrainKind::Engineering && rank < SURE {
                notes.push(format!("column \"{name}\" is taken as engineering strain"));
            }
            kind
        }
        (None, None) => return Err(FitError::StrainKind { file: file.into(), column: name }),
    };
    let stated = choice.strain_unit.clone().or_else(|| names::unit(&name));
    let (factor, wanted, example) = match (kind, &stated) {
        (StrainKind::Displacement, None) => {
            return Err(FitError::NoUnit { file: file.into(), column: name, flag: "strain-unit", example: "mm" });
        }
        (StrainKind::Displacement, Some(u)) => {
            (units::parse(&format!("1 {u}"), Dimension::LENGTH).ok(), "m, cm, mm, um, in", "displacement (mm)")
        }
        (_, u) => (names::strain_factor(u.as_deref().unwrap_or("1")), "1, mm/mm, %", "strain (%)"),
    };
    let (unit, stated) = (stated.clone().unwrap_or_else(|| "1".into()), stated.is_some());
    match factor {
        Some(factor) => Ok(Column { at, name, kind, unit, stated, factor }),
        None => {
            let flag = "strain-unit";
            Err(FitError::Unit { file: file.into(), column: name, unit, wanted, example, flag })
        }
    }
}

fn stress_column(
    file: &str,
    cells: &[String],
    at: usize,
    choice: &ColumnChoice,
    notes: &mut Vec<String>,
) -> Result<Column<StressKind>, FitError> {
    let name = cells[at].clone();
    let (rank, kind) = names::stress(&name).unwrap_or((0, StressKind::Nominal));
    let kind = choice.stress_kind.unwrap_or(kind);
    if choice.stress_kind.is_none() && kind == StressKind::Nominal && rank < SURE {
        notes.push(format!("column \"{name}\" is taken as nominal stress (force over undeformed area)"));
    }
    let (dimension, wanted, example, one) = match kind {
        StressKind::Force => (Dimension::FORCE, "N, mN, kN, gf, kgf, lbf", "force (N)", "N"),
        _ => (Dimension::PRESSURE, "Pa, hPa, kPa, MPa, GPa, bar, psi, N/mm^2", "nominal stress (MPa)", "MPa"),
    };
    let stated = names::unit(&name);
    let Some(unit) = choice.stress_unit.clone().or_else(|| stated.clone()) else {
        return Err(FitError::NoUnit { file: file.into(), column: name, flag: "stress-unit", example: one });
    };
    if let Some(stated) = stated.filter(|s| *s != unit) {
        notes.push(format!("column \"{name}\" is read in {unit} as requested, its name says {stated}"));
    }
    match units::parse(&format!("1 {unit}"), dimension) {
        Ok(factor) => Ok(Column { at, name, kind, unit, stated: true, factor }),
        Err(_) => {
            let flag = "stress-unit";
            Err(FitError::Unit { file: file.into(), column: name, unit, wanted, example, flag })
        }
    }
}

/// Names in quotes, empty ones left out
pub fn quoted(cells: &[String]) -> Vec<String> {
    cells.iter().filter(|c| !c.is_empty()).map(|c| format!("\"{c}\"")).collect()
}
