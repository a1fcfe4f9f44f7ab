//! Several specimens in one file: repeated lines of column names, and a column that tells specimens apart.
//!
//! A line equal to the one with the column names begins the table of another specimen. A column such as "Specimen" divides the rows if it has two or
//! more values, each in five or more rows on average; a column of numbers that increase with every row does not divide the table.

use super::columns::{self, Columns};
use super::table::{self, Decimal, Line};
use super::{
    audit::{Audit, AuditKind},
    columns::ColumnChoice,
    dimensions::{self, Dimensions},
    names,
};
use crate::calibrate::FitError;
use std::collections::HashMap;

/// Least average number of rows of a specimen
const ROWS: usize = 5;

/// The lines of one specimen.
pub struct SpecimenLines<'a> {
    /// `None` if the file has one specimen
    pub label: Option<String>,
    pub lines: Vec<&'a Line>,
}

/// First cell of a line and the rest; for a single cell, the parts before and after a colon.
pub fn pair(cells: &[String]) -> (String, String) {
    let rest: Vec<_> = cells.iter().skip(1).filter(|c| !c.is_empty()).map(String::as_str).collect();
    let first = cells.first().map_or("", String::as_str);
    match first.split_once([':', '=']) {
        Some((key, value)) if rest.is_empty() => (key.trim().into(), value.trim().into()),
        _ => (first.trim_end_matches(':').into(), rest.join(" ")),
    }
}

/// Keys and values of a table of results above the data, whose names are symbols of dimensions, with a line of units below and one line of numbers
/// for each specimen. A dimension that differs between specimens is left out.
pub fn of_results(lines: &[Line]) -> Vec<(String, String)> {
    let is_names = |l: &Line| l.cells.iter().filter(|c| dimensions::symbol(c).is_some()).count() > 1;
    let Some(at) = lines.iter().position(is_names) else { return vec![] };
    let below = columns::below_names(lines, at);
    let (names, _) = columns::with_units(&lines[at], (below > at + 1).then(|| &lines[below - 1]));
    let is_row = |l: &&Line| l.cells.iter().any(|c| table::is_number(c));
    let rows: Vec<&Line> = lines[below.min(lines.len())..].iter().take_while(is_row).collect();
    let one = |k: usize| {
        let value = rows.first()?.cells.get(k)?;
        let is_same = rows.iter().all(|l| l.cells.get(k) == Some(value));
        (dimensions::symbol(&names.cells[k]).is_some() && is_same).then(|| (names.cells[k].clone(), value.clone()))
    };
    (0..names.cells.len()).filter_map(one).collect()
}

/// The file that is divided.
pub struct Whole<'a> {
    pub file: &'a str,
    /// The line of the column names, as in the file
    pub names: &'a Line,
    pub body: &'a [Line],
    pub columns: &'a Columns,
    pub decimal: Decimal,
    /// Dimensions from the lines above the column names
    pub dimensions: Dimensions,
}

impl<'a> Whole<'a> {
    fn is_row(&self, line: &Line) -> bool {
        let mut cells = self.columns.numeric().map(|i| line.cells.get(i).map_or("", String::as_str));
        cells.all(|c| table::number(c, self.decimal).is_ok())
    }

