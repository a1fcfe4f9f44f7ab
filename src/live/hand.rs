//! A controller that sets signals to the values requested by a page, and records them so that they can be replayed.

use super::board::Board;
use crate::scene::control::recording::Recording;
use crate::scene::control::{ControlError, Controller, Observation, Opening, Reply};
use serde_json::json;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Sets signals to the values that a user enters on a page.
pub struct HandControl {
    board: Arc<Board>,
    path: PathBuf,
    file: Option<File>,
    /// The recording so far; kept in checkpoints, so that the file of a continued run is whole
    text: String,
    /// Last recorded values
    past: Vec<f64>,
    /// Number of rows of the recording
    pub rows: usize,
}

impl HandControl {
    /// Creates a controller that takes values from the board and records them in the file `path`.
    pub fn new(board: Arc<Board>, path: &Path) -> Self {
        Self { board, path: path.into(), file: None, text: String::new(), past: vec![], rows: 0 }
    }

    /// Renames an earlier recording to the next free name, `<name>.control-1.csv` and so on, unless the new recording begins with all its rows.
    fn set_aside(&self, text: &str) -> std::io::Result<()> {
        let earlier = match std::fs::read(&self.path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(()),
            earlier => earlier?,
        };
        if text.as_bytes().starts_with(&earlier) {
            return Ok(());
        }
        let other = |n: usize| self.path.with_extension("").with_extension(format!("control-{n}.csv"));
        let free =
            (1..).map(other).find(|path| path.symlink_metadata().is_err()).expect("there is always a next number");
        std::fs::rename(&self.path, free)
    }

    fn write(&mut self, text: &str) -> Result<(), ControlError> {
        let written = match &mut self.file {
            Some(file) => file.write_all(text.as_bytes()),
            None => self.set_aside(text).and_then(|()| {
                let mut file = File::create(&self.path)?;
                file.write_all(text.as_bytes()).map(|()| self.file = Some(file))
            }),
        };
        let failed =
            |e: std::io::Error| ControlError::Record { file: self.path.display().to_string(), reason: e.to_string() };
        written.map_err(failed)?;
        self.text += text;
        Ok(())
    }
}

impl Controller for HandControl {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        let kept = opening.memory["recording"].as_str().filter(|text| {
            let recording = Recording::parse(text, "", opening.signals).ok();
            recording.inspect(|r| self.rows = r.rows.len()).is_some()
        });
        self.write(&kept.map_or_else(|| Recording::header(opening.signals), str::to_string))
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        signals.copy_from_slice(&self.board.values());
        if self.past != signals {
            self.write(&Recording::line(observation.row[0], signals))?;
            self.past = signals.to_vec();
            self.rows += 1;
        }
        Ok(Reply { memory: json!({ "recording": self.text }), ..Reply::default() })
    }

    fn identity(&self) -> Option<String> {
        Some("page".into())
    }
}
