//! States to restart from that `durometer simulate` saves.

use durometer::math::units::{self, Dimension};
use durometer::scene::{Checkpoint, CheckpointError, PARTIAL, Run, Scene};
use durometer::solve::Status;
use std::path::{Path, PathBuf};

/// The states that a run saves.
pub struct States<'a> {
    pub out: &'a Path,
    pub name: &'a str,
    /// The states that were requested
    pub files: Vec<PathBuf>,
    /// Whether a state was saved from which the run can be continued
    pub kept: bool,
    /// Why a requested state could not be saved; the first such error
    pub failure: Option<CheckpointError>,
}

impl States<'_> {
    fn file(&self, label: &str) -> PathBuf {
        self.out.join(format!("{}-{label}.state", self.name))
    }

    pub fn save(&mut self, checkpoint: &Checkpoint, label: &str) {
        let file = self.file(label);
        let written = checkpoint.write(&file);
        self.kept |= written.is_ok();
        match written {
            Ok(()) if label == PARTIAL => {}
            Ok(()) => self.files.push(file),
            Err(e) if label == PARTIAL => tell!("note: {e}"),
            Err(e) => self.failure = self.failure.take().or(Some(e)),
        }
    }

    /// Removes the partial state of a run that was not interrupted, which does not need it.
    pub fn end(&self, run: &Run) {
        if !matches!(run.status, Status::Interrupted { .. }) {
            std::fs::remove_file(self.file(PARTIAL)).ok();
        }
    }
}

/// Returns the times at which states are saved \[s\], and whether the last state is saved too.
pub fn times(when: &[String], scene: &Scene) -> Result<(Vec<f64>, bool), String> {
    let end = scene.spans.last().map_or(0.0, |s| s.end);
    let mut times = Vec::new();
    for text in when.iter().filter(|text| *text != "end") {
        let remedy = "write a time such as \"0.5 s\", or end";
        let t = units::parse(text, Dimension::TIME).map_err(|e| format!("--save-state: {e}; {remedy}"))?;
        if !(0.0..=end * (1.0 + 1e-9)).contains(&t) {
            return Err(format!("--save-state: the run is from 0 to {end} s and has no {text}; {remedy}"));
        }
        times.push(t);
    }
    Ok((times, when.iter().any(|text| text == "end")))
}
