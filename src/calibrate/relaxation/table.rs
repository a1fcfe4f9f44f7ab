//! From a table (CSV) of a test in time or frequency to a [`Record`], and the request for a fit.

use super::error::RelaxationError;
use super::response::{Driven, Record, TestKind};
use crate::calibrate::intake::names::{self, Condition, StrainKind, StressKind};
use crate::calibrate::intake::roles::{self, ConditionColumn, ReadColumn, ReadTable, Role, Wanted};
use crate::calibrate::read_law_table;
use crate::calibrate::same_data;
use crate::material::{Law, Want, law_from_table};
use crate::math::tensor::Mat3;
use crate::math::units::Dimension;
use crate::wording::joined;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How the terms of the series are determined.
#[derive(Clone, PartialEq, Debug)]
pub enum TermChoice {
    /// Times by least squares, their number by the information criterion
    Evidence,
    /// A given number of times, found by least squares
    Number(usize),
    /// Given times \[s\]
    Times(Vec<f64>),
    /// A given number of times in each decade of the data
    PerDecade(usize),
}

/// Delay of the first data point after the loading, in units of the first time step of the table, from which on the loading does not begin at time
/// zero. Times that are spaced evenly in the logarithm begin this late only with more than a hundred per decade \[–\]
const LATE: f64 = 50.0;

/// Ratio up to which frequencies of a sweep count as equal \[–\]
const SAME_FREQUENCY: f64 = 1.05;
/// Difference up to which temperatures belong to one test, in the unit of the table
const DEGREES: f64 = 5.0;
/// Ratio up to which amplitudes belong to one test \[–\]
const TIMES: f64 = 1.5;

/// Request for a fit of a Prony series.
#[derive(Clone, PartialEq, Debug)]
pub struct RelaxationRequest {
    pub data: PathBuf,
    /// Tables of further specimens of the same test
    pub more: Vec<PathBuf>,
    pub kind: TestKind,
    /// Names of columns, or numbers such as `#3`
    pub columns: BTreeMap<Role, String>,
    pub units: BTreeMap<Role, String>,
    /// Duration of the loading \[s\] in relaxation and creep
    pub ramp: Option<f64>,
    /// Time in the table at which the loading begins \[s\]; zero by default, which is refused if the data begin long after the loading
    pub start: Option<f64>,
    /// Held stress of a creep test \[Pa\]
    pub stress: Option<f64>,
    /// File of the elastic law of a uniaxial history at finite strain
    pub law: Option<PathBuf>,
    pub terms: TermChoice,
}

impl RelaxationRequest {
    /// A request without statements about the table.
    pub fn new(data: impl Into<PathBuf>, kind: TestKind) -> Self {
        Self {
            data: data.into(),
            more: vec![],
            kind,
            columns: BTreeMap::new(),
            units: BTreeMap::new(),
            ramp: None,
            start: None,
            stress: None,
            law: None,
            terms: TermChoice::Evidence,
        }
    }

