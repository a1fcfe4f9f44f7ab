//! TRC files of OpenSim and Motion Analysis: a tab-separated table below a header of five lines.
//!
//! Source: OpenSim documentation, "Marker (.trc) files"; the third line has the values of the names in the second, the fourth the names of the
//! markers, the fifth X1, Y1, Z1, ….

use super::error::MotionError;
use super::table::{Wrong, coordinate};
use super::track::{Raw, ReadOptions, Track, twice};
use crate::calibrate::intake::table::{self, Line};
use crate::storage::columns::Rows;

/// Number of columns before the first coordinate: frame and time
const LEAD: usize = 2;

/// Whether a file begins as a TRC file.
pub fn is_trc(bytes: &[u8]) -> bool {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).starts_with(b"PathFileType")
}

/// Reads the bytes of a TRC file.
pub fn read(file: &str, bytes: &[u8], options: &ReadOptions) -> Result<Raw, MotionError> {
    let (text, _) = table::decode(bytes).map_err(|what| MotionError::NotText { file: file.into(), what })?;
    let lines = table::split(&text, '\t');
    let damaged = |what: &str| MotionError::NotText { file: file.into(), what: format!("the TRC file {what}") };
    let [_, keys, values, names, ..] = &lines[..] else { return Err(damaged("ends within its header")) };
    let value = |key: &str| {
        let at = keys.cells.iter().position(|c| c.eq_ignore_ascii_case(key))?;
        values.cells.get(at).filter(|v| !v.is_empty())
    };
    let is_row = |l: &Line| l.cells.first().is_some_and(|c| table::is_number(c));
    let below = (4..lines.len()).find(|k| is_row(&lines[*k])).unwrap_or(lines.len());
    let rows = Rows::under(file, '\t', &lines, 3, below)?;
    let body = &rows.body;
    let labels: Vec<(usize, &String)> =
        names.cells.iter().enumerate().skip(LEAD).filter(|(_, n)| !n.is_empty()).collect();
    if labels.is_empty() {
        return Err(MotionError::NoMarkers { file: file.into() });
    }
    let count = |key: &str| value(key).and_then(|v| v.parse::<usize>().ok());
    let found = body.len();
    if let Some(told) = count("NumFrames").filter(|told| *told != found) {
        return Err(MotionError::Truncated { file: file.into(), told, markers: labels.len(), found });
    }
    if let Some(told) = count("NumMarkers").filter(|told| *told != labels.len()) {
        return Err(damaged(&format!("announces {told} markers and names {}", labels.len())));
    }
    if let Some(name) = twice(labels.iter().map(|(_, name)| *name)) {
        return Err(MotionError::Twice { file: file.into(), name: name.clone(), at: None });
    }
    let width = body.iter().map(|l| l.cells.len()).max().unwrap_or(0);
    let decimal = rows.decimal(&(1..width).collect::<Vec<_>>(), None)?;
    let mut wrong = Wrong::default();
    let mut markers: Vec<Track> =
        labels.iter().map(|(_, name)| Track { name: name.to_string(), points: Vec::with_capacity(found) }).collect();
    let mut time_s = Vec::with_capacity(found);
    // With a rate the times follow from the numbers of the frames
    let (clock, what) = if options.rate_hz.is_some() { (0, "numbers of the frames") } else { (1, "times") };
    for line in body {
        let cell = |at: usize| line.cells.get(at).map_or("", String::as_str);
        match table::number(cell(clock), decimal) {
            Ok(t) => time_s.push(t),
            Err(_) => wrong.times.push(format!("line {} \"{}\"", line.number, cell(clock))),
        }
        for (marker, (at, _)) in markers.iter_mut().zip(&labels) {
            marker.points.push(coordinate([0, 1, 2].map(|i| cell(at + i)), line.number, decimal, &mut wrong));
        }
    }
    wrong.refuse(file)?;
    let late: Vec<u64> = (1..found).filter(|k| time_s[*k] <= time_s[*k - 1]).map(|k| body[k].number).collect();
    if !late.is_empty() {
        return Err(MotionError::Times { file: file.into(), what, lines: late });
    }
    let stated = value("DataRate").and_then(|v| table::number(v, decimal).ok());
    let (time_s, log) = match options.rate_hz {
        Some(rate) if rate > 0.0 && rate.is_finite() => {
            (time_s.iter().map(|frame| (frame - time_s[0]) / rate).collect(), vec![])
        }
        Some(rate) => return Err(MotionError::Rate { file: file.into(), rate }),
        None => {
            let log = rate_note(&time_s, stated);
            (time_s, log)
        }
    };
    Ok(Raw { format: "TRC", unit: value("Units").cloned(), samples: vec![1.0; found], time_s, markers, log })
}

/// Returns a line if the times contradict the rate in the header.
fn rate_note(time_s: &[f64], rate: Option<f64>) -> Vec<String> {
    let (Some(rate), [first, .., last]) = (rate, time_s) else { return vec![] };
    let own = (time_s.len() - 1) as f64 / (last - first);
    let differs = (own / rate - 1.0).abs() > 0.01;
    differs
        .then(|| format!("the header says {rate} Hz, the times say {own:.4} Hz; the times count"))
        .into_iter()
        .collect()
}
