//! Detects which columns hold strain and stress, of which kind, and in which unit.

use super::dimensions::Dimensions;
use super::names::{self, Ranked, SURE, StrainKind, StressKind};
use super::roles::{Role, without_unit};
use super::table::{Decimal, Line, is_number};
use crate::calibrate::{FitError, Mode};
use crate::math::units::{self, Dimension};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// The direction of load that counts as positive. The program counts tension as positive.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sign {
    Tension,
    Compression,
}

impl FromStr for Sign {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "tension" => Ok(Self::Tension),
            "compression" => Ok(Self::Compression),
            _ => Err(format!("\"{word}\" is not a sign; known: tension, compression")),
        }
    }
}

/// Statements of a card or the user about a table; a field that is `None` is detected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnChoice {
    pub strain: Option<String>,
    pub strain_kind: Option<StrainKind>,
    /// `%`, or `1` for fractions; for a displacement a unit of length
    pub strain_unit: Option<String>,
    pub stress: Option<String>,
    pub stress_kind: Option<StressKind>,
    pub stress_unit: Option<String>,
    /// Strain and stress of the second direction of a biaxial test
    pub strain_2: Option<String>,
    pub stress_2: Option<String>,
    /// Strain across the load, which only foams use
    pub lateral: Option<String>,
    pub lateral_unit: Option<String>,
    pub mode: Option<String>,
    pub time: Option<String>,
    pub decimal: Option<Decimal>,
    /// The chosen one of several tests that are side by side, counted from 1
    pub test: Option<usize>,
    /// The direction of load whose strain and stress the table counts as positive
    pub positive: Option<Sign>,
    /// The direction of load whose stress the table counts as positive, if it differs from that of the strain
    pub stress_positive: Option<Sign>,
    /// The law is compressible, so that the conversion of a true stress needs the lateral strain
    #[serde(skip)]
    pub compressible: bool,
    /// Poisson's ratio of the compressible law, if it is given
    #[serde(skip)]
    pub ratio: Option<f64>,
    /// The mode was requested as compression
    #[serde(skip)]
    pub compression: bool,
    /// Dimensions of the test piece; a card has them under `[specimen]`
    #[serde(skip)]
    pub dimensions: Dimensions,
    /// `crosshead`, `extensometer` or another instrument; a card has it at the top level
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
            lateral: text(&self.lateral, &other.lateral),
            lateral_unit: text(&self.lateral_unit, &other.lateral_unit),
            mode: text(&self.mode, &other.mode),
            time: text(&self.time, &other.time),
            decimal: self.decimal.or(other.decimal),
            test: self.test.or(other.test),
            positive: self.positive.or(other.positive),
            stress_positive: self.stress_positive.or(other.stress_positive),
            compressible: self.compressible || other.compressible,
            ratio: self.ratio.or(other.ratio),
            compression: self.compression || other.compression,
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
    /// "1" if none is stated
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
    /// Column that tells specimens apart
    pub specimen: Option<usize>,
    /// Column and factor to SI \[m\], \[N\] of the recorded quantities of the machine
    pub displacement: Option<(usize, f64)>,
    pub force: Option<(usize, f64)>,
    /// Strain across the load, if a true stress needs it
    pub lateral: Option<Column<StrainKind>>,
    /// The column of strain across the load, if there is exactly one
    pub across: Option<usize>,
    /// Assumptions for the audit log
    pub notes: Vec<String>,
}

impl Columns {
    /// All columns that must hold numbers
    pub fn numeric(&self) -> impl Iterator<Item = usize> + '_ {
        self.axes.iter().flat_map(|(e, p)| [e.at, p.at])
    }
}

/// The cells with the highest rank.
fn best<K>(cells: &[String], rank: fn(&str) -> Ranked<K>) -> Vec<usize> {
    let ranks: Vec<u8> = cells.iter().map(|c| rank(c).map_or(0, |r| r.0)).collect();
    let top = ranks.iter().copied().max().unwrap_or(0);
    if top == 0 { Vec::new() } else { (0..cells.len()).filter(|&i| ranks[i] == top).collect() }
}

/// Columns with this name; `#3` is the third column.
fn named(cells: &[String], name: &str) -> Vec<usize> {
    let found: Vec<usize> = (0..cells.len()).filter(|&i| cells[i].eq_ignore_ascii_case(name.trim())).collect();
    let number = || name.trim().strip_prefix('#')?.parse::<usize>().ok()?.checked_sub(1).filter(|i| *i < cells.len());
    if found.is_empty() { number().into_iter().collect() } else { found }
}