    /// Refuses flags that contradict each other or have no meaning.
    fn check(&self) -> Result<(), RelaxationError> {
        let bad = |flag, value: f64, remedy| Err(RelaxationError::Flag { flag, value: value.to_string(), remedy });
        let terms = if matches!(self.terms, TermChoice::PerDecade(_)) { "--per-decade" } else { "--terms" };
        let contradiction =
            |flag, remedy| Err(RelaxationError::Contradiction { flag, experiment: self.kind.name(), remedy });
        let held = matches!(self.kind, TestKind::Relaxation | TestKind::Creep);
        let is_time = |t: &f64| *t > 0.0 && t.is_finite();
        if self.start.is_some() && self.kind == TestKind::Dynamic {
            return contradiction("--start", "a sweep of frequencies has no beginning; leave it out");
        }
        match (&self.terms, self.ramp, self.stress) {
            (TermChoice::Number(0) | TermChoice::PerDecade(0), ..) => {
                return bad(terms, 0.0, "a series has at least one term");
            }
            (TermChoice::Number(n) | TermChoice::PerDecade(n), ..) if *n > 12 => {
                return bad(terms, *n as f64, "no data determine more than 12; take fewer");
            }
            (TermChoice::Times(times), ..) if times.is_empty() || !times.iter().all(is_time) => {
                let wrong: Vec<String> = times.iter().filter(|t| !is_time(t)).map(|t| format!("{t} s")).collect();
                let remedy = "give positive times such as \"0.1 s,1 s,10 s\"";
                return Err(RelaxationError::Flag { flag: "--times", value: joined(&wrong), remedy });
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

/// Reads the tables of a request.
pub fn read(request: &RelaxationRequest) -> Result<Record, RelaxationError> {
    request.check()?;
    let mut first = read_one(request, &request.data)?;
    let named = |r: &mut Record| {
        let file = &r.file;
        r.notes.iter_mut().for_each(|n| *n = format!("{file}: {n}"));
    };
    if !request.more.is_empty() {
        named(&mut first);
    }
    for path in &request.more {
        let mut next = read_one(request, path)?;
        if next.unit != first.unit {
            let units = [first.unit.clone(), next.unit];
            return Err(RelaxationError::Units { first: first.file, second: next.file, units });
        }
        named(&mut next);
        first.notes.append(&mut next.notes);
        first.more.push(next);
    }
    let numbers: Vec<Vec<f64>> = first.specimens().map(|r| [&r.x[..], &r.y].concat()).collect();
    if let Some(pair) = same_data::first_pair(&numbers) {
        let files: Vec<&String> = first.specimens().map(|r| &r.file).collect();
        let [first, second] = pair.map(|k| files[k].clone());
        return Err(RelaxationError::SameData { first, second });
    }
    Ok(first)
}

fn read_one(request: &RelaxationRequest, path: &Path) -> Result<Record, RelaxationError> {
    let (all, one) = needed(request.kind);
    // Shares do not depend on the unit of a stress; with a law they do
    let unitless: &[Role] = if request.law.is_none() { &[Role::Stress] } else { &[] };
    let wanted = Wanted { all, one, columns: &request.columns, units: &request.units, unitless };
    let ReadTable { file, sha256, mut columns, lines, mut notes, conditions } = roles::read(path, &wanted)?;
    let reader = Reader { file: &file, request };
    if request.kind == TestKind::Dynamic {
        reader.check_conditions(&columns[&Role::Frequency].values, &conditions)?;
    }
    let numbers = reader.order(&mut columns, lines, &mut notes)?;
    let record = match request.kind {
        TestKind::Dynamic => reader.dynamic(columns, &numbers)?,
        TestKind::History => reader.history(columns, &numbers, &mut notes)?,
        TestKind::Relaxation | TestKind::Creep => reader.held(columns, &numbers, &mut notes)?,
    };
    if record.y.iter().all(|y| *y == 0.0) {
        return Err(RelaxationError::Zero { file });
    }
    Ok(Record { sha256, notes, ..record })
}

/// Contents that a test needs, and contents of which it needs one.
fn needed(kind: TestKind) -> (&'static [Role], &'static [Role]) {
    match kind {
        TestKind::Relaxation => (&[Role::Time, Role::Stress], &[]),
        TestKind::Creep => (&[Role::Time, Role::Strain], &[]),
        TestKind::History => (&[Role::Time, Role::Strain, Role::Stress], &[]),
        TestKind::Dynamic => (&[Role::Frequency, Role::Storage], &[Role::Loss, Role::TanDelta]),
    }
}

struct Reader<'a> {
    file: &'a str,
    request: &'a RelaxationRequest,
}

impl Reader<'_> {
    fn file(&self) -> String {
        self.file.into()
    }

    /// Refuses a table in which one frequency was measured at clearly different temperatures or amplitudes.
    fn check_conditions(&self, frequency: &[f64], conditions: &[ConditionColumn]) -> Result<(), RelaxationError> {
        let mut order: Vec<usize> = (0..frequency.len()).collect();
        order.sort_by(|a, b| frequency[*a].total_cmp(&frequency[*b]));
        let near = |w: &&[usize]| frequency[w[1]] <= SAME_FREQUENCY * frequency[w[0]];
        for column in conditions {
            let differs = |w: &[usize]| {
                let (first, second) = (column.values[w[0]]?, column.values[w[1]]?);
                let is_other = match column.condition {
                    Condition::Temperature => (first - second).abs() > DEGREES,
                    Condition::Amplitude => first.abs().max(second.abs()) > TIMES * first.abs().min(second.abs()),
                };
                is_other.then_some((first, second))
            };
            if let Some((first, second)) = order.windows(2).filter(near).find_map(differs) {
                return Err(RelaxationError::Conditions {
                    file: self.file(),
                    column: column.name.clone(),
                    first,
                    second,
                });
            }
        }
        Ok(())
    }

    /// Refuses times that do not increase and frequencies that are not positive; leaves out rows before the loading.
    fn order(
        &self,
        read: &mut BTreeMap<Role, ReadColumn>,
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
        // An ideal step has no value at its own instant
        let step = self.request.kind != TestKind::History && self.request.ramp == Some(0.0);
        let start = self.request.start.unwrap_or(0.0);
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
            more: vec![],
        }
    }

    fn dynamic(&self, mut read: BTreeMap<Role, ReadColumn>, lines: &[u64]) -> Result<Record, RelaxationError> {
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
        mut read: BTreeMap<Role, ReadColumn>,
        lines: &[u64],
        notes: &mut Vec<String>,
    ) -> Result<Record, RelaxationError> {
        let Some(_) = self.request.ramp else { return Err(RelaxationError::NoRamp { file: self.file() }) };
        let time = read.remove(&Role::Time).expect("read");
        self.check_begin(&time.values)?;
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
        // Noise crosses zero only where hardly anything is measured, at the beginning of a ramp
        let ramp = self.request.ramp.unwrap_or(0.0);
        let wrong: Vec<u64> = lines
            .iter()
            .zip(&values)
            .zip(&time.values)
            .filter(|((_, v), t)| **v <= 0.0 && **t > ramp)
            .map(|p| *p.0.0)
            .collect();
        if !wrong.is_empty() {
            let remedy = "subtract the zero of the load cell, remove what follows the test, or pass --start if the loading begins later";
            return Err(RelaxationError::Sign { file: self.file(), what, lines: wrong, remedy });
        }
        Ok(self.record(time.values, values, if creep { "1" } else { unit }))
    }

    /// Refuses data that begin long after a loading whose beginning is not stated: their time is that of a data logger.
    fn check_begin(&self, times: &[f64]) -> Result<(), RelaxationError> {
        let (Some(ramp), None, [first, second, ..]) = (self.request.ramp, self.request.start, times) else {
            return Ok(());
        };
        let (first, step) = (*first, second - first);
        let late = first > 2.0 * ramp && first - ramp > LATE * step;
        if late { Err(RelaxationError::LateData { file: self.file(), first, step, ramp }) } else { Ok(()) }
    }

    fn history(
        &self,
        mut read: BTreeMap<Role, ReadColumn>,
        lines: &[u64],
        notes: &mut Vec<String>,
    ) -> Result<Record, RelaxationError> {
        let time = read.remove(&Role::Time).expect("read");
        let mut pair = [Role::Strain, Role::Stress].map(|role| read.remove(&role).expect("read"));
        turn_compression(&mut pair, notes);
        let [strain, stress] = pair;
        let e = strains(&strain);
        let is_true = names::stress(&stress.name).is_some_and(|r| r.1 == StressKind::True);
        let y = stress.values.iter().zip(&e).map(|(p, e)| if is_true { p / (1.0 + e) } else { *p }).collect();
        let unit = unit_of(&stress);
        let Some(path) = &self.request.law else {
            let mut record = self.record(time.values, y, unit);
            record.driven = Some(Driven { parts: vec![(e.clone(), vec![1.0; e.len()])], elastic: e });
            return Ok(record);
        };
        if stress.dimension != Some(Dimension::PRESSURE) {
            return Err(RelaxationError::NoStress { file: self.file(), column: stress.name, unit: stress.unit });
        }
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
        if elastic.iter().zip(&y).map(|(law, measured)| law * measured).sum::<f64>() < 0.0 {
            return Err(RelaxationError::Against { file: self.file(), strain: strain.name, stress: stress.name });
        }
        let by_a = e.iter().map(|e| 1.0 + e).collect();
        let by_b = e.iter().map(|e| -1.0 / (1.0 + e).powi(2)).collect();
        let mut record = self.record(time.values, y, "of the law");
        record.driven = Some(Driven { parts: vec![(a, by_a), (b, by_b)], elastic });
        Ok(record)
    }
}

/// Changes the sign of strain and stress of a test that counts compression as positive by the name of one of them.
fn turn_compression(pair: &mut [ReadColumn; 2], notes: &mut Vec<String>) {
    // A history may be at zero for most of its rows
    let can_turn = |column: &ReadColumn| !column.is_stretch() && column.values.iter().sum::<f64>() > 0.0;
    if pair.iter().any(|column| names::is_compressive(&column.name) && can_turn(column)) {
        pair.iter_mut().filter(|column| can_turn(column)).for_each(|column| column.turn(notes));
    }
}

/// λ − 1 of a column of strain.
fn strains(column: &ReadColumn) -> Vec<f64> {
    let kind = names::strain(&column.name).map_or(StrainKind::Engineering, |r| r.1);
    let one = |v: &f64| match kind {
        StrainKind::Stretch => v - 1.0,
        StrainKind::True => v.exp_m1(),
        StrainKind::Engineering | StrainKind::Displacement => *v,
    };
    column.values.iter().map(one).collect()
}

/// SI unit of a column of stress.
fn unit_of(column: &ReadColumn) -> &'static str {
    match column.dimension {
        Some(Dimension::PRESSURE) => "Pa",
        Some(Dimension::FORCE) => "N",
        _ => "1",
    }
}

/// The isochoric part of the law in a file; its volumetric constants have no effect and may be absent.
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
