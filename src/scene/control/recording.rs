//! Values to which controlled signals were set during a run, in a table from which a later run sets them again.
//!
//! A row has the time of a grid point and the values that were set there, which the signals reach at the next point. A value holds until the next row. Numbers
//! are written in the shortest form that reads back as the same number, so that the later run gets the same bits. Every row ends with a line break: a last row
//! without one was cut off, possibly in the middle of a number, and is refused.

use super::{ControlError, Controller, Observation, Reply, SignalSetting};
use crate::scene::signal::instant::rounding;
use crate::storage::{self, DATA_LIMIT};
use crate::wording::count;
use std::path::Path;

/// Reason why a recording cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    #[error("{file}: cannot be read: {reason}; give a file <name>.control.csv that a run with --live has written")]
    Unreadable { file: String, reason: String },
    #[error(
        "{file}: the header is not t_s with the names of signals; give a file <name>.control.csv that a run with --live has written"
    )]
    Header { file: String },
    #[error("{file}: line {line}: {fact}; record it again")]
    Row { file: String, line: usize, fact: String },
    #[error(
        "{file}: line {line}: it has no line break at its end, so that the file was cut off there; record it again, or remove this line to set only what is before it, or end it if it is whole"
    )]
    CutOff { file: String, line: usize },
    #[error(
        "{file}: it sets {found}, and the scene leaves {wanted} to a controller; give the recording of a run of this scene"
    )]
    Signals { file: String, found: String, wanted: String },
}

/// Values with the times at which they were set.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Recording {
    pub signals: Vec<String>,
    /// Time of the grid point \[s\], and the values of all signals \[SI\]
    pub rows: Vec<(f64, Vec<f64>)>,
}

impl Recording {
    /// Reads a recording of these signals.
    ///
    /// # Errors
    ///
    /// Where the file cannot be read, or is not a recording of these signals.
    pub fn read(path: &Path, signals: &[String]) -> Result<Self, RecordingError> {
        let file = path.display().to_string();
        let text = storage::read_text(path, DATA_LIMIT)
            .map_err(|e| RecordingError::Unreadable { file: file.clone(), reason: e.to_string() })?;
        Self::parse(&text, &file, signals)
    }

    /// Reads the text of a recording of these signals; `file` is its name in messages.
    ///
    /// # Errors
    ///
    /// Where the text is not a recording of these signals, with the line.
    pub fn parse(text: &str, file: &str, signals: &[String]) -> Result<Self, RecordingError> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().map_err(|_| RecordingError::Header { file: file.into() })?.clone();
        let mut names = header.iter().map(str::to_string);
        if names.next().as_deref() != Some("t_s") {
            return Err(RecordingError::Header { file: file.into() });
        }
        let found: Vec<String> = names.collect();
        if found != signals {
            let list = |names: &[String]| if names.is_empty() { "nothing".into() } else { names.join(", ") };
            return Err(RecordingError::Signals { file: file.into(), found: list(&found), wanted: list(signals) });
        }
        if !text.ends_with('\n') {
            return Err(RecordingError::CutOff { file: file.into(), line: text.lines().count() });
        }
        let mut rows: Vec<(f64, Vec<f64>)> = vec![];
        for (k, record) in reader.records().enumerate() {
            let refuse = |fact: &str| RecordingError::Row { file: file.into(), line: k + 2, fact: fact.into() };
            let record = record.map_err(|_| refuse("it has not as many values as the header"))?;
            let number = |text: &str| text.trim().parse().ok().filter(|v: &f64| v.is_finite());
            let numbers: Option<Vec<f64>> = record.iter().map(number).collect();
            let mut numbers = numbers.ok_or_else(|| refuse("a value is not a finite number"))?;
            let t = numbers.remove(0);
            if rows.last().is_some_and(|(past, _)| *past >= t) {
                return Err(refuse("its time is not after that of the row before"));
            }
            rows.push((t, numbers));
        }
        Ok(Self { signals: found, rows })
    }

    /// The extent of the recording, such as `3 rows, the last at 0.5 s`.
    fn extent(&self) -> String {
        match self.rows.last() {
            Some((t, _)) => format!("{}, the last at {t} s", count(self.rows.len(), "row")),
            None => "no row".into(),
        }
    }

    /// The header line with the names of the columns.
    pub fn header(signals: &[String]) -> String {
        std::iter::once("t_s").chain(signals.iter().map(String::as_str)).collect::<Vec<_>>().join(",") + "\n"
    }

    /// One row as a line of text.
    pub fn line(t: f64, values: &[f64]) -> String {
        std::iter::once(&t).chain(values).map(ToString::to_string).collect::<Vec<_>>().join(",") + "\n"
    }
}

/// A controller that sets the recorded values again.
#[derive(Clone)]
pub struct Replay {
    /// Digest of the text of the recording
    pub sha256: String,
    /// Extent of the recording, such as `3 rows, the last at 0.5 s`
    pub extent: String,
    rows: std::iter::Peekable<std::vec::IntoIter<(f64, Vec<f64>)>>,
}

impl Replay {
    pub fn new(recording: Recording) -> Self {
        let lines = recording.rows.iter().map(|(t, values)| Recording::line(*t, values));
        let text = Recording::header(&recording.signals) + &lines.collect::<String>();
        let (sha256, extent) = (storage::sha256(&text), recording.extent());
        Self { sha256, extent, rows: recording.rows.into_iter().peekable() }
    }
}

impl Controller for Replay {
    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        let now = observation.row[0];
        let reached = now + rounding(now, observation.next - now);
        while let Some((_, values)) = self.rows.next_if(|(t, _)| *t <= reached) {
            signals.copy_from_slice(&values);
        }
        Ok(Reply::default())
    }

    fn identity(&self) -> Option<String> {
        Some(format!("recording {}", self.sha256))
    }

    fn would_set(&self, initial: &[f64], set: &[SignalSetting]) -> Option<bool> {
        let (mut replay, mut signals) = (self.clone(), initial.to_vec());
        let mut sets = |s: &SignalSetting| {
            let is_set = replay.step(&Observation { row: &[s.t], next: s.next }, &mut signals).is_ok();
            is_set && signals == s.values
        };
        Some(set.iter().all(&mut sets))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_the_grid_is_reached_to_its_rounding() {
        let recording = Recording { signals: vec!["a".into()], rows: vec![(1.36, vec![7.0])] };
        let mut replay = Replay::new(recording);
        let mut at = |t: f64| {
            let mut signals = [0.0];
            replay.step(&Observation { row: &[t], next: t + 0.01 }, &mut signals).expect("a replay has no errors");
            signals[0]
        };
        assert_eq!((at(1.35), at(1.359_999_999_999_999_9)), (0.0, 7.0));
    }
}
