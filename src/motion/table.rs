//! Text tables with marker positions: one row per time (`t_s, tip_x_mm, tip_y_mm, tip_z_mm, …`) or one row per marker (`marker, t_s, x_mm, y_mm,
//! z_mm`). Delimiter, decimal mark and encoding are detected as in tables of material tests.

use super::error::MotionError;
use super::table_columns::{Columns, find_names};
use super::table_names as names;
use super::track::{Raw, ReadOptions, Track};
use crate::calibrate::intake::names as units;
use crate::calibrate::intake::table::{self, Decimal, Line};
use crate::math::units::Dimension;
use crate::storage::columns::{self, units_below};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Reads the bytes of a table.
pub fn read(file: &str, bytes: &[u8], options: &ReadOptions) -> Result<Raw, MotionError> {
    let (text, encoding) = table::decode(bytes).map_err(|what| MotionError::NotText { file: file.into(), what })?;
    let (delimiter, at) = find_names(file, &text, options)?;
    let lines = table::split(&text, delimiter);
    let names = &lines[at];
    let units = units_below(&lines, at, |l| !l.cells.iter().any(|c| table::is_number(c)));
    let rows = columns::Rows::under(file, delimiter, &lines, at, units.unwrap_or(at) + 1)?;
    let columns = Columns::of(&names.cells);
    if let Some(name) = columns.twice.first() {
        return Err(MotionError::Column { file: file.into(), name: names.cells[*name].clone() });
    }
    let incomplete: Vec<String> = columns.points.iter().filter(|p| p.1.contains(&None)).map(|p| p.0.clone()).collect();
    if !incomplete.is_empty() {
        return Err(MotionError::Incomplete { file: file.into(), markers: incomplete });
    }
    let decimal = rows.decimal(&columns.numeric(), None)?;
    let mut log: Vec<String> =
        encoding.map(|e| format!("the file is not UTF-8; it was read as {e}")).into_iter().collect();
    let shown = if delimiter == '\t' { "tab".into() } else { format!("\"{delimiter}\"") };
    log.push(format!("delimiter {shown}, decimal {}", decimal.name()));
    let own = units.map(|k| &lines[k].cells);
    let table = Table { file, names: &names.cells, units: own, columns: &columns, decimal, options };
    let unit = table.unit()?;
    let factor = table.time_factor(&mut log)?;
    let body = table.of_record(rows.body)?;
    let (format, rows) = if columns.marker.is_some() {
        ("table with one row per marker", table.by_marker(&body)?)
    } else {
        ("table with one row per time", table.by_time(&body)?)
    };
    let Rows { time, samples, markers } = rows;
    let first = time.first().copied().unwrap_or(0.0);
    if let Some(at) = table.frame_column() {
        log.push(format!(
            "column \"{}\" numbers the frames, from {first} on; they follow at the given rate",
            names.cells[at]
        ));
    }
    let seconds = |t: f64| options.rate_hz.map_or(factor * t, |rate| (t - first) / rate);
    if samples.iter().any(|n| *n != 1.0) {
        let most = samples.iter().fold(0.0, |a: f64, n| a.max(*n));
        log.push(format!("rows are means of up to {most} samples, with which they are weighted"));
    }
    Ok(Raw { format, unit, time_s: time.into_iter().map(seconds).collect(), samples, markers, log })
}

/// Rows in the unit of the file; times are numbers of frames if the rate is given.
struct Rows {
    time: Vec<f64>,
    samples: Vec<f64>,
    markers: Vec<Track>,
}

struct Table<'a> {
    file: &'a str,
    names: &'a [String],
    units: Option<&'a Vec<String>>,
    columns: &'a Columns,
    decimal: Decimal,
    options: &'a ReadOptions,
}

