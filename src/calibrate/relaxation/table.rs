//! From a table (CSV) of a test in time or frequency to a [`Record`], and the request for a fit.

use super::error::RelaxationError;
use super::response::{Driven, Record, TestKind};
use crate::calibrate::intake::names::{self, StrainKind, StressKind};
use crate::calibrate::intake::table::{self, Decimal, Line};
use crate::calibrate::read_law_table;
use crate::material::{Law, Want, law_from_table};
use crate::math::tensor::Mat3;
use crate::math::units::Dimension;
use crate::storage::{self, DATA_LIMIT};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a column holds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Role {
    Time,
    Strain,
    Stress,
    Frequency,
    Storage,
    Loss,
    TanDelta,
}

impl Role {
    const ALL: [Self; 7] =
        [Self::Time, Self::Strain, Self::Stress, Self::Frequency, Self::Storage, Self::Loss, Self::TanDelta];

    /// Name in flags and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Strain => "strain",
            Self::Stress => "stress",
            Self::Frequency => "frequency",
            Self::Storage => "storage",
            Self::Loss => "loss",
            Self::TanDelta => "tan_delta",
        }
    }

    /// Whether a column of this name holds it.
    fn names(self, name: &str) -> bool {
        let lower = name.to_lowercase();
        let symbol = lower.split(['[', '(', ' ', '_']).next().unwrap_or_default().to_string();
        let is = |symbols: &[&str]| symbols.contains(&symbol.as_str());
        let tells = |any: &[&str]| any.iter().any(|w| lower.contains(w));
        let tan = tells(&["tan", "loss factor", "loss_factor", "verlustfaktor"]);
        let loss = is(&["e''", "g''", "e\"", "g\"", "e″", "g″"]) || (tells(&["loss", "verlust"]) && !tan);
        let storage = is(&["e'", "g'", "e′", "g′"]) || tells(&["storage", "speicher"]);
        match self {
            Self::Time => names::is_time(name) || is(&["t"]),
            Self::Strain => names::strain(name).is_some(),
            Self::Stress => names::stress(name).is_some() || (tells(&["modul"]) && !loss && !storage),
            Self::Frequency => tells(&["freq", "fréq", "omega", "kreisfrequenz"]) || is(&["f", "ω"]),
            Self::Storage => storage,
            Self::Loss => loss,
            Self::TanDelta => tan,
        }
    }

    fn example(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Strain => "%",
            Self::Stress | Self::Storage | Self::Loss => "MPa",
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

/// How the terms of the series are chosen.
#[derive(Clone, PartialEq, Debug)]
pub enum TermChoice {
    /// Times by least squares, their number by the information criterion
    Evidence,
    /// This number of times, by least squares
    Number(usize),
    /// These times \[s\]
    Times(Vec<f64>),
    /// So many times in each decade of the data
    PerDecade(usize),
}

/// Request for a fit of a Prony series.
#[derive(Clone, PartialEq, Debug)]
pub struct RelaxationRequest {
    pub data: PathBuf,
    pub kind: TestKind,
    /// Names of columns, or numbers such as `#3`
    pub columns: BTreeMap<Role, String>,
    pub units: BTreeMap<Role, String>,
    /// Duration of the loading \[s\] in relaxation and creep
    pub ramp: Option<f64>,
    /// Time of the table at which the loading begins \[s\]
    pub start: f64,
    /// Held stress of a creep test \[Pa\]
    pub stress: Option<f64>,
    /// File of the elastic law of a uniaxial history at finite strain
    pub law: Option<PathBuf>,
    pub terms: TermChoice,
}

impl RelaxationRequest {
    /// A request without statements on the table.
    pub fn new(data: impl Into<PathBuf>, kind: TestKind) -> Self {
        Self {
            data: data.into(),
            kind,
            columns: BTreeMap::new(),
            units: BTreeMap::new(),
            ramp: None,
            start: 0.0,
            stress: None,
            law: None,
            terms: TermChoice::Evidence,
        }
    }

    /// Refuses flags that contradict each other or mean nothing.
    fn check(&self) -> Result<(), RelaxationError> {
        let bad = |flag, value: f64, remedy| Err(RelaxationError::Flag { flag, value: value.to_string(), remedy });
        let contradiction =
            |flag, remedy| Err(RelaxationError::Contradiction { flag, experiment: self.kind.name(), remedy });
        let held = matches!(self.kind, TestKind::Relaxation | TestKind::Creep);
        match (&self.terms, self.ramp, self.stress) {
            (TermChoice::Number(0) | TermChoice::PerDecade(0), ..) => {
                return bad("--terms", 0.0, "a series has at least one term");
            }
            (TermChoice::Number(n) | TermChoice::PerDecade(n), ..) if *n > 12 => {
                return bad("--terms", *n as f64, "no data determine more than 12; take fewer");
            }
            (TermChoice::Times(times), ..)
                if times.is_empty() || times.iter().any(|t| !(*t > 0.0 && t.is_finite())) =>
            {
                return bad("--times", f64::NAN, "give positive times such as \"0.1 s,1 s,10 s\"");
            }
            (_, Some(r), _) if !(r >= 0.0 && r.is_finite()) => return bad("--ramp", r, "a duration is not negative"),
            (_, _, Some(s)) if s == 0.0 || !s.is_finite() => return bad("--stress", s, "a held stress is not zero"),
            (_, Some(_), _) if !held => return contradiction("--ramp", "the loading is in the data"),
            (_, _, Some(_)) if self.kind != TestKind::Creep => {
                return contradiction("--stress", "the stress is in the data");
            }
            _ => {}
        }
        match self.law {
            Some(_) if self.kind != TestKind::History => {
                contradiction("--law", "only a measured strain needs the elastic law; take --experiment history")
            }
            _ => Ok(()),
        }
    }
}

/// A column that was read, in SI units.
struct Read {
    name: String,
    unit: String,
    dimension: Option<Dimension>,
    values: Vec<f64>,
}

/// Reads the table of a request.
pub fn read(request: &RelaxationRequest) -> Result<Record, RelaxationError> {
    request.check()?;
    let path = &request.data;
    let bytes =
        storage::read(path, DATA_LIMIT).map_err(|source| RelaxationError::Read { path: path.clone(), source })?;
    let file = path.file_name().map_or_else(|| path.clone(), PathBuf::from).display().to_string();
    let (text, encoding) =
        table::decode(&bytes).map_err(|what| RelaxationError::NotText { file: file.clone(), what })?;
    let reader = Reader { file: &file, request };
    let (lines, at, columns) = reader.find_columns(&text)?;
    let mut notes: Vec<String> =
        encoding.map(|e| format!("the file is not UTF-8; it was read as {e}")).into_iter().collect();
    let units_below = lines.get(at + 1).is_some_and(|l| !l.cells.iter().any(|c| table::is_number(c)));
    let below = at + 1 + usize::from(units_below);
    let body: Vec<&Line> = lines[below.min(lines.len())..].iter().filter(|l| !l.is_empty()).collect();
    let own = units_below.then(|| &lines[at + 1].cells);
    let mut read = reader.numbers(&lines[at].cells, own, &body, &columns)?;
    for (role, column) in &read {
        let unit = if column.unit == "1" { String::new() } else { format!(" in {}", column.unit) };
        notes.push(format!("\"{}\" is the {}{unit}", column.name, role.name()));
    }
    let numbers: Vec<u64> = body.iter().map(|l| l.number).collect();
    let numbers = reader.order(&mut read, numbers, &mut notes)?;
    let mut record = match request.kind {
        TestKind::Dynamic => reader.dynamic(read, &numbers)?,
        TestKind::History => reader.history(read, &numbers)?,
        TestKind::Relaxation | TestKind::Creep => reader.held(read, &numbers, &mut notes)?,
    };
    record.sha256 = storage::sha256(&bytes);
    record.notes = notes;
    if record.y.iter().all(|y| *y == 0.0) {
        return Err(RelaxationError::Zero { file });
    }
    Ok(record)
}

struct Reader<'a> {
    file: &'a str,
    request: &'a RelaxationRequest,
}