fn candidates(cells: &[String], choice: &ColumnChoice) -> (Vec<usize>, Vec<usize>) {
    let pick = |name: &Option<String>, found: Vec<usize>| name.as_ref().map_or(found, |n| named(cells, n));
    (pick(&choice.strain, best(cells, names::strain)), pick(&choice.stress, best(cells, names::stress)))
}

/// True for a line that names one column of strain and another of stress.
pub fn is_header(cells: &[String], choice: &ColumnChoice) -> bool {
    let (strain, stress) = candidates(cells, choice);
    strain.iter().any(|s| stress.iter().any(|t| s != t))
}

/// True for a line with a number in every column that is chosen by its number.
pub fn is_row(cells: &[String], choice: &ColumnChoice) -> bool {
    let (strain, stress) = candidates(cells, choice);
    strain.iter().chain(&stress).all(|k| is_number(&cells[*k]))
}

/// The first line that names both columns, and whether there are numbers below it; a line with numbers below is preferred.
pub fn find_header(lines: &[Line], choice: &ColumnChoice) -> Option<(usize, bool)> {
    let found = || (0..lines.len()).filter(|k| is_header(&lines[*k].cells, choice));
    let has_numbers = |l: &Line| l.cells.iter().filter(|c| is_number(c)).count() >= 2;
    // Lines of units may follow
    let above_numbers = |k: &usize| {
        let below = below_names(lines, *k);
        lines.get(below).is_some_and(has_numbers)
    };
    found().find(above_numbers).map(|k| (k, true)).or_else(|| found().next().map(|k| (k, false)))
}

/// The first line below the names in line `at` that is neither empty nor a line of units.
pub fn below_names(lines: &[Line], at: usize) -> usize {
    let mut below = at + 1;
    while lines.get(below).is_some_and(|l| l.is_empty()) {
        below += 1;
    }
    if with_units(&lines[at], lines.get(below)).1 { below + 1 } else { below }
}

/// Names, completed by the units of a line of units below, and whether there is such a line.
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

/// Reads a header line. `mode`: the mode of all rows, if it is known.
pub fn resolve(file: &str, header: &Line, choice: &ColumnChoice, mode: Option<Mode>) -> Result<Columns, FitError> {
    let mut notes = Vec::new();
    let directions = if mode == Some(Mode::Biaxial) { 2 } else { 1 };
    let own = if directions == 1 { of_one_test(file, &header.cells, choice, &mut notes)? } else { None };
    let cells = own.as_ref().unwrap_or(&header.cells);
    let (strain, stress) = candidates(cells, choice);
    let pick = |found: Vec<usize>, second: &Option<String>, what: &'static str, flag: &'static str| {
        let found = match second {
            Some(name) if directions == 2 => found.into_iter().take(1).chain(named(cells, name)).collect(),
            _ => found,
        };
        if found.len() == directions {
            return Ok(found);
        }
        let candidates = found.iter().map(|&i| numbered(cells, i)).collect();
        Err(match directions {
            1 => FitError::AmbiguousColumn { file: file.into(), what, flag, candidates },
            _ => FitError::TwoColumns { file: file.into(), what, flag, candidates },
        })
    };
    let strains = pick(strain, &choice.strain_2, "stretch, strain or displacement", "strain-column")?;
    let stresses = pick(stress, &choice.stress_2, "stress or force", "stress-column")?;
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
        let factor = |i: usize| names::factor(&names::unit(&cells[i])?, dimension);
        (0..cells.len()).filter(|i| is(&cells[*i])).find_map(|i| Some((i, factor(i)?)))
    };
    let own = |is_raw: bool, at: usize, factor: f64| is_raw.then_some((at, factor));
    let (e, p) = &axes[0];
    let displacement = own(e.kind == StrainKind::Displacement, e.at, e.factor)
        .or_else(|| raw(Dimension::LENGTH, &|n| names::strain(n).is_some_and(|r| r.1 == StrainKind::Displacement)));
    let force = own(p.kind == StressKind::Force, p.at, p.factor)
        .or_else(|| raw(Dimension::FORCE, &|n| names::stress(n).is_some_and(|r| r.1 == StressKind::Force)));
    let specimen = (0..cells.len()).find(|&i| names::is_specimen(&cells[i]));
    let of_true = axes.iter().find(|(_, p)| p.kind == StressKind::True).filter(|_| choice.compressible);
    let lateral = of_true.map(|(_, p)| lateral_column(file, cells, &p.name, choice)).transpose()?;
    let across = <[usize; 1]>::try_from(across_the_load(cells, choice)).ok().map(|[at]| at);
    Ok(Columns { displacement, force, axes, mode, time, specimen, lateral, across, notes })
}