impl Table<'_> {
    fn file(&self) -> String {
        self.file.into()
    }

    fn own_unit(&self, at: usize) -> Option<String> {
        let below = || self.units?.get(at).map(|c| c.trim_matches(['(', ')', '[', ']']).trim().to_string());
        names::unit(&self.names[at]).or_else(below).filter(|u| !u.is_empty())
    }

    /// Returns the unit of all coordinates if the column names state it.
    fn unit(&self) -> Result<Option<String>, MotionError> {
        let mut found: Vec<String> =
            self.columns.points.iter().flat_map(|p| p.1).flatten().filter_map(|k| self.own_unit(k)).collect();
        found.sort();
        found.dedup();
        match found.len() {
            0 | 1 => Ok(found.pop()),
            _ if self.options.unit.is_some() => Ok(None),
            _ => Err(MotionError::Units { file: self.file(), units: found }),
        }
    }

    /// Returns the factor that converts the times to seconds.
    fn time_factor(&self, log: &mut Vec<String>) -> Result<f64, MotionError> {
        if let Some(rate) = self.options.rate_hz {
            let valid = rate > 0.0 && rate.is_finite();
            return if valid { Ok(1.0) } else { Err(MotionError::Rate { file: self.file(), rate }) };
        }
        let Some(at) = self.columns.time else { return Ok(1.0) };
        let Some(unit) = self.options.time_unit.clone().or_else(|| self.own_unit(at)) else {
            log.push(format!("column \"{}\" states no unit and is read in seconds", self.names[at]));
            return Ok(1.0);
        };
        let refused = || MotionError::Unit { file: self.file(), unit: unit.clone(), of: "time", example: "s" };
        units::factor(&unit, Dimension::TIME).ok_or_else(refused)
    }

    fn cell<'b>(&self, line: &'b Line, at: usize) -> &'b str {
        line.cells.get(at).map_or("", String::as_str)
    }

    /// Returns the column with the numbers of the frames, if the times follow from them.
    fn frame_column(&self) -> Option<usize> {
        self.options.rate_hz.and(self.columns.frame)
    }

    /// Returns the time and the number of samples of a row; if the rate is given, the number of the frame in place of the time: that of the file, or
    /// else its index. Cells that are not numbers are added to `wrong` with the numbers of their lines.
    fn row(&self, line: &Line, frame: usize, wrong: &mut Wrong) -> (f64, f64) {
        let read = |at: Option<usize>, otherwise: f64, wrong: &mut Vec<String>| match at.map(|k| self.cell(line, k)) {
            None => otherwise,
            Some(cell) => table::number(cell, self.decimal).unwrap_or_else(|_| {
                wrong.push(format!("line {} \"{cell}\"", line.number));
                otherwise
            }),
        };
        let time = match self.options.rate_hz {
            Some(_) => read(self.columns.frame, frame as f64, &mut wrong.cells),
            None => read(self.columns.time, 0.0, &mut wrong.times),
        };
        let samples = read(self.columns.samples, 1.0, &mut wrong.cells);
        if samples <= 0.0 {
            wrong.cells.push(format!("line {} \"{samples}\" samples", line.number));
        }
        (time, samples)
    }

    fn by_time(&self, body: &[&Line]) -> Result<Rows, MotionError> {
        let names = self.columns.points.iter().map(|p| p.0.clone());
        let mut markers: Vec<Track> =
            names.map(|name| Track { name, points: Vec::with_capacity(body.len()) }).collect();
        let (mut time, mut samples, mut wrong) = (vec![], vec![], Wrong::default());
        for (number, line) in body.iter().enumerate() {
            let (t, n) = self.row(line, number, &mut wrong);
            time.push(t);
            samples.push(n);
            for (marker, (_, axes)) in markers.iter_mut().zip(&self.columns.points) {
                let cells = axes.map(|k| k.map_or("", |k| self.cell(line, k)));
                marker.points.push(coordinate(cells, line.number, self.decimal, &mut wrong));
            }
        }
        wrong.refuse(self.file)?;
        let late: Vec<u64> = (1..time.len()).filter(|k| time[*k] <= time[*k - 1]).map(|k| body[k].number).collect();
        if !late.is_empty() {
            let what = if self.frame_column().is_some() { "numbers of the frames" } else { "times" };
            return Err(MotionError::Times { file: self.file(), what, lines: late });
        }
        Ok(Rows { time, samples, markers })
    }

    /// Returns the lines of the requested record.
    fn of_record<'b>(&self, body: Vec<&'b Line>) -> Result<Vec<&'b Line>, MotionError> {
        let Some(at) = self.columns.record else {
            let unused = || {
                let fact = "the table has no column record, experiment, trial or run";
                MotionError::Unused { file: self.file(), option: "--record", fact }
            };
            return if self.options.record.is_some() { Err(unused()) } else { Ok(body) };
        };
        let (mut known, mut seen): (Vec<String>, HashSet<&str>) = (vec![], HashSet::new());
        for line in &body {
            let name = self.cell(line, at);
            if seen.insert(name) {
                known.push(name.into());
            }
        }
        match &self.options.record {
            None if known.len() > 1 => Err(MotionError::Records { file: self.file(), records: known }),
            None => Ok(body),
            Some(asked) if !known.contains(asked) => {
                Err(MotionError::NoRecord { file: self.file(), asked: asked.clone(), known })
            }
            Some(asked) => Ok(body.into_iter().filter(|l| self.cell(l, at) == asked).collect()),
        }
    }

    fn by_marker(&self, body: &[&Line]) -> Result<Rows, MotionError> {
        let (at, axes) = (self.columns.marker.unwrap_or_default(), self.columns.points[0].1);
        let (mut wrong, mut uneven) = (Wrong::default(), vec![]);
        let (mut order, mut frames): (Vec<String>, HashMap<String, usize>) = (vec![], HashMap::new());
        // Times in numerical order (IEEE total order), not in the order of the file
        let mut rows: BTreeMap<Sorted, MarkerRow> = BTreeMap::new();
        for line in body {
            let name = self.cell(line, at).to_string();
            let frame = frames.entry(name.clone()).or_insert_with(|| {
                order.push(name.clone());
                0
            });
            let (t, n) = self.row(line, *frame, &mut wrong);
            *frame += 1;
            let point =
                coordinate(axes.map(|k| k.map_or("", |k| self.cell(line, k))), line.number, self.decimal, &mut wrong);
            let row = rows.entry(Sorted(t)).or_insert((n, BTreeMap::new()));
            if row.0 != n {
                uneven.push(line.number);
            }
            if row.1.insert(name.clone(), point).is_some() {
                let at = if self.frame_column().is_some() { format!("in frame {t}") } else { format!("at {t} s") };
                return Err(MotionError::Twice { file: self.file(), name, at: Some(at) });
            }
        }
        wrong.refuse(self.file)?;
        // At a single time, nothing is weighted
        if rows.len() > 1 && !uneven.is_empty() {
            return Err(MotionError::Uneven { file: self.file(), lines: uneven });
        }
        // Without times and numbers of frames, a marker that lacks a row in a frame would be shifted in time relative to the others
        if self.options.rate_hz.is_some() && self.columns.frame.is_none() && frames.values().any(|n| *n != rows.len()) {
            let counts = order.iter().map(|name| format!("{name} {}", frames[name])).collect();
            return Err(MotionError::Frames { file: self.file(), counts });
        }
        let track = |name: &String| Track {
            name: name.clone(),
            points: rows.values().map(|row| row.1.get(name).copied().flatten()).collect(),
        };
        let markers = order.iter().map(track).collect();
        let samples = rows.values().map(|row| row.0).collect();
        Ok(Rows { time: rows.keys().map(|t| t.0).collect(), samples, markers })
    }
}