type Columns = BTreeMap<Role, usize>;

impl Reader<'_> {
    fn file(&self) -> String {
        self.file.into()
    }

    /// Contents that the test needs, and those of which one is needed.
    fn needed(&self) -> (&'static [Role], &'static [Role]) {
        match self.request.kind {
            TestKind::Relaxation => (&[Role::Time, Role::Stress], &[]),
            TestKind::Creep => (&[Role::Time, Role::Strain], &[]),
            TestKind::History => (&[Role::Time, Role::Strain, Role::Stress], &[]),
            TestKind::Dynamic => (&[Role::Frequency, Role::Storage], &[Role::Loss, Role::TanDelta]),
        }
    }

    /// Lines, the one with the names, and the columns.
    fn find_columns(&self, text: &str) -> Result<(Vec<Line>, usize, Columns), RelaxationError> {
        let mut nearest: (Vec<&'static str>, Vec<String>) = (vec![], vec![]);
        for delimiter in table::DELIMITERS {
            let lines = table::split(text, delimiter);
            for (at, line) in lines.iter().enumerate().take(200) {
                // A line of numbers has no names, apart from columns by number
                if line.cells.iter().any(|c| table::is_number(c)) {
                    continue;
                }
                let (columns, missing) = self.columns_of(&line.cells)?;
                if missing.is_empty() {
                    return Ok((lines, at, columns));
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
            nearest = (self.needed().0.iter().map(|r| r.name()).collect(), vec!["no line of names".into()]);
        }
        Err(RelaxationError::Columns { file: self.file(), missing: nearest.0, found: nearest.1 })
    }

    /// The columns of a line of names, and the contents that it lacks.
    fn columns_of(&self, cells: &[String]) -> Result<(Columns, Vec<&'static str>), RelaxationError> {
        let (all, one) = self.needed();
        let mut columns = Columns::new();
        let stated = |name: &String| {
            let by_name = cells.iter().position(|c| c.eq_ignore_ascii_case(name.trim()));
            let number =
                || name.trim().strip_prefix('#')?.parse::<usize>().ok()?.checked_sub(1).filter(|k| *k < cells.len());
            by_name.or_else(number)
        };
        for role in all.iter().chain(one) {
            let found: Vec<usize> = match self.request.columns.get(role) {
                Some(name) => stated(name).into_iter().collect(),
                None => (0..cells.len()).filter(|k| role.names(&cells[*k])).collect(),
            };
            match found[..] {
                [] => {}
                [k] => drop(columns.insert(*role, k)),
                _ => {
                    let candidates = found.iter().map(|k| format!("\"{}\" (#{})", cells[*k], k + 1)).collect();
                    return Err(RelaxationError::Ambiguous { file: self.file(), role: role.name(), candidates });
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
        // One cell that names two contents is a line that another delimiter divides
        let shared = |role: &&Role| columns.iter().any(|(other, k)| other < *role && columns.get(role) == Some(k));
        missing.extend(all.iter().filter(shared).map(|r| r.name()));
        Ok((columns, missing))
    }

    /// Factor to SI of a column, with its unit and dimension.
    fn unit(
        &self,
        role: Role,
        name: &str,
        below: Option<&String>,
    ) -> Result<(f64, String, Option<Dimension>), RelaxationError> {
        let bare = |c: &String| c.trim_matches(['(', ')', '[', ']']).trim().to_string();
        let last = || name.rsplit(['_', ' ']).next().filter(|w| *w != name).map(String::from);
        let in_name = match role {
            // "Tan(delta)" has no unit
            Role::TanDelta => None,
            _ => names::unit(name).or_else(|| last().filter(|u| factor(role, u).is_some())),
        };
        let own = in_name.or_else(|| below.map(bare).filter(|u| !u.is_empty()));
        let stated = self.request.units.get(&role).cloned().or(own);
        let no_unit = || RelaxationError::NoUnit {
            file: self.file(),
            column: name.into(),
            role: role.name(),
            example: role.example(),
        };
        let dimensionless = match role {
            Role::Time | Role::Frequency => None,
            // Shares do not depend on the unit of a stress; those of a law or of storage do
            Role::Stress if self.request.law.is_none() => Some("1"),
            Role::Strain => names::strain(name).filter(|r| r.1 == StrainKind::Stretch).map(|_| "1"),
            Role::TanDelta => Some("1"),
            Role::Stress | Role::Storage | Role::Loss => None,
        };
        let unit = stated.or_else(|| dimensionless.map(String::from)).ok_or_else(no_unit)?;
        let (factor, dimension) = factor(role, &unit).ok_or_else(|| RelaxationError::Unit {
            file: self.file(),
            column: name.into(),
            unit: unit.clone(),
            role: role.name(),
            example: role.example(),
        })?;
        Ok((factor, unit, dimension))
    }

    /// The numbers of every column in SI units.
    fn numbers(
        &self,
        names: &[String],
        units: Option<&Vec<String>>,
        body: &[&Line],
        columns: &Columns,
    ) -> Result<BTreeMap<Role, Read>, RelaxationError> {
        let cells = || body.iter().flat_map(|l| columns.values().filter_map(|k| l.cells.get(*k))).map(String::as_str);
        let decimal = Decimal::of(cells()).map_err(|cell| RelaxationError::Decimal { file: self.file(), cell })?;
        let (mut read, mut wrong) = (BTreeMap::new(), vec![]);
        for (role, at) in columns {
            let (factor, unit, dimension) = self.unit(*role, &names[*at], units.and_then(|u| u.get(*at)))?;
            let mut values = vec![];
            for line in body {
                let cell = line.cells.get(*at).map_or("", String::as_str);
                match table::number(cell, decimal) {
                    Ok(x) if (factor * x).is_finite() => values.push(factor * x),
                    _ => wrong.push(format!("line {} \"{cell}\"", line.number)),
                }
            }
            read.insert(*role, Read { name: names[*at].clone(), unit, dimension, values });
        }
        if wrong.is_empty() { Ok(read) } else { Err(RelaxationError::Cells { file: self.file(), cells: wrong }) }
    }

    /// Refuses times that do not increase and frequencies that are not positive; leaves out what precedes the loading.
    fn order(
        &self,
        read: &mut BTreeMap<Role, Read>,
        lines: Vec<u64>,
        notes: &mut Vec<String>,
    ) -> Result<Vec<u64>, RelaxationError> {
        if self.request.kind == TestKind::Dynamic {
            let wrong: Vec<u64> =
                lines.iter().zip(&read[&Role::Frequency].values).filter(|(_, f)| **f <= 0.0).map(|p| *p.0).collect();
            return if wrong.is_empty() {
                Ok(lines)
            } else {
                Err(RelaxationError::Frequency { file: self.file(), lines: wrong })
            };
        }
        let times = &read[&Role::Time].values;
        let wrong: Vec<u64> = (1..times.len()).filter(|k| times[*k] <= times[*k - 1]).map(|k| lines[k]).collect();
        if !wrong.is_empty() {
            return Err(RelaxationError::Times { file: self.file(), lines: wrong });
        }
        // The instant of an ideal step has no value of its own
        let step = self.request.kind != TestKind::History && self.request.ramp == Some(0.0);
        let start = self.request.start;
        let kept: Vec<usize> =
            (0..times.len()).filter(|k| times[*k] > start || (times[*k] == start && !step)).collect();
        if kept.len() < times.len() {
            let at = if step { "up to" } else { "before" };
            notes.push(format!(
                "{} data points {at} the beginning of the loading at {start} s are left out",
                times.len() - kept.len()
            ));
        }
        for column in read.values_mut() {
            column.values = kept.iter().map(|k| column.values[*k]).collect();
        }
        read.get_mut(&Role::Time).expect("a test in time has times").values.iter_mut().for_each(|t| *t -= start);
        Ok(kept.iter().map(|k| lines[*k]).collect())
    }

    fn record(&self, x: Vec<f64>, y: Vec<f64>, unit: &str) -> Record {
        Record {
            kind: self.request.kind,
            file: self.file(),
            sha256: String::new(),
            x,
            y,
            ramp: self.request.ramp.unwrap_or(0.0),
            driven: None,
            unit: unit.into(),
            stress: self.request.stress,
            notes: vec![],
        }
    }

    fn dynamic(&self, mut read: BTreeMap<Role, Read>, lines: &[u64]) -> Result<Record, RelaxationError> {
        let mut take = |role| read.remove(&role);
        let (frequency, storage) = (take(Role::Frequency).expect("read"), take(Role::Storage).expect("read"));
        let angular = frequency.dimension == Some(Dimension::ANGULAR_VELOCITY);
        let loss = match (take(Role::Loss), take(Role::TanDelta)) {
            (Some(loss), _) => loss.values,
            (None, Some(tan)) => tan.values.iter().zip(&storage.values).map(|(t, s)| t * s).collect(),
            (None, None) => unreachable!("one of them was found"),
        };
        for (what, values) in [("storage modulus", &storage.values), ("loss modulus", &loss)] {
            let wrong: Vec<u64> = lines.iter().zip(values).filter(|(_, v)| **v <= 0.0).map(|p| *p.0).collect();
            if !wrong.is_empty() {
                let remedy = "remove these lines, which are below what the machine resolves";
                return Err(RelaxationError::Sign { file: self.file(), what, lines: wrong, remedy });
            }
        }
        let factor = if angular { 1.0 } else { std::f64::consts::TAU };
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.sort_by(|a, b| frequency.values[*a].total_cmp(&frequency.values[*b]));
        let sorted = |v: &[f64], by: f64| order.iter().map(|k| by * v[*k]).collect::<Vec<f64>>();
        let y = [sorted(&storage.values, 1.0), sorted(&loss, 1.0)].concat();
        Ok(self.record(sorted(&frequency.values, factor), y, "Pa"))
    }

    fn held(
        &self,
        mut read: BTreeMap<Role, Read>,
        lines: &[u64],
        notes: &mut Vec<String>,
    ) -> Result<Record, RelaxationError> {
        let Some(_) = self.request.ramp else { return Err(RelaxationError::NoRamp { file: self.file() }) };
        let time = read.remove(&Role::Time).expect("read");
        let creep = self.request.kind == TestKind::Creep;
        let (role, what) = if creep { (Role::Strain, "strain") } else { (Role::Stress, "stress") };
        let column = read.remove(&role).expect("read");
        let unit = unit_of(&column);
        let mut values = if creep { strains(&column) } else { column.values };
        let mean: f64 = values.iter().sum();
        if mean < 0.0 {
            notes.push(format!("the {what} is negative and was turned: compression"));
            values.iter_mut().for_each(|v| *v = -*v);
        }
        // Noise crosses zero only where hardly anything is measured: at the beginning of a ramp
        let ramp = self.request.ramp.unwrap_or(0.0);
        let wrong: Vec<u64> = lines
            .iter()
            .zip(&values)
            .zip(&time.values)
            .filter(|((_, v), t)| **v <= 0.0 && **t > ramp)
            .map(|p| *p.0.0)
            .collect();
        if !wrong.is_empty() {
            let remedy = "subtract the zero of the load cell, or remove what follows the test";
            return Err(RelaxationError::Sign { file: self.file(), what, lines: wrong, remedy });
        }
        Ok(self.record(time.values, values, if creep { "1" } else { unit }))
    }

    fn history(&self, mut read: BTreeMap<Role, Read>, lines: &[u64]) -> Result<Record, RelaxationError> {
        let time = read.remove(&Role::Time).expect("read");
        let (strain, stress) = (read.remove(&Role::Strain).expect("read"), read.remove(&Role::Stress).expect("read"));
        let e = strains(&strain);
        let is_true = names::stress(&stress.name).is_some_and(|r| r.1 == StressKind::True);
        let y = stress.values.iter().zip(&e).map(|(p, e)| if is_true { p / (1.0 + e) } else { *p }).collect();
        let unit = unit_of(&stress);
        let Some(path) = &self.request.law else {
            let mut record = self.record(time.values, y, unit);
            record.driven = Some(Driven { parts: vec![(e.clone(), vec![1.0; e.len()])], elastic: e });
            return Ok(record);
        };
        let law = elastic_law(path)?;
        let (mut a, mut b, mut elastic) = (vec![], vec![], vec![]);
        for (e, line) in e.iter().zip(lines) {
            let stretch = 1.0 + e;
            let p = nominal(&*law, stretch).map_err(|reason| RelaxationError::LawStress {
                stretch,
                line: *line,
                reason,
            })?;
            a.push(2.0 / 3.0 * p / stretch);
            b.push(-p * stretch * stretch / 3.0);
            elastic.push(p);
        }
        let by_a = e.iter().map(|e| 1.0 + e).collect();
        let by_b = e.iter().map(|e| -1.0 / (1.0 + e).powi(2)).collect();
        let mut record = self.record(time.values, y, "of the law");
        record.driven = Some(Driven { parts: vec![(a, by_a), (b, by_b)], elastic });
        Ok(record)
    }
}

/// λ − 1 of a column of strain.
fn strains(column: &Read) -> Vec<f64> {
    let kind = names::strain(&column.name).map_or(StrainKind::Engineering, |r| r.1);
    let one = |v: &f64| match kind {
        StrainKind::Stretch => v - 1.0,
        StrainKind::True => v.exp_m1(),
        StrainKind::Engineering | StrainKind::Displacement => *v,
    };
    column.values.iter().map(one).collect()
}

/// SI unit of a column of stress.
fn unit_of(column: &Read) -> &'static str {
    match column.dimension {
        Some(Dimension::PRESSURE) => "Pa",
        Some(Dimension::FORCE) => "N",
        _ => "1",
    }
}

/// Factor to SI and dimension of a unit for a content.
fn factor(role: Role, unit: &str) -> Option<(f64, Option<Dimension>)> {
    let of = |d: Dimension| names::factor(unit, d).map(|f| (f, Some(d)));
    let none = || names::strain_factor(unit).map(|f| (f, Some(Dimension::NONE)));
    match role {
        Role::Time => of(Dimension::TIME),
        Role::Frequency => of(Dimension::FREQUENCY).or_else(|| of(Dimension::ANGULAR_VELOCITY)),
        Role::Storage | Role::Loss => of(Dimension::PRESSURE),
        Role::Stress => of(Dimension::PRESSURE).or_else(|| of(Dimension::FORCE)).or_else(none),
        Role::Strain | Role::TanDelta => none(),
    }
}

/// The isochoric part of the law of a file; its volumetric constants do not matter and may be absent.
fn elastic_law(path: &Path) -> Result<Box<dyn Law>, RelaxationError> {
    let mut table = read_law_table(path)?;
    let law = law_from_table(&table).or_else(|first| {
        let has = |key: &str| table.contains_key(key);
        if !has("nu") && !has("kappa") {
            table.insert("nu".into(), 0.49.into());
        }
        if !table.contains_key("volumetric") {
            table.insert("volumetric".into(), "quadratic".into());
        }
        law_from_table(&table).map_err(|_| first)
    })?;
    let info = law.info();
    let part = law.split().filter(|_| info.isochoric).ok_or(RelaxationError::NotIsochoric { law: info.name })?;
    Ok(part.0)
}

/// Uniaxial nominal stress at J = 1, P = (λ P₁₁ − λ^{−½} P₂₂)/λ of the isochoric part.
fn nominal(law: &dyn Law, stretch: f64) -> Result<f64, String> {
    if stretch.is_nan() || stretch <= 0.0 {
        return Err("a stretch is positive".into());
    }
    let lateral = stretch.powf(-0.5);
    let f = Mat3::from_diagonal(&[stretch, lateral, lateral].into());
    let p = law.eval(&f, Want::Residual).map_err(|e| e.to_string())?.p;
    Ok(p[(0, 0)] - lateral * p[(1, 1)] / stretch)
}
