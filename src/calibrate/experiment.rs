//! A tensile table as typed samples. Nothing is changed silently: the audit log says what was done to which line.

use super::columns::{self, Columns};
use super::table::{self, Line};
use super::{Audit, AuditEntry, AuditKind, Card, ColumnChoice, FitError, Mode, StrainKind};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// One row of a test.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Sample {
    pub mode: Mode,
    /// λ [–] in the loaded direction
    pub stretch: f64,
    /// Nominal stress P [Pa]: force over undeformed area
    pub stress: f64,
    /// Line of the file, counted from 1
    pub line: u64,
    /// Which of several files, counted from 0
    pub specimen: usize,
}

impl Sample {
    /// False at λ = 1 with P = 0: every law goes through this point, and the test was zeroed there.
    pub fn is_informative(&self) -> bool {
        self.stretch != 1.0 || self.stress != 0.0
    }
}

/// A test as read.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// File name without its folder; of several specimens all names
    pub file: String,
    /// File name of each specimen
    pub specimens: Vec<String>,
    /// SHA-256 of the bytes of the file, hexadecimal
    pub sha256: String,
    /// In the order of the file
    pub samples: Vec<Sample>,
    pub stress_unit: String,
    /// Lines above the column names: first cell and the rest
    pub header: Vec<(String, String)>,
    pub card: Option<Card>,
    pub audit: Audit,
}

impl Experiment {
    /// Reads a table. `card`: else the one beside the table. `choice` overrides the card. `mode`: of every row, where
    /// no column gives it.
    pub fn read(path: &Path, card: Option<&Path>, choice: &ColumnChoice, mode: Option<Mode>) -> Result<Self, FitError> {
        let bytes = std::fs::read(path).map_err(|source| FitError::Read { path: path.into(), source })?;
        let card = Card::find(card, path)?;
        let file = path.file_name().map_or_else(|| PathBuf::from(path), PathBuf::from).display().to_string();
        Self::parse(&file, &bytes, card, choice, mode)
    }

    /// Reads the bytes of a table.
    pub fn parse(
        file: &str,
        bytes: &[u8],
        card: Option<Card>,
        choice: &ColumnChoice,
        mode: Option<Mode>,
    ) -> Result<Self, FitError> {
        let mut audit = Audit::default();
        let choice = card.as_ref().map_or_else(|| choice.clone(), |c| choice.or(&c.columns));
        let (text, replaced) = table::decode(bytes);
        if replaced {
            audit.add(AuditKind::Intake, "the file is not UTF-8; unreadable characters were replaced", vec![]);
        }
        let (delimiter, lines, at) = find_header(file, &text, &choice)?;
        let columns = columns::resolve(file, &lines[at], &choice)?;
        let header: Vec<_> = lines[..at].iter().map(|l| pair(&l.cells)).collect();
        let body = &lines[at + 1..];
        let cells = body.iter().flat_map(|l| [columns.strain, columns.stress].map(|i| l.cells.get(i)));
        let decimal_comma = table::has_decimal_comma(cells.flatten().map(String::as_str));
        log_intake(&mut audit, &lines[at], delimiter, decimal_comma, &columns);
        let mode = whole_file_mode(&columns, mode, card.as_ref(), &header, &mut audit);
        let samples = read_rows(file, body, &columns, decimal_comma, mode, &mut audit)?;
        log_rows(&mut audit, &samples);
        log_doubts(&mut audit, &samples, &columns, card.as_ref(), &header);
        let sha256 = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
        Ok(Self {
            file: file.into(),
            specimens: vec![file.into()],
            sha256,
            samples,
            stress_unit: columns.stress_unit,
            header,
            card,
            audit,
        })
    }

    /// A test that was read elsewhere; stresses are in Pa.
    pub fn of_samples(file: &str, sha256: &str, samples: Vec<Sample>) -> Self {
        Self {
            file: file.into(),
            specimens: vec![file.into()],
            sha256: sha256.into(),
            samples,
            stress_unit: "Pa".into(),
            header: vec![],
            card: None,
            audit: Audit::default(),
        }
    }

    /// One table of several specimens of the same test: every row counts, as many as a specimen has.
    pub fn pool(parts: Vec<Self>) -> Result<Self, FitError> {
        for (k, part) in parts.iter().enumerate() {
            if let Some(first) = parts[..k].iter().find(|p| p.sha256 == part.sha256) {
                return Err(FitError::SameFile { first: first.file.clone(), second: part.file.clone() });
            }
        }
        let several = parts.len() > 1;
        let mut parts = parts.into_iter();
        let mut all = parts.next().expect("a request has a table");
        if several {
            all.card = None;
            all.audit.0.iter_mut().for_each(|e| e.message = format!("{}: {}", all.specimens[0], e.message));
        }
        for (k, part) in parts.enumerate() {
            let entry = |e: AuditEntry| AuditEntry { message: format!("{}: {}", part.file, e.message), ..e };
            all.audit.0.extend(part.audit.0.into_iter().map(entry));
            all.samples.extend(part.samples.into_iter().map(|s| Sample { specimen: k + 1, ..s }));
            all.file += &format!(", {}", part.file);
            all.sha256 += &format!(", {}", part.sha256);
            all.specimens.push(part.file);
        }
        Ok(all)
    }

