//! The table of a signal: a CSV with a header line, time in s, then the value.

use crate::math::units::{self, Dimension};
use crate::storage::{self, DATA_LIMIT};
use std::path::Path;

/// Relative difference of two factors below which they belong to the same unit \[–\]
const SAME: f64 = 1e-12;
/// Units that are also words or symbols: at the end of a name they count only if their dimension is that of the column.
const AMBIGUOUS: [&str; 7] = ["m", "s", "g", "l", "in", "min", "bar"];

/// Reads times \[s\] and values \[SI\] from a file whose values are in `unit`; the error is the fact and the remedy.
pub(super) fn read_signal(
    path: &Path,
    (unit, factor): (&str, f64),
    dimension: Dimension,
) -> Result<Vec<(f64, f64)>, String> {
    let bytes = storage::read(path, DATA_LIMIT).map_err(|e| format!("{e}; the path is relative to the scene"))?;
    let unreadable = |e: csv::Error| e.to_string();
    let mut reader = csv::ReaderBuilder::new();
    reader.trim(csv::Trim::All).comment(Some(b'#')).has_headers(false).flexible(true);
    let mut records = reader.from_reader(bytes.as_slice()).into_records().peekable();
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    // Names after a # are the header if no other line is one
    let noted = names_in_comment(&lines).filter(|_| matches!(records.peek(), Some(Ok(first)) if is_row(first)));
    let (header, line) = match noted {
        Some(noted) => noted,
        None => {
            let first = records.next().ok_or("it has no header line; write for example \"t_s,value\"")?;
            let first = first.map_err(unreadable)?;
            let line = line_of(&first, &lines);
            (first, line)
        }
    };
    let checked = two_columns(&header).and_then(|names| check_header(names, (unit, factor), dimension));
    checked.map_err(|why| format!("line {line}: {why}"))?;
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for record in records {
        let record = record.map_err(unreadable)?;
        let line = line_of(&record, &lines);
        let numbers = record.deserialize::<(f64, f64)>(None).ok().filter(|_| record.len() == 2);
        let (t, value) = numbers.ok_or_else(|| {
            format!("line {line}: two numbers are needed (time in s, value in {unit}), separated by a comma")
        })?;
        if !t.is_finite() || !(value * factor).is_finite() {
            return Err(format!("line {line}: time or value is not a finite number"));
        }
        if rows.last().is_some_and(|last| last.0 >= t) {
            return Err(format!("line {line}: time must increase from row to row"));
        }
        rows.push((t, value * factor));
    }
    if rows.is_empty() { Err("the table has no row".into()) } else { Ok(rows) }
}

/// The line number of a record; the position that the reader gives is that of the empty lines and comments above it.
fn line_of(record: &csv::StringRecord, lines: &[&str]) -> usize {
    let above = record.position().map_or(0, |position| position.line() as usize - 1);
    let counts = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    1 + lines.iter().skip(above).position(counts).map_or(above, |k| above + k)
}

/// Whether a line consists of two numbers.
fn is_row(record: &csv::StringRecord) -> bool {
    record.len() == 2 && record.iter().all(|cell| cell.parse::<f64>().is_ok())
}

/// The last comment line above the rows, if it has two cells, as numpy writes the names, and its line number.
fn names_in_comment(lines: &[&str]) -> Option<(csv::StringRecord, usize)> {
    let above = lines.iter().enumerate().take_while(|(_, line)| line.trim().is_empty() || line.starts_with('#'));
    let (number, names) = above.filter_map(|(k, line)| Some((k + 1, line.strip_prefix('#')?))).last()?;
    let record: csv::StringRecord = names.split(',').map(str::trim).collect();
    (record.len() == 2).then_some((record, number))
}

/// The names of the two columns of a table; refuses any other number of columns.
fn two_columns(header: &csv::StringRecord) -> Result<[&str; 2], String> {
    let names: Vec<&str> = header.iter().map(str::trim).collect();
    match names[..] {
        [first, second] => Ok([first, second]),
        [one] if one.contains([';', '\t']) => {
            let mark = if one.contains(';') { "semicolons" } else { "tabs" };
            Err(format!(
                "its columns are separated by {mark}; separate them by commas, and write decimals with a point"
            ))
        }
        _ => {
            let fact = format!("the number of columns is {}, and a table has two, time and value", names.len());
            Err(format!("{fact}; write each value into a file of its own"))
        }
    }
}

/// Refuses a first line that is not a header, and names that contradict the order or the units of the columns.
fn check_header([first, second]: [&str; 2], (unit, factor): (&str, f64), dimension: Dimension) -> Result<(), String> {
    if first.parse::<f64>().is_ok() {
        let fact = "it has numbers, and the first line is the header, from which no point is taken";
        return Err(format!("{fact}; add a header line such as \"t_s,value\""));
    }
    if is_time(second) && !is_time(first) {
        return Err(format!("\"{second}\" is the second column; put the time first, and the value after it"));
    }
    let time = named_unit(first, Dimension::TIME).filter(|own| !own.is(1.0, Dimension::TIME));
    if let Some(own) = time {
        let remedy = "give the times in s, and the name without another unit";
        return Err(format!("the time \"{first}\" is in {}, and must be in s; {remedy}", own.name));
    }
    let value = named_unit(second, dimension).filter(|own| !own.is(factor, dimension));
    value.map_or(Ok(()), |own| {
        let fact = format!("the values \"{second}\" are in {}, and the scene says unit = \"{unit}\"", own.name);
        Err(format!("{fact}; correct the one that is wrong"))
    })
}

/// A unit in the name of a column.
struct NamedUnit<'a> {
    name: &'a str,
    factor: f64,
    dimension: Dimension,
}