/// Strain along and across the load of a table, for callers that read the table by its contents.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Lateral {
    /// Names or numbers of the columns along and across the load
    pub strain: Option<String>,
    pub across: Option<String>,
    /// The direction of load whose strain counts as positive
    pub positive: Option<Sign>,
}

impl Lateral {
    /// Names of the columns with these names; numbers if a name is ambiguous.
    pub fn of(names: &[String], columns: &Columns) -> Self {
        let strain = &columns.axes[0].0;
        let positive = if strain.factor < 0.0 { Sign::Compression } else { Sign::Tension };
        // A line of units may have completed a name
        let call = |at: usize| {
            let own = without_unit(&names[at]);
            let is_alone =
                !own.is_empty() && names.iter().filter(|n| without_unit(n).eq_ignore_ascii_case(own)).count() == 1;
            if is_alone { own.to_string() } else { format!("#{}", at + 1) }
        };
        Self { strain: Some(call(strain.at)), across: columns.across.map(call), positive: Some(positive) }
    }
}

/// Columns of the strain across the load.
fn across_the_load(cells: &[String], choice: &ColumnChoice) -> Vec<usize> {
    let by_name = || (0..cells.len()).filter(|i| Role::Lateral.names(&cells[*i])).collect();
    choice.lateral.as_ref().map_or_else(by_name, |name| named(cells, name))
}

/// The column of the strain across the load; without it a true stress cannot be converted to a nominal one for a compressible law.
fn lateral_column(
    file: &str,
    cells: &[String],
    stress: &str,
    choice: &ColumnChoice,
) -> Result<Column<StrainKind>, FitError> {
    let found = across_the_load(cells, choice);
    let [at] = found[..] else {
        let candidates = found.iter().map(|i| numbered(cells, *i)).collect();
        return Err(FitError::TrueStress { file: file.into(), column: stress.into(), candidates });
    };
    let name = cells[at].clone();
    let kind = match () {
        () if names::is_stretch(&name) => StrainKind::Stretch,
        () if names::is_true(&name) => StrainKind::True,
        () => StrainKind::Engineering,
    };
    let bare = names::is_unitless(&name) || kind == StrainKind::Stretch;
    let own = choice.lateral_unit.clone().or_else(|| names::unit(&name)).or_else(|| bare.then(|| "1".into()));
    let (flag, example) = ("lateral-unit", "%");
    let unit = own.ok_or_else(|| FitError::NoUnit { file: file.into(), column: name.clone(), flag, example })?;
    let Some(factor) = names::strain_factor(&unit) else {
        let (wanted, example) = ("1, %, ‰, mm/mm, µε", "lateral strain (%)");
        return Err(FitError::Unit { file: file.into(), column: name, unit, wanted, example, flag });
    };
    Ok(Column { at, name, kind, unit, stated: true, factor })
}

/// A name with its position, `"Load (N)" (#3)`.
fn numbered(cells: &[String], i: usize) -> String {
    format!("\"{}\" (#{})", cells[i], i + 1)
}