    /// Modes that occur, in the order of [`Mode::ALL`]
    pub fn modes(&self) -> Vec<Mode> {
        Mode::ALL.into_iter().filter(|m| self.samples.iter().any(|s| s.mode == *m)).collect()
    }
}

fn pair(cells: &[String]) -> (String, String) {
    let rest: Vec<_> = cells.iter().skip(1).filter(|c| !c.is_empty()).map(String::as_str).collect();
    (cells.first().cloned().unwrap_or_default(), rest.join(" "))
}

/// The delimiter and the line under which stretch and stress are both named.
fn find_header(file: &str, text: &str, choice: &ColumnChoice) -> Result<(char, Vec<Line>, usize), FitError> {
    let mut found = Vec::new();
    for delimiter in table::DELIMITERS {
        let lines = table::split(text, delimiter);
        if let Some(at) = lines.iter().position(|l| columns::is_header(l, choice)) {
            return Ok((delimiter, lines, at));
        }
        // For the message: the line above the first one with two numbers has the names.
        let numbers = |l: &Line| l.cells.iter().filter(|c| table::number(c, true).is_ok()).count();
        let first = lines.iter().position(|l| numbers(l) >= 2);
        let names = first.and_then(|i| i.checked_sub(1)).or((!lines.is_empty()).then_some(0));
        let names = names.map(|i| columns::quoted(&lines[i].cells)).unwrap_or_default();
        if names.len() > found.len() {
            found = names;
        }
    }
    if found.is_empty() {
        found.push("none, the file is empty".into());
    }
    let strain = choice.strain.as_ref().map_or("stretch or engineering strain".into(), |n| format!("name \"{n}\""));
    let stress = choice.stress.as_ref().map_or("nominal stress".into(), |n| format!("name \"{n}\""));
    Err(FitError::Columns { file: file.into(), missing: format!("{strain} beside one of {stress}"), found })
}

fn log_intake(audit: &mut Audit, header: &Line, delimiter: char, decimal_comma: bool, c: &Columns) {
    let delimiter = if delimiter == '\t' { "tab".into() } else { format!("\"{delimiter}\"") };
    let mark = if decimal_comma { "comma" } else { "point" };
    let kind = if c.strain_kind == StrainKind::Stretch { "stretch" } else { "engineering strain" };
    let message = format!(
        "delimiter {delimiter}, decimal {mark}; \"{}\" is {kind} × {}, \"{}\" is nominal stress in {}",
        c.strain_name, c.strain_factor, c.stress_name, c.stress_unit
    );
    audit.add(AuditKind::Intake, message, vec![header.number]);
    for note in &c.notes {
        audit.add(AuditKind::Intake, note.clone(), vec![]);
    }
}

/// The mode of a table without a mode column: as asked, of the card, or of a standard that the header names.
fn whole_file_mode(
    columns: &Columns,
    asked: Option<Mode>,
    card: Option<&Card>,
    header: &[(String, String)],
    audit: &mut Audit,
) -> Option<Mode> {
    if columns.mode.is_some() {
        return None;
    }
    let (mode, why) = match (asked, card.and_then(|c| c.mode)) {
        (Some(mode), _) => (mode, "as asked".to_string()),
        (None, Some(mode)) => (mode, "by the card".to_string()),
        (None, None) => {
            let is_tensile = |text: &str| ["astm d412", "iso 37"].iter().any(|s| text.to_lowercase().contains(s));
            let (key, value) = header.iter().find(|(_, value)| is_tensile(value))?;
            (Mode::Uniaxial, format!("because the header says \"{key}: {value}\""))
        }
    };
    audit.add(AuditKind::Intake, format!("every row is {mode}, {why}"), vec![]);
    Some(mode)
}

