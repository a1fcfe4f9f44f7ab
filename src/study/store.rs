//! Files of a case on disk. The record is written last: with it the case counts as done.

use crate::calibrate::inverse::Calibration;
use crate::scene::{ErrorEstimate, RefinementStep, Run, Scene, Sensitivities};
use crate::storage::{self, DATA_LIMIT};
use crate::study::identity::{FileDigest, Identity};
use crate::study::record::{CaseRecord, StudyRecord};
use crate::study::skin::Skin;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The folder of results cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {reason}; choose another folder with --out, or make room", path.display())]
pub struct StoreError {
    pub path: PathBuf,
    pub reason: String,
}

/// The folder of a study's results.
#[derive(Clone, Debug)]
pub struct Store {
    pub dir: PathBuf,
}

impl Store {
    /// Makes the folder and writes `study.json`.
    pub fn create(dir: &Path, study: &StudyRecord) -> Result<Self, StoreError> {
        let store = Self { dir: dir.into() };
        let cases = dir.join("cases");
        std::fs::create_dir_all(&cases).map_err(|e| StoreError { path: cases, reason: e.to_string() })?;
        write(&dir.join("study.json"), &json(study))?;
        Ok(store)
    }

    /// The stored record of a case, if there is one whose files are those that were stored with it.
    pub fn record(&self, id: &str) -> Option<CaseRecord> {
        let text = storage::read(&self.path(id, "json"), DATA_LIMIT).ok()?;
        let record: CaseRecord = serde_json::from_slice(&text).ok()?;
        let same = |f: &FileDigest| {
            storage::read(&self.dir.join("cases").join(&f.file), DATA_LIMIT)
                .is_ok_and(|b| storage::sha256(b) == f.sha256)
        };
        record.provenance.results.iter().all(same).then_some(record)
    }

    /// The stored record of this case no longer counts where it has another identity: a report must not mix them. The time
    /// series stays.
    pub fn forget_outdated(&self, id: &str, identity: &Identity) -> Result<(), StoreError> {
        let path = self.path(id, "json");
        let known = self.record(id).is_some_and(|r| r.provenance.identity == *identity);
        if known || !path.is_file() {
            return Ok(());
        }
        std::fs::remove_file(&path).map_err(|e| StoreError { path, reason: e.to_string() })
    }

    /// Whether there is a record of this case, sound or not.
    pub fn has(&self, id: &str) -> bool {
        self.path(id, "json").is_file()
    }

    /// Time series, surface, then the record with the digests of both.
    pub fn save(&self, record: &mut CaseRecord, run: &Run, skin: &Skin) -> Result<(), StoreError> {
        record.provenance.results.clear();
        for (extension, bytes) in [("csv", csv(run).into_bytes()), ("skin.json.gz", skin.packed())] {
            replace(&self.path(&record.id, extension), &bytes)?;
            let digest = FileDigest { file: format!("{}.{extension}", record.id), sha256: storage::sha256(bytes) };
            record.provenance.results.push(digest);
        }
        write(&self.path(&record.id, "json"), &json(record))
    }

    /// The record of a case that has no run.
    pub fn save_refused(&self, record: &CaseRecord) -> Result<(), StoreError> {
        write(&self.path(&record.id, "csv"), "t_s\n")?;
        std::fs::remove_file(self.path(&record.id, "skin.json.gz")).ok();
        write(&self.path(&record.id, "json"), &json(record))
    }

    /// Saves the result of a case of a calibration.
    pub fn save_calibration(&self, id: &str, found: &Calibration) -> Result<(), StoreError> {
        write(&self.path(id, "fit.json"), &json(found))
    }

    /// The saved result of a case of a calibration, if there is one.
    pub fn calibration(&self, id: &str) -> Option<Calibration> {
        serde_json::from_slice(&storage::read(&self.path(id, "fit.json"), DATA_LIMIT).ok()?).ok()
    }

    pub fn save_sensitivities(&self, id: &str, run: &Run, sensitivities: &Sensitivities) -> Result<(), StoreError> {
        write(&self.path(id, "sensitivities.csv"), &sensitivities_csv(run, sensitivities))
    }

    /// Folder of a case's own files, made if need be.
    pub fn folder(&self, id: &str) -> Result<PathBuf, StoreError> {
        let path = self.dir.join("cases").join(id);
        match std::fs::create_dir_all(&path) {
            Ok(()) => Ok(path),
            Err(e) => Err(StoreError { path, reason: e.to_string() }),
        }
    }

    fn path(&self, id: &str, extension: &str) -> PathBuf {
        self.dir.join("cases").join(format!("{id}.{extension}"))
    }
}

/// The prescribed signals on the time grid of the run.
pub fn signals_csv(scene: &Scene, run: &Run) -> String {
    let mut text = "t_s".to_string();
    scene.signals.iter().for_each(|s| text += &format!(",{}", s.name));
    text.push('\n');
    for (row, signals) in run.written.iter().map(|&k| (&run.rows[k], &run.signals[k])) {
        let values = std::iter::once(&row[0]).chain(signals).map(ToString::to_string);
        text += &values.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Derivatives of the columns by the constants (SI) over the times of the run.
pub fn sensitivities_csv(run: &Run, sensitivities: &Sensitivities) -> String {
    let mut text = "t_s".to_string();
    for column in &sensitivities.columns {
        sensitivities.constants.iter().for_each(|c| text += &format!(",d {column}/d {c}"));
    }
    text.push('\n');
    for (row, sensitivities) in run.rows.iter().zip(&sensitivities.rows) {
        let values = sensitivities.iter().flatten().map(ToString::to_string);
        text += &std::iter::once(row[0].to_string()).chain(values).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Estimated errors of recorded quantities, one line each.
pub fn errors_csv(estimate: &ErrorEstimate) -> String {
    let mut text = "quantity,t_s,value,enriched,geometry,corrected,uncertainty,bar\n".to_string();
    for q in &estimate.quantities {
        let geometry = q.geometry.map_or_else(String::new, |g| g.change.to_string());
        let (t, value, enriched, corrected) = (q.t, q.value, q.enriched, q.corrected);
        text += &format!("{},{t},{value},{enriched},{geometry},{corrected},{},{}\n", q.column, q.uncertainty, q.bar);
    }
    text
}

/// The meshes of a refinement, one line each.
pub fn refinement_csv(steps: &[RefinementStep]) -> String {
    let mut text = "cells,dofs,t_s,value,enriched,corrected,uncertainty,bar,tolerance,wall_s,cpu_s\n".to_string();
    for RefinementStep { cells, dofs, error: q, tolerance, wall, cpu } in steps {
        let numbers = [q.t, q.value, q.enriched, q.corrected, q.uncertainty, q.bar, *tolerance, *wall, *cpu];
        text += &format!("{cells},{dofs},{}\n", numbers.map(|number| number.to_string()).join(","));
    }
    text
}

/// The recorded rows; numbers in the shortest form that reads back the same.
pub fn csv(run: &Run) -> String {
    let mut text = run.columns.join(",") + "\n";
    for row in run.written.iter().map(|&k| &run.rows[k]) {
        for (k, value) in row.iter().enumerate() {
            write!(text, "{}{value}", if k > 0 { "," } else { "" }).expect("writing to a string cannot fail");
        }
        text.push('\n');
    }
    text
}

fn json<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_string_pretty(value).expect("numbers and string keys only") + "\n"
}

/// The file appears whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), StoreError> {
    replace(path, text.as_bytes())
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    storage::write(path, bytes).map_err(|e| StoreError { path: path.into(), reason: e.to_string() })
}