/// Names of the columns of one of several tests side by side, with the names of the other tests emptied; `None` if the table has one test.
///
/// k columns of strain and k of stress are k tests if each pair precedes the next. A test has as many columns as there are from one column of strain
/// to the next; columns before the first test belong to all tests.
fn of_one_test(
    file: &str,
    cells: &[String],
    choice: &ColumnChoice,
    notes: &mut Vec<String>,
) -> Result<Option<Vec<String>>, FitError> {
    let (strain, stress) = candidates(cells, choice);
    let (strains, stresses) = candidates(cells, &ColumnChoice::default());
    let pairs: Vec<[usize; 2]> = strains.iter().zip(&stresses).map(|(e, p)| [*e.min(p), *e.max(p)]).collect();
    let several = pairs.len() > 1 && strains.len() == stresses.len() && pairs.windows(2).all(|w| w[0][1] < w[1][0]);
    if !several {
        return match choice.test {
            Some(asked) if asked != 1 => Err(FitError::NoTest { file: file.into(), asked, found: 1 }),
            _ => Ok(None),
        };
    }
    if choice.test.is_none() && strain.len() == 1 && stress.len() == 1 {
        return Ok(None);
    }
    // The name of one column selects the test, too
    let stated = match (&strain[..], &stress[..]) {
        ([one], _) | (_, [one]) => pairs.iter().position(|p| p.contains(one)),
        _ => None,
    };
    let Some(test) = choice.test.map(|n| n - 1).or(stated) else {
        let tests =
            pairs.iter().map(|[a, b]| format!("{} with {}", numbered(cells, *a), numbered(cells, *b))).collect();
        return Err(FitError::SideBySide { file: file.into(), tests });
    };
    let Some([from, to]) = pairs.get(test) else {
        return Err(FitError::NoTest { file: file.into(), asked: test + 1, found: pairs.len() });
    };
    let period = pairs[1][0] - pairs[0][0];
    let lead = pairs[0][0].min(period.saturating_sub(1 + pairs[0][1] - pairs[0][0]));
    let common = ..pairs[0][0] - lead;
    let own = from - lead..(from - lead + period).max(to + 1);
    notes.push(format!(
        "{} tests stand side by side; number {} is read, {} with {}",
        pairs.len(),
        test + 1,
        numbered(cells, *from),
        numbered(cells, *to)
    ));
    let keep = |(i, name): (usize, &String)| {
        if common.contains(&i) || own.contains(&i) { name.clone() } else { String::new() }
    };
    Ok(Some(cells.iter().enumerate().map(keep).collect()))
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
    let own = names::unit(&name);
    contradiction(notes, &name, own.as_ref(), choice.strain_unit.as_ref());
    if let (Some(kind), Some((_, own))) = (choice.strain_kind, names::strain(&name))
        && kind != own
    {
        notes.push(format!(
            "column \"{name}\" is read as {} as requested, its name says {}",
            kind.words(),
            own.words()
        ));
    }
    let stated = choice.strain_unit.clone().or(own);
    let (factor, wanted, example) = match (kind, &stated) {
        (StrainKind::Displacement, None) => {
            return Err(FitError::NoUnit { file: file.into(), column: name, flag: "strain-unit", example: "mm" });
        }
        (StrainKind::Displacement, Some(u)) => {
            (names::factor(u, Dimension::LENGTH), "m, cm, mm, um, in", "displacement (mm)")
        }
        (_, u) => (names::strain_factor(u.as_deref().unwrap_or("1")), "1, mm/mm, %", "strain (%)"),
    };
    let (unit, stated) = (stated.clone().unwrap_or_else(|| "1".into()), stated.is_some());
    if !stated && factor.is_some() && kind != StrainKind::Stretch {
        notes.push(format!("column \"{name}\" has no unit and is read in fractions: 0.5 is 50 %"));
    }
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
    if let (Some(asked), Some((_, own))) = (choice.stress_kind, names::stress(&name))
        && asked != own
    {
        notes.push(format!(
            "column \"{name}\" is read as {} as requested, its name says {}",
            asked.words(),
            own.words()
        ));
    }
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
    contradiction(notes, &name, stated.as_ref(), choice.stress_unit.as_ref());
    match names::factor(&unit, dimension) {
        Some(factor) => Ok(Column { at, name, kind, unit: units::spelled(&unit), stated: true, factor }),
        None => {
            let flag = "stress-unit";
            Err(FitError::Unit { file: file.into(), column: name, unit, wanted, example, flag })
        }
    }
}

/// Notes that a requested unit contradicts the unit in the name; the request counts.
fn contradiction(notes: &mut Vec<String>, name: &str, own: Option<&String>, asked: Option<&String>) {
    if let (Some(own), Some(asked)) = (own, asked)
        && own != asked
    {
        notes.push(format!("column \"{name}\" is read in {asked} as requested, its name says {own}"));
    }
}

/// Names in quotes; empty names are left out
pub fn quoted(cells: &[String]) -> Vec<String> {
    cells.iter().filter(|c| !c.is_empty()).map(|c| format!("\"{c}\"")).collect()
}