fn read_rows(
    file: &str,
    body: &[Line],
    columns: &Columns,
    decimal_comma: bool,
    whole_file: Option<Mode>,
    audit: &mut Audit,
) -> Result<Vec<Sample>, FitError> {
    let mut samples = Vec::new();
    let mut left_out = Vec::new();
    for line in body.iter().filter(|l| l.cells.iter().any(|c| !c.is_empty())) {
        let cell = |i: usize| line.cells.get(i).map_or("", String::as_str);
        let read = |i: usize, what: &str| {
            table::number(cell(i), decimal_comma)
                .map_err(|why| format!("line {}: column \"{what}\" {why}", line.number))
        };
        let values = read(columns.strain, &columns.strain_name)
            .and_then(|e| read(columns.stress, &columns.stress_name).map(|p| (e, p)))
            .map(|(e, p)| {
                let e = e * columns.strain_factor;
                (if columns.strain_kind == StrainKind::Stretch { e } else { 1.0 + e }, p * columns.stress_factor)
            })
            .and_then(|(stretch, p)| {
                let reason = || format!("line {}: stretch {stretch} is not positive", line.number);
                if stretch > 0.0 { Ok((stretch, p)) } else { Err(reason()) }
            });
        let (stretch, stress) = match values {
            Ok(values) => values,
            Err(reason) => {
                left_out.push((line.number, reason));
                continue;
            }
        };
        let mode = match columns.mode {
            Some(i) => Mode::from_word(cell(i))
                .ok_or_else(|| FitError::ModeWord { line: Some(line.number), word: cell(i).into() })?,
            None => whole_file.ok_or_else(|| FitError::NoMode { file: file.into() })?,
        };
        samples.push(Sample { mode, stretch, stress, line: line.number, specimen: 0 });
    }
    if samples.is_empty() {
        let reason = left_out.first().map_or("there are no rows below the column names".into(), |(_, r)| r.clone());
        return Err(FitError::NoRows { file: file.into(), reason });
    }
    for (number, reason) in left_out {
        audit.add(AuditKind::LeftOut, reason, vec![number]);
    }
    Ok(samples)
}

/// Unusual rows: they take part as they are.
fn log_rows(audit: &mut Audit, samples: &[Sample]) {
    let mut seen: HashMap<(Mode, u64), f64> = HashMap::new();
    let mut last: HashMap<Mode, f64> = HashMap::new();
    let (mut twice, mut repeats, mut back, mut against, mut offset) = (vec![], vec![], vec![], vec![], vec![]);
    for s in samples {
        match seen.insert((s.mode, s.stretch.to_bits()), s.stress) {
            Some(p) if p == s.stress => twice.push(s.line),
            Some(_) => repeats.push(s.line),
            None => {}
        }
        if last.insert(s.mode, s.stretch).is_some_and(|before| s.stretch < before) {
            back.push(s.line);
        }
        if s.stretch == 1.0 && s.stress != 0.0 {
            offset.push(s.line);
        } else if s.stress * (s.stretch - 1.0) < 0.0 {
            against.push(s.line);
        }
    }
    let kept = AuditKind::Kept;
    audit.add_rows(kept, "row occurs before with the same stretch and stress; it counts each time", twice);
    audit.add_rows(kept, "stretch occurs before with another stress; both count", repeats);
    audit.add_rows(
        kept,
        "stretch is smaller than in the row before (order of the file or unloading); the order does not enter the fit, \
         unloading would",
        back,
    );
    audit.add_rows(kept, "stress has the sign against its stretch (negative under tension)", against);
    audit.add_rows(kept, "stress is not zero at stretch 1; the offset was not taken off", offset);
}

fn log_doubts(
    audit: &mut Audit,
    samples: &[Sample],
    columns: &Columns,
    card: Option<&Card>,
    header: &[(String, String)],
) {
    let measured = card.and_then(|c| c.strain_measurement.as_deref()).unwrap_or_default().to_lowercase();
    let said = header.iter().find(|(key, value)| {
        let (key, value) = (key.to_lowercase(), value.to_lowercase());
        value.contains("crosshead") || key.contains("crosshead") || (key == "strain measurement" && value == "global")
    });
    if measured.contains("crosshead") || said.is_some() {
        let source = said.map_or("the card".into(), |(k, v)| format!("the header, \"{k}: {v}\""));
        audit.add(
            AuditKind::Doubt,
            format!(
                "strain comes from crosshead travel (by {source}): it counts the stretch of the wide ends as if it were \
                 the gauge length's, so the fitted stiffness is too low; only a fit of the whole specimen corrects it"
            ),
            vec![],
        );
    }
    let largest = samples.iter().map(|s| s.stretch).fold(0.0, f64::max);
    if columns.strain_kind == StrainKind::Engineering && columns.strain_factor == 1.0 && largest > 31.0 {
        let message = format!(
            "column \"{}\" was read without a unit and reaches {:.4}; if it is in percent pass --strain-unit %",
            columns.strain_name,
            largest - 1.0
        );
        audit.add(AuditKind::Doubt, message, vec![]);
    }
    let unread = samples.len() + audit.of(AuditKind::LeftOut).count();
    if samples.len() * 10 < unread * 9 {
        let message = format!("{} of {unread} rows could not be read", unread - samples.len());
        audit.add(AuditKind::Doubt, message, vec![]);
    }
}
