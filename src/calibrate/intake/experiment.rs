//! A table as typed samples. Nothing is changed silently: the audit log lists every change with its lines.

use super::columns::{self, Columns, Lateral};
use super::names::{StrainKind, StressKind};
use super::parts::{self, Whole};
use super::samples::{self, Conversion};
use super::table::{self, Decimal, Line};
use super::{
    audit::{Audit, AuditEntry, AuditKind},
    card::Card,
    columns::ColumnChoice,
    dimensions::Dimensions,
    meaning,
    piece::Piece,
    unusual,
};
use crate::calibrate::same_data;
use crate::calibrate::{Alternative, FitError, Mode, RawRow, Sample, SharedError, Treatment};
use crate::storage::columns::{Rows, TableError};
use crate::storage::{self, DATA_LIMIT};
use crate::wording::few;
use std::path::{Path, PathBuf};

/// A test as read.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// File name without its folder; of several specimens all names, joined
    pub file: String,
    /// File name of each specimen, with the name of the specimen if one file holds several
    pub specimens: Vec<String>,
    /// SHA-256 of the bytes of the file, hexadecimal
    pub sha256: String,
    /// Samples in the order of the file, unless they were sorted by time
    pub samples: Vec<Sample>,
    /// The samples of a prepared test before neighbours were replaced by their means, without their specimens
    pub single: Vec<Sample>,
    /// Every row that holds samples, in the order of the file
    pub raw: Vec<RawRow>,
    /// Kinds of strain and stress in each direction
    pub kinds: Vec<(StrainKind, StressKind)>,
    /// Unit of the stress column; a unit of force for a force
    pub stress_unit: String,
    /// Test piece of each specimen; the first one is used for specimens without their own
    pub pieces: Vec<Piece>,
    /// Lines above the column names: first cell and the rest
    pub header: Vec<(String, String)>,
    pub card: Option<Card>,
    /// Columns along and across the load; with several tables, if they are the same in all
    pub lateral: Lateral,
    /// Samples under other treatments
    pub alternatives: Vec<Alternative>,
    pub audit: Audit,
}

impl Experiment {
    /// Reads a table. `card`: by default the one next to the table. `choice` overrides the card. `mode`: the mode of all rows if no column gives it.
    pub fn read(path: &Path, card: Option<&Path>, choice: &ColumnChoice, mode: Option<Mode>) -> Result<Self, FitError> {
        let bytes = storage::read(path, DATA_LIMIT).map_err(|source| FitError::Read { path: path.into(), source })?;
        let other = if card.is_none() { Card::next_to(path)?.filter(|card| !card.names(path)) } else { None };
        let card = Card::find(card, path)?;
        let file = path.file_name().map_or_else(|| PathBuf::from(path), PathBuf::from).display().to_string();
        let mut read = Self::parse(&file, &bytes, card, choice, mode)?;
        if let Some(Card { file: named, .. }) = other {
            let is_meant = named.to_lowercase() == file.to_lowercase();
            let kind = if is_meant { AuditKind::Doubt } else { AuditKind::Intake };
            read.audit.add(kind, format!("card.toml next to the table is of \"{named}\", and was not used"), vec![]);
        }
        Ok(read)
    }