impl NamedUnit<'_> {
    fn is(&self, factor: f64, dimension: Dimension) -> bool {
        self.dimension == dimension && (self.factor / factor - 1.0).abs() < SAME
    }
}

/// The unit in brackets, or otherwise after the last underscore or space, in the name of a column that is expected to have this dimension.
fn named_unit(name: &str, expected: Dimension) -> Option<NamedUnit<'_>> {
    let read = |name| {
        units::parts(&format!("1 {}", units::spelled(name))).ok().map(|(_, _, factor, dimension)| (factor, dimension))
    };
    let unit = |name| {
        let found = read(name).filter(|_| !matches!(name, "" | "1"));
        found.map(|(factor, dimension)| NamedUnit { name, factor, dimension })
    };
    let open = name.rfind(['[', '(']);
    if let Some(inside) = open.map(|k| name[k + 1..].trim_end_matches([']', ')', ' ']).trim()) {
        return unit(inside);
    }
    let (_, last) = name.rsplit_once(['_', ' '])?;
    let word = units::spelled(last);
    unit(last).filter(|own| own.dimension == expected || !AMBIGUOUS.contains(&word.as_str()))
}

/// Whether a column is called time, or has a unit of time in brackets.
fn is_time(name: &str) -> bool {
    let title = name.split(['[', '(', '_', ' ']).next().unwrap_or_default().to_lowercase();
    let in_time = || named_unit(name, Dimension::NONE).is_some_and(|own| own.dimension == Dimension::TIME);
    matches!(title.as_str(), "t" | "time") || in_time()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(names: [&str; 2]) -> Result<(), String> {
        check_header(names, ("mm", 1e-3), Dimension::LENGTH)
    }

    #[test]
    fn a_header_that_contradicts_is_refused() {
        for (names, says) in [
            (["0", "0"], "add a header line"),
            (["-1e-3", "x"], "add a header line"),
            (["t [ms]", "u [mm]"], "in ms, and must be in s"),
            (["time_ms", "u"], "in ms, and must be in s"),
            (["t (min)", "u"], "in min, and must be in s"),
            (["t", "u [m]"], "are in m, and the scene says unit = \"mm\""),
            (["t_s", "u_m"], "are in m, and the scene says unit = \"mm\""),
            (["t (msec)", "u"], "in msec, and must be in s"),
            (["t", "u [inch]"], "are in inch, and the scene says unit = \"mm\""),
            (["t", "u (μm)"], "are in μm"),
            (["t_s", "force_N"], "are in N, and the scene says unit = \"mm\""),
            (["t", "p (kPa)"], "are in kPa"),
            (["u", "t"], "put the time first"),
            (["shortening_mm", "time [s]"], "put the time first"),
            (["u", "x [s]"], "put the time first"),
        ] {
            let error = header(names).expect_err(says);
            assert!(error.contains(says), "{names:?}: {error}");
        }
    }

    #[test]
    fn a_table_has_two_columns_between_commas() {
        let of = |names: &[&str]| csv::StringRecord::from(names);
        let refused = |names: &[&str]| two_columns(&of(names)).expect_err("not two columns");
        assert!(refused(&["t_s", "v_mm", "u_mm"]).contains("the number of columns is 3"));
        assert!(refused(&["t_s"]).contains("the number of columns is 1"));
        assert!(refused(&["t_s;u_mm"]).contains("separated by semicolons; separate them by commas"));
        assert!(refused(&["t_s\tu_mm"]).contains("separated by tabs"));
        assert_eq!(two_columns(&of(&["t_s ", " u_mm"])), Ok(["t_s", "u_mm"]));
    }

    /// Blanks after commas and comment lines are accepted, and lines are counted as in the file.
    #[test]
    fn tables_are_read_as_they_are_written() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("room");
            read_signal(&path, ("mm", 1e-3), Dimension::LENGTH)
        };
        assert_eq!(read("# pulled by hand\nt_s, u_mm\n0, 0\n\n1.5,\t2\n"), Ok(vec![(0.0, 0.0), (1.5, 2e-3)]));
        assert_eq!(read("# t_s,u_mm\n0,0\n0.5,-1\n"), Ok(vec![(0.0, 0.0), (0.5, -1e-3)]), "as numpy.savetxt writes it");
        assert_eq!(read("\u{feff}# t_s,u_mm\n0,0\n"), Ok(vec![(0.0, 0.0)]), "behind a mark of the byte order");
        let error = read("# made by hand\n# t_s, u_m\n0,0\n").expect_err("another unit");
        assert!(error.starts_with("line 2: the values \"u_m\" are in m"), "{error}");
        let error = read("t_s,u_mm\n0,0,0\n").expect_err("three cells");
        assert!(error.starts_with("line 2: two numbers are needed"), "{error}");
        let error = read("# by hand\n0,0\n1,1\n").expect_err("no header");
        assert!(error.starts_with("line 2: it has numbers"), "{error}");
        let error = read("t_s,u_mm\n0,0\n\n\n1,a\n").expect_err("no number");
        assert!(error.starts_with("line 5: two numbers are needed"), "{error}");
    }

    #[test]
    fn other_names_are_taken() {
        for names in [
            ["t_s", "shortening_mm"],
            ["t", "u"],
            ["Time [s]", "Displacement [mm]"],
            ["time", "u (pull_in)"],
            ["t [s]", "u [1]"],
            ["t", "u_1"],
            ["x", "y"],
            ["t", "rate_s"],
            ["t", "u_second"],
            ["", ""],
            ["t", "length of the cable"],
        ] {
            assert_eq!(header(names), Ok(()), "{names:?}");
        }
        assert_eq!(check_header(["t", "pressure_IN"], ("kPa", 1e3), Dimension::PRESSURE), Ok(()), "an inlet, no inch");
    }
}