    /// Divides the lines below the column names.
    pub fn divide(&self, audit: &mut Audit) -> Result<Vec<SpecimenLines<'a>>, FitError> {
        let starts = self.repeated()?;
        if !starts.is_empty() {
            return self.by_names(&starts, audit);
        }
        let all = || vec![SpecimenLines { label: None, lines: self.body.iter().collect() }];
        let Some(at) = self.columns.specimen else { return Ok(all()) };
        let rows: Vec<&'a Line> = self.body.iter().filter(|l| self.is_row(l)).collect();
        let label = |line: &'a Line| line.cells.get(at).map_or("", String::as_str);
        let Some(first) = rows.first() else { return Ok(all()) };
        let mut order: Vec<&'a str> = Vec::new();
        let mut of: HashMap<&'a str, Vec<&'a Line>> = HashMap::new();
        for line in self.body {
            // Lines that are not data rows stay with the first specimen, where they are logged
            let label = label(if self.is_row(line) { line } else { first });
            of.entry(label).or_insert_with(|| {
                order.push(label);
                vec![]
            });
            of.get_mut(label).expect("inserted").push(line);
        }
        if order.len() < 2 || order.len() * ROWS > rows.len() {
            return Ok(all());
        }
        let name = &self.names.cells[at];
        audit.add(
            AuditKind::Intake,
            format!(
                "column \"{name}\" holds {} values, each of which is a specimen: {}",
                order.len(),
                order.join(", ")
            ),
            vec![],
        );
        let part = |label: &'a str| SpecimenLines {
            label: Some(format!("specimen {label}")),
            lines: of.remove(label).expect("listed"),
        };
        Ok(order.into_iter().map(part).collect())
    }

    /// Indices of lines that repeat the column names; refuses different names of strain and stress above numbers.
    fn repeated(&self) -> Result<Vec<usize>, FitError> {
        let first = self.columns.numeric().next().expect("a table has a column of strain");
        let is_text =
            |l: &Line| l.cells.get(first).is_some_and(|c| !c.is_empty() && table::number(c, self.decimal).is_err());
        let mut found = vec![];
        for (k, line) in self.body.iter().enumerate().filter(|(_, l)| is_text(l)) {
            if line.cells == self.names.cells {
                found.push(k);
            } else if columns::is_header(&line.cells, &ColumnChoice::default())
                && self.body.get(columns::below_names(self.body, k)).is_some_and(|l| self.is_row(l))
            {
                return Err(FitError::OtherNames { file: self.file.into(), line: line.number });
            }
        }
        Ok(found)
    }

    fn by_names(&self, starts: &[usize], audit: &mut Audit) -> Result<Vec<SpecimenLines<'a>>, FitError> {
        let is_title = |l: &&Line| {
            !l.is_empty()
                && !l.cells.iter().any(|c| table::is_number(c))
                && l.cells.iter().any(|c| c.chars().any(char::is_alphabetic))
        };
        let mut parts = Vec::new();
        let first = self.names.number;
        let mut label = format!("table of line {first}");
        let mut from = 0;
        for end in starts.iter().copied().chain([self.body.len()]) {
            let own = &self.body[from..end];
            // The title of the next table begins with the first line without numbers that is followed by fewer rows than a specimen has
            let begins = |k: &usize| {
                end < self.body.len()
                    && is_title(&&own[*k])
                    && own[*k..].iter().filter(|l| self.is_row(l)).count() < ROWS
            };
            let length = (0..own.len()).find(begins).unwrap_or(own.len());
            let rows: Vec<u64> = own[length..].iter().filter(|l| self.is_row(l)).map(|l| l.number).collect();
            if !rows.is_empty() {
                let message = format!(
                    "{} rows of numbers belong to the title above the column names of line {}",
                    rows.len(),
                    self.body[end].number
                );
                audit.add(AuditKind::LeftOut, message, rows);
            }
            parts.push(SpecimenLines { label: Some(label), lines: own[..length].iter().collect() });
            let Some(next) = self.body.get(end) else { break };
            let header: Vec<_> = own[length..].iter().map(|l| pair(&l.cells)).collect();
            let (other, unclear) = Dimensions::of_header(&header);
            let is_other = other != Dimensions::default() && other.or(self.dimensions) != self.dimensions;
            if is_other || unclear.iter().any(|u| self.dimensions.has(u.key)) {
                return Err(FitError::OtherDimensions { file: self.file.into(), line: next.number });
            }
            let named = header.iter().find(|(key, value)| names::is_specimen(key) && !value.is_empty());
            label = named.map_or_else(|| format!("table of line {}", next.number), |(_, v)| format!("specimen {v}"));
            from = columns::below_names(self.body, end);
        }
        let lines = starts.iter().map(|k| self.body[*k].number).collect();
        let message = format!(
            "the column names are repeated: the file holds {} tables, each of which is a specimen",
            parts.len()
        );
        audit.add(AuditKind::Intake, message, lines);
        Ok(parts)
    }
}