    /// Reads a table from the bytes of a file.
    pub fn parse(
        file: &str,
        bytes: &[u8],
        card: Option<Card>,
        choice: &ColumnChoice,
        mode: Option<Mode>,
    ) -> Result<Self, FitError> {
        let mut audit = Audit::default();
        let choice = Card::complete(card.as_ref(), choice)?;
        let (text, encoding) = table::decode(bytes).map_err(|what| TableError::NotText { file: file.into(), what })?;
        if let Some(encoding) = encoding {
            audit.add(AuditKind::Intake, format!("the file is not UTF-8; it was read as {encoding}"), vec![]);
        }
        let (delimiter, lines, at) = find_header(file, &text, &choice)?;
        let mut header: Vec<_> = lines[..at].iter().map(|l| parts::pair(&l.cells)).collect();
        header.extend(parts::of_results(&lines[..at]));
        let (names, body) = names_and_body(&lines, at, &choice, &mut audit);
        let rows = Rows::under(file, delimiter, &lines, at, lines.len() - body.len())?;
        let asked = mode.or(card.as_ref().and_then(|c| c.mode));
        let mut columns = columns::resolve(file, &names, &choice, asked)?;
        let decimal = rows.decimal(&columns.numeric().collect::<Vec<_>>(), choice.decimal)?;
        meaning::turn_compression(&mut columns, body, decimal, &choice);
        log_intake(&mut audit, &names, delimiter, decimal, &columns);
        let mode = whole_file_mode(&columns, mode, card.as_ref(), &header, &mut audit);
        let (of_header, unclear) = Dimensions::of_header(&header);
        for (key, asked, own) in choice.dimensions.contradictions(of_header) {
            let message = format!("{key} = {asked} as requested or by the card, the header says {own}");
            audit.add(AuditKind::Intake, message, vec![]);
        }
        let dimensions = choice.dimensions.or(of_header);
        let instrument = choice.strain_measurement.as_deref().filter(|i| !i.to_lowercase().contains("crosshead"));
        if let (Some(instrument), Some(_)) = (instrument, dimensions.compliance) {
            return Err(FitError::Compliance { file: file.into(), instrument: instrument.into() });
        }
        let conversion =
            Conversion::new(file, &columns, dimensions, &mut audit).map_err(|e| e.with_unclear(file, &unclear))?;
        let whole = Whole { file, names: &lines[at], body, columns: &columns, decimal, dimensions: of_header };
        let parts = whole.divide(&mut audit)?;
        let mut read = samples::Table::default();
        for (k, part) in parts.iter().enumerate() {
            read.read(file, &part.lines, k, &conversion, decimal, mode)?;
        }
        read.finish(file, &mut audit)?;
        let samples = read.samples;
        let at_rest: Vec<u64> = samples.iter().filter(|s| !s.is_informative()).map(|s| s.line).collect();
        audit.add_rows(
            AuditKind::Intake,
            "data points without strain and stress, which say nothing about a law",
            at_rest,
        );
        let table = meaning::Read { file, names: &names.cells, body, decimal, columns: &columns, samples: &samples };
        table.check(&choice, &mut audit)?;
        table.check_compression(&choice, &header, &mut audit)?;
        unusual::data_points(&mut audit, &samples);
        unusual::doubts(&mut audit, &samples, &columns, choice.strain_measurement.as_deref(), &header);
        let accuracy = card.as_ref().map(|c| c.accuracy.clone()).unwrap_or_default();
        let label = |p: &parts::SpecimenLines| p.label.as_ref().map_or_else(|| file.into(), |l| format!("{file}, {l}"));
        Ok(Self {
            file: file.into(),
            specimens: parts.iter().map(label).collect(),
            sha256: storage::sha256(bytes),
            samples,
            single: vec![],
            raw: read.raw,
            kinds: columns.axes.iter().map(|(e, p)| (e.kind, p.kind)).collect(),
            stress_unit: columns.axes[0].1.unit.clone(),
            pieces: vec![Piece { dimensions, accuracy, corrections: vec![] }; parts.len()],
            header,
            card,
            lateral: Lateral::of(&names.cells, &columns),
            alternatives: vec![],
            audit,
        })
    }

    /// Builds a test from samples that were read elsewhere; stresses are in Pa.
    pub fn of_samples(file: &str, sha256: &str, samples: Vec<Sample>) -> Self {
        Self {
            file: file.into(),
            specimens: vec![file.into()],
            sha256: sha256.into(),
            samples,
            single: vec![],
            raw: vec![],
            kinds: vec![],
            stress_unit: "Pa".into(),
            pieces: vec![Piece::default()],
            header: vec![],
            card: None,
            lateral: Lateral::default(),
            alternatives: vec![],
            audit: Audit::default(),
        }
    }

    /// Pools the tables of several specimens of the same test: every row has the same weight, however many rows a specimen has.
    pub fn pool(parts: Vec<Self>) -> Result<Self, FitError> {
        let several = parts.len() > 1;
        let alternatives = pool_alternatives(&parts);
        let unequal = unequal_corrections(&parts);
        let mut parts = parts.into_iter();
        let mut all = parts.next().expect("a request has a table");
        if several {
            all.card = None;
            all.audit.0.iter_mut().for_each(|e| e.message = format!("{}: {}", all.file, e.message));
        }
        for part in parts {
            let before = all.specimens.len();
            if part.lateral != all.lateral {
                all.lateral = Lateral::default();
            }
            let entry = |e: AuditEntry| AuditEntry { message: format!("{}: {}", part.file, e.message), ..e };
            all.audit.0.extend(part.audit.0.into_iter().map(entry));
            all.single.extend(part.single);
            all.samples.extend(part.samples.into_iter().map(|s| Sample { specimen: before + s.specimen, ..s }));
            all.raw.extend(part.raw.into_iter().map(|r| RawRow { specimen: before + r.specimen, ..r }));
            all.file += &format!(", {}", part.file);
            all.sha256 += &format!(", {}", part.sha256);
            all.specimens.extend(part.specimens);
            all.pieces.extend(part.pieces);
        }
        all.alternatives = alternatives;
        unequal.into_iter().for_each(|message| all.audit.add(AuditKind::Doubt, message, vec![]));
        all.check_repeats()?;
        Ok(all)
    }