/// Number of samples at a time, and the positions of the markers that have a row.
type MarkerRow = (f64, BTreeMap<String, Option<[f64; 3]>>);

/// A time used as a key.
#[derive(PartialEq)]
struct Sorted(f64);

impl Eq for Sorted {}

impl PartialOrd for Sorted {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Sorted {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Cells that are invalid for their columns, line by line.
#[derive(Default)]
pub(super) struct Wrong {
    pub times: Vec<String>,
    /// Positions with some empty cells
    pub partial: Vec<String>,
    pub cells: Vec<String>,
}

impl Wrong {
    /// Returns the refusal of the first kind that occurs.
    pub fn refuse(self, file: &str) -> Result<(), MotionError> {
        let file = file.to_string();
        match self {
            Self { times, .. } if !times.is_empty() => Err(MotionError::Clock { file, cells: times }),
            Self { cells, .. } if !cells.is_empty() => Err(MotionError::Cells { file, cells }),
            Self { partial, .. } if !partial.is_empty() => Err(MotionError::Partial { file, at: partial }),
            _ => Ok(()),
        }
    }
}

/// Reads three cells as a position; `None` if the marker was not visible: all cells are empty, or one is NaN in any of the usual spellings.
pub(super) fn coordinate(cells: [&str; 3], line: u64, decimal: Decimal, wrong: &mut Wrong) -> Option<[f64; 3]> {
    let is_gap = |c: &str| matches!(c.to_lowercase().as_str(), "nan" | "-nan" | "na" | "n/a");
    if cells.iter().all(|c| c.is_empty()) || cells.iter().any(|c| is_gap(c)) {
        return None;
    }
    if cells.iter().any(|c| c.is_empty()) {
        wrong.partial.push(format!("line {line} ({})", cells.map(|c| if c.is_empty() { "–" } else { c }).join(", ")));
        return None;
    }
    let mut read = |cell: &str| match table::number(cell, decimal) {
        Ok(x) => x,
        Err(_) => {
            wrong.cells.push(format!("line {line} \"{cell}\""));
            f64::NAN
        }
    };
    Some(cells.map(&mut read))
}
