//! Columns of a table of markers, and the line that names them.

use super::error::MotionError;
use super::table_names::{self as names, Cell};
use super::track::ReadOptions;
use crate::calibrate::intake::table;
use std::collections::HashMap;

/// Number of lines in which the column names are searched
const HEAD: usize = 200;

/// Indices of the columns.
#[derive(Default)]
pub struct Columns {
    pub time: Option<usize>,
    /// Column with the numbers of the frames
    pub frame: Option<usize>,
    pub samples: Option<usize>,
    /// Column with the name of the marker of the row
    pub marker: Option<usize>,
    pub record: Option<usize>,
    /// Columns of x, y and z for each marker, in the order of the file; the name is empty if rows name their marker
    pub points: Vec<(String, [Option<usize>; 3])>,
    /// Columns with the name of an earlier one, or with the same coordinate of the same marker
    pub twice: Vec<usize>,
}

impl Columns {
    pub fn of(cells: &[String]) -> Self {
        let mut columns = Self::default();
        let mut places: HashMap<String, usize> = HashMap::new();
        for (k, cell) in cells.iter().enumerate() {
            let free = |place: &mut Option<usize>| *place = place.or(Some(k));
            match names::meaning(cell) {
                Cell::Time => free(&mut columns.time),
                Cell::Frame => free(&mut columns.frame),
                Cell::Samples => free(&mut columns.samples),
                Cell::Marker => free(&mut columns.marker),
                Cell::Record => free(&mut columns.record),
                Cell::Coordinate { marker, axis } => {
                    let next = columns.points.len();
                    let at = *places.entry(marker.clone()).or_insert(next);
                    if at == next {
                        columns.points.push((marker, [None; 3]));
                    }
                    let place = &mut columns.points[at].1[axis];
                    *place = place.or(Some(k));
                }
                Cell::Other => {}
            }
        }
        // Rows that name their marker have one set of coordinates; in all other tables every set has a name
        let by_row = columns.marker.is_some();
        columns.points.retain(|(name, _)| name.is_empty() == by_row);
        let is_twice = |k: &usize| match names::meaning(&cells[*k]) {
            Cell::Other => false,
            Cell::Coordinate { marker, axis } => columns.points.iter().any(|p| p.0 == marker && p.1[axis] != Some(*k)),
            _ => cells[..*k].contains(&cells[*k]),
        };
        columns.twice = (0..cells.len()).filter(is_twice).collect();
        columns
    }

    fn is_table(&self, rate: Option<f64>) -> bool {
        let timed = self.time.is_some() || self.marker.is_some() || rate.is_some();
        timed && self.points.iter().any(|p| p.1.iter().all(Option::is_some))
    }

    pub fn numeric(&self) -> Vec<usize> {
        let points = self.points.iter().flat_map(|p| p.1).flatten();
        self.time.into_iter().chain(self.samples).chain(points).collect()
    }
}

/// Returns the delimiter and the index of the line with the column names.
pub fn find_names(file: &str, text: &str, options: &ReadOptions) -> Result<(char, usize), MotionError> {
    let end = text.match_indices('\n').nth(HEAD).map_or(text.len(), |(end, _)| end);
    let mut nearest: Vec<String> = vec![];
    for delimiter in table::DELIMITERS {
        for (at, line) in table::split(&text[..end], delimiter).iter().enumerate() {
            if line.cells.iter().any(|c| table::is_number(c)) {
                continue;
            }
            if Columns::of(&line.cells).is_table(options.rate_hz) {
                return Ok((delimiter, at));
            }
            let found: Vec<String> = line.cells.iter().filter(|c| !c.is_empty()).map(|c| format!("\"{c}\"")).collect();
            if found.len() > nearest.len() {
                nearest = found;
            }
        }
    }
    if nearest.is_empty() {
        nearest.push("no names".into());
    }
    nearest.truncate(12);
    Err(MotionError::Columns { file: file.into(), found: nearest })
}