    /// The test piece of a data point.
    pub fn piece(&self, s: &Sample) -> &Piece {
        self.pieces.get(s.specimen).unwrap_or(&self.pieces[0])
    }

    /// Refuses a specimen whose numbers repeat those of another specimen.
    fn check_repeats(&self) -> Result<(), FitError> {
        let mut numbers = vec![vec![]; self.specimens.len()];
        for s in &self.samples {
            numbers[s.specimen].extend([s.mode as usize as f64, s.stretch, s.second, s.stress]);
        }
        match same_data::first_pair(&numbers) {
            Some(pair) => {
                let [first, second] = pair.map(|k| self.specimens[k].clone());
                Err(FitError::SameData { first, second })
            }
            None => Ok(()),
        }
    }

    /// Modes that occur, in the order of [`Mode::ALL`].
    pub fn modes(&self) -> Vec<Mode> {
        Mode::ALL.into_iter().filter(|m| self.samples.iter().any(|s| s.mode == *m)).collect()
    }
}

/// Corrections that some tables of a fit have and others lack, in words.
fn unequal_corrections(parts: &[Experiment]) -> Vec<String> {
    let made = |e: &Experiment, error: SharedError| {
        e.pieces.iter().any(|p| p.corrections.iter().any(|c| c.error == error))
            || error == SharedError::Compliance && e.pieces.iter().any(|p| p.dimensions.compliance.is_some())
    };
    let one = |(error, words, flag): (SharedError, &str, &str)| {
        let (with, without): (Vec<&Experiment>, Vec<&Experiment>) = parts.iter().partition(|e| made(e, error));
        let files = |of: &[&Experiment]| few(&of.iter().map(|e| e.file.as_str()).collect::<Vec<_>>());
        let remedy = format!("pass --{flag} for all, or give each table a folder with a card of its own");
        (!with.is_empty() && !without.is_empty())
            .then(|| format!("{words} was corrected in {}, and not in {}: {remedy}", files(&with), files(&without)))
    };
    let corrections = [
        (SharedError::Compliance, "the compliance of the machine", "compliance"),
        (SharedError::Zeroing, "the zero of the stress", "zero"),
        (SharedError::Toe, "the toe", "toe"),
    ];
    corrections.into_iter().filter_map(one).collect()
}

/// Alternatives of several tables: tables without a treatment enter unchanged.
fn pool_alternatives(parts: &[Experiment]) -> Vec<Alternative> {
    use Treatment::{EveryRow, LastLoading, WithHold, WithRupture, WithoutToe, WithoutZero};
    let of = |treatment: Treatment| {
        let own = |e: &Experiment| e.alternatives.iter().find(|a| a.treatment == treatment).cloned();
        let unasked = parts.iter().filter_map(own).map(|a| a.unasked).reduce(|a, b| a || b)?;
        let mut before = 0;
        let mut all = vec![];
        for e in parts {
            let samples = own(e).map_or_else(|| e.samples.clone(), |a| a.samples);
            all.extend(samples.into_iter().map(|s| Sample { specimen: before + s.specimen, ..s }));
            before += e.specimens.len();
        }
        Some(Alternative { treatment, unasked, samples: all })
    };
    [WithHold, WithRupture, WithoutZero, WithoutToe, LastLoading, EveryRow].into_iter().filter_map(of).collect()
}

/// The line of names, with the units of a line below, and the lines of data. If the columns are given by number and the line holds numbers, the table
/// has no names, and the line is one of data.
fn names_and_body<'a>(lines: &'a [Line], at: usize, choice: &ColumnChoice, audit: &mut Audit) -> (Line, &'a [Line]) {
    if columns::is_row(&lines[at].cells, choice) {
        let number = lines[at].number;
        let message = "the table has no names of columns; they are taken by their numbers".to_string();
        audit.add(AuditKind::Intake, message, vec![number]);
        let cells = (1..=lines[at].cells.len()).map(|k| format!("column {k}")).collect();
        return (Line { number, cells }, &lines[at..]);
    }
    let below = columns::below_names(lines, at);
    let (names, _) = columns::with_units(&lines[at], (below > at + 1).then(|| &lines[below - 1]));
    (names, &lines[below..])
}

/// Number of characters in which the column names are sought first
const BEGINNING: usize = 1 << 16;

/// The delimiter, the lines, and the index of the line that names both strain and stress.
fn find_header(file: &str, text: &str, choice: &ColumnChoice) -> Result<(char, Vec<Line>, usize), FitError> {
    let (mut found, mut bare, mut is_named) = (Vec::new(), None, false);
    let beginning = text.char_indices().nth(BEGINNING).and_then(|(end, _)| Some(&text[..text[..end].rfind('\n')? + 1]));
    for delimiter in beginning.iter().flat_map(|_| table::DELIMITERS) {
        let lines = table::split(beginning.expect("a long text"), delimiter);
        if let Some((at, true)) = columns::find_header(&lines, choice) {
            return Ok((delimiter, table::split(text, delimiter), at));
        }
    }
    for delimiter in table::DELIMITERS {
        let lines = table::split(text, delimiter);
        if let Some((at, _)) = columns::find_header(&lines, choice) {
            return Ok((delimiter, lines, at));
        }
        // For the message: the line above the first line with two numbers has the names.
        let numbers = |l: &Line| l.cells.iter().filter(|c| table::is_number(c)).count();
        let first = lines.iter().position(|l| numbers(l) >= 2);
        let is_name = |c: &&String| !c.is_empty() && !table::is_number(c);
        let above = first.map(|i| i.checked_sub(1).map_or(0, |i| lines[i].cells.iter().filter(is_name).count()));
        is_named |= above.is_some_and(|names| names > 1);
        bare = bare.or(first.filter(|_| above.is_some_and(|names| names < 2)).map(|i| lines[i].number));
        let names = first.and_then(|i| i.checked_sub(1)).or((!lines.is_empty()).then_some(0));
        let names = names.map(|i| columns::quoted(&lines[i].cells)).unwrap_or_default();
        if names.len() > found.len() {
            found = names;
        }
    }
    if let (Some(line), false, None, None) = (bare, is_named, &choice.strain, &choice.stress) {
        return Err(FitError::NoNames { file: file.into(), line });
    }
    if found.is_empty() {
        found.push("none, the file is empty".into());
    }
    let strain = choice.strain.as_ref().map_or("stretch, strain or displacement".into(), |n| format!("name \"{n}\""));
    let stress = choice.stress.as_ref().map_or("stress or force".into(), |n| format!("name \"{n}\""));
    Err(FitError::Columns { file: file.into(), missing: format!("{strain} with one of {stress}"), found })
}

fn log_intake(audit: &mut Audit, header: &Line, delimiter: char, decimal: Decimal, columns: &Columns) {
    let delimiter = if delimiter == '\t' { "tab".into() } else { format!("\"{delimiter}\"") };
    let axis = |(e, p): &(columns::Column<StrainKind>, columns::Column<StressKind>)| {
        let unit = if e.unit == "1" { String::new() } else { format!(" in {}", e.unit) };
        format!("\"{}\" is {}{unit}, \"{}\" is {} in {}", e.name, e.kind.words(), p.name, p.kind.words(), p.unit)
    };
    let axes: Vec<String> = columns.axes.iter().map(axis).collect();
    let message = format!("delimiter {delimiter}, decimal {}; {}", decimal.name(), axes.join("; "));
    audit.add(AuditKind::Intake, message, vec![header.number]);
    for note in &columns.notes {
        audit.add(AuditKind::Intake, note.clone(), vec![]);
    }
}

/// The mode of a table without a mode column: as requested, from the card, or from a standard that the header names.
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
    if let (Some(asked), Some(own)) = (asked, card.and_then(|c| c.mode))
        && asked != own
    {
        audit.add(AuditKind::Intake, format!("the mode is {asked} as requested, the card says {own}"), vec![]);
    }
    let (mode, why) = match (asked, card.and_then(|c| c.mode)) {
        (Some(mode), _) => (mode, "as asked".to_string()),
        (None, Some(mode)) => (mode, "by the card".to_string()),
        (None, None) => {
            const TENSILE: [&str; 5] = ["astm d412", "iso 37", "din 53504", "jis k 6251", "gb/t 528"];
            let is_tensile = |text: &str| TENSILE.iter().any(|s| text.to_lowercase().contains(s));
            let (key, value) = header.iter().find(|(_, value)| is_tensile(value))?;
            (Mode::Uniaxial, format!("because the header says \"{key}: {value}\""))
        }
    };
    audit.add(AuditKind::Intake, format!("every data point is {mode}, {why}"), vec![]);
    Some(mode)
}
