//! Files of a case on disk. The record is written last: with it the case counts as done.

use crate::calibrate::inverse::Calibration;
use crate::report::table::quoted;
use crate::scene::{ErrorEstimate, RefinementStep, Run, Scene, Sensitivities};
use crate::storage::{self, DATA_LIMIT};
use crate::study::identity::{FileDigest, Identity};
use crate::study::record::{CaseRecord, SCHEMA, StudyRecord};
use crate::study::skin::Skin;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The folder of results cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("{}: cannot be written: {reason}; choose another folder with --out, or make room", path.display())]
    Unwritable { path: PathBuf, reason: String },
    #[error(
        "{}: a newer version of this program has written it (schema {found}, known are those up to {SCHEMA}); use that version, or \
         choose another folder with --out", path.display()
    )]
    Newer { path: PathBuf, found: u32 },
}

/// The stored result of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Stored {
    Nothing,
    /// The record, and the files that were stored with it are those
    Sound(Box<CaseRecord>),
    /// Why it cannot be used
    Damaged(String),
}

/// Age from which a half-written file is one that a killed writer has left.
const LEFT: Duration = Duration::from_secs(600);

/// The folder of a study's results.
#[derive(Clone, Debug)]
pub struct Store {
    pub dir: PathBuf,
}

impl Store {
    /// Makes the folder, or opens one that is there.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        let store = Self { dir: dir.into() };
        let cases = dir.join("cases");
        std::fs::create_dir_all(&cases).map_err(|e| unwritable(&cases, &e))?;
        let path = dir.join("study.json");
        match storage::read(&path, DATA_LIMIT).ok().and_then(|bytes| serde_json::from_slice::<Schema>(&bytes).ok()) {
            Some(Schema { schema: found }) if found > SCHEMA => Err(StoreError::Newer { path, found }),
            _ => Ok(store),
        }
    }

    /// Writes `study.json`, unless it says the same already.
    pub fn describe(&self, study: &StudyRecord) -> Result<(), StoreError> {
        let path = self.dir.join("study.json");
        let text = json(study).map_err(|reason| StoreError::Unwritable { path: path.clone(), reason })?;
        let same = storage::read(&path, DATA_LIMIT).is_ok_and(|bytes| bytes == text.as_bytes());
        if same { Ok(()) } else { write(&path, &text) }
    }

    /// Removes what writers left behind that were killed. What is young may be that of a run which begins at this moment.
    pub fn sweep(&self) {
        for folder in ["", "cases", "runs", "locks"].map(|name| self.dir.join(name)) {
            for file in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let name = file.file_name();
                let name = name.to_string_lossy();
                let changed = file.metadata().and_then(|m| m.modified()).ok();
                let is_old = changed.and_then(|t| t.elapsed().ok()).is_some_and(|age| age > LEFT);
                if is_old && name.starts_with('.') && name.ends_with(".part") {
                    std::fs::remove_file(file.path()).ok();
                }
            }
        }
    }

    /// The folder of results that another process has made.
    pub fn at(dir: &Path) -> Self {
        Self { dir: dir.into() }
    }

    /// The stored record of a case, with the check that its files are those that were stored with it.
    pub fn look(&self, id: &str) -> Result<Stored, StoreError> {
        let path = self.path(id, "json");
        let bytes = match storage::read(&path, DATA_LIMIT) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Stored::Nothing),
            Err(e) => return Ok(Stored::Damaged(format!("{id}.json: {e}"))),
        };
        let record: CaseRecord = match serde_json::from_slice(&bytes) {
            Ok(record) => record,
            Err(e) => match serde_json::from_slice::<SchemaOfRecord>(&bytes) {
                Ok(SchemaOfRecord { provenance: Schema { schema: found } }) if found > SCHEMA => {
                    return Err(StoreError::Newer { path, found });
                }
                _ => return Ok(Stored::Damaged(format!("{id}.json: {e}"))),
            },
        };
        let found = record.provenance.schema;
        if found > SCHEMA {
            return Err(StoreError::Newer { path, found });
        }
        for FileDigest { file, sha256 } in &record.provenance.results {
            match storage::read(&self.dir.join("cases").join(file), DATA_LIMIT) {
                Ok(bytes) if storage::sha256(&bytes) == *sha256 => {}
                Ok(_) => return Ok(Stored::Damaged(format!("{file} is not what was stored with {id}.json"))),
                Err(e) => return Ok(Stored::Damaged(format!("{file}: {e}"))),
            }
        }
        Ok(Stored::Sound(Box::new(record)))
    }

    /// The stored record of a case, if it is sound.
    pub fn record(&self, id: &str) -> Option<CaseRecord> {
        match self.look(id) {
            Ok(Stored::Sound(record)) => Some(*record),
            _ => None,
        }
    }

    /// Sets a damaged result aside as `cases/<id>.damaged-1.json` and so on; the name of the record.
    pub fn set_aside(&self, id: &str) -> Result<String, StoreError> {
        let free = |n: &usize| !self.path(id, &format!("damaged-{n}.json")).exists();
        let number = (1..).find(free).expect("there is always a next number");
        for extension in ["csv", "skin.json.gz", "fit.json", "sensitivities.csv", "json"] {
            let (from, to) = (self.path(id, extension), self.path(id, &format!("damaged-{number}.{extension}")));
            match std::fs::rename(&from, &to) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(unwritable(&from, &e)),
                _ => {}
            }
        }
        Ok(format!("cases/{id}.damaged-{number}.json"))
    }

    /// The stored record of this case no longer counts where it has another identity: a report must not mix them. The time
    /// series stays.
    pub fn forget_outdated(&self, id: &str, identity: &Identity) -> Result<(), StoreError> {
        match self.record(id).is_some_and(|r| r.provenance.identity == *identity) {
            true => Ok(()),
            false => self.forget(id),
        }
    }

    /// Removes the record of a case, if there is one: the case counts as not done.
    pub fn forget(&self, id: &str) -> Result<(), StoreError> {
        let path = self.path(id, "json");
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(unwritable(&path, &e)),
            _ => Ok(()),
        }
    }

    /// Whether there is a record of this case, sound or not.
    pub fn has(&self, id: &str) -> bool {
        self.path(id, "json").is_file()
    }

    /// Time series, surface, then the record with the digests of both. An earlier record goes first: it does not belong to the new files.
    pub fn save(&self, record: &mut CaseRecord, run: &Run, skin: &Skin) -> Result<(), StoreError> {
        self.forget(&record.id)?;
        (record.provenance.schema, record.provenance.results) = (SCHEMA, vec![]);
        for (extension, bytes) in [("csv", csv(run).into_bytes()), ("skin.json.gz", skin.packed())] {
            replace(&self.path(&record.id, extension), &bytes)?;
            let digest = FileDigest { file: format!("{}.{extension}", record.id), sha256: storage::sha256(bytes) };
            record.provenance.results.push(digest);
        }
        write_json(&self.path(&record.id, "json"), record)
    }

    /// The record of a case that has no run.
    pub fn save_refused(&self, record: &CaseRecord) -> Result<(), StoreError> {
        self.forget(&record.id)?;
        write(&self.path(&record.id, "csv"), "t_s\n")?;
        std::fs::remove_file(self.path(&record.id, "skin.json.gz")).ok();
        write_json(&self.path(&record.id, "json"), record)
    }

    /// Saves the result of a case of a calibration.
    pub fn save_calibration(&self, id: &str, found: &Calibration) -> Result<(), StoreError> {
        write_json(&self.path(id, "fit.json"), found)
    }

    /// The saved result of a case of a calibration, if there is one.
    pub fn calibration(&self, id: &str) -> Option<Calibration> {
        serde_json::from_slice(&storage::read(&self.path(id, "fit.json"), DATA_LIMIT).ok()?).ok()
    }

    pub fn save_sensitivities(&self, id: &str, run: &Run, sensitivities: &Sensitivities) -> Result<(), StoreError> {
        write(&self.path(id, "sensitivities.csv"), &sensitivities_csv(run, sensitivities))
    }

    /// The collection of the fields of a case; it is there when all of them are.
    pub fn collection(&self, id: &str) -> PathBuf {
        self.dir.join("cases").join(id).join(format!("{id}.pvd"))
    }

    /// Folder of a case's own files, made if need be.
    pub fn folder(&self, id: &str) -> Result<PathBuf, StoreError> {
        let path = self.dir.join("cases").join(id);
        match std::fs::create_dir_all(&path) {
            Ok(()) => Ok(path),
            Err(e) => Err(unwritable(&path, &e)),
        }
    }

    fn path(&self, id: &str, extension: &str) -> PathBuf {
        self.dir.join("cases").join(format!("{id}.{extension}"))
    }
}

/// The prescribed signals on the time grid of the run.
pub fn signals_csv(scene: &Scene, run: &Run) -> String {
    let mut text = header(std::iter::once("t_s".to_string()).chain(scene.signals.iter().map(|s| s.name.clone())));
    for (row, signals) in run.written.iter().map(|&k| (&run.rows[k], &run.signals[k])) {
        let values = std::iter::once(&row[0]).chain(signals).map(ToString::to_string);
        text += &values.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Derivatives of the columns by the constants (SI) over the times of the run.
pub fn sensitivities_csv(run: &Run, sensitivities: &Sensitivities) -> String {
    let by_constants = |column: &String| {
        let of = |c| format!("d {column}/d {c}");
        sensitivities.constants.iter().map(of).collect::<Vec<_>>()
    };
    let names = sensitivities.columns.iter().flat_map(by_constants);
    let mut text = header(std::iter::once("t_s".to_string()).chain(names));
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
        let column = quoted(&q.column);
        text += &format!("{column},{t},{value},{enriched},{geometry},{corrected},{},{}\n", q.uncertainty, q.bar);
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
    let mut text = header(run.columns.iter().cloned());
    run.written.iter().for_each(|&k| text += &line(&run.rows[k]));
    text
}

/// A row as a line.
pub(super) fn line(row: &[f64]) -> String {
    let mut text = String::new();
    for (k, value) in row.iter().enumerate() {
        write!(text, "{}{value}", if k > 0 { "," } else { "" }).expect("writing to a string cannot fail");
    }
    text + "\n"
}

/// The first line of a table: names are written as text, whatever they hold.
pub(super) fn header(names: impl Iterator<Item = String>) -> String {
    names.map(|name| quoted(&name)).collect::<Vec<_>>().join(",") + "\n"
}

/// Writes a value as JSON. Nothing that cannot be read again is kept, such as a number that is not finite.
fn write_json<T: Serialize + DeserializeOwned>(path: &Path, value: &T) -> Result<(), StoreError> {
    write(path, &json(value).map_err(|reason| StoreError::Unwritable { path: path.into(), reason })?)
}

/// A value as JSON that can be read again.
pub fn json<T: Serialize + DeserializeOwned>(value: &T) -> Result<String, String> {
    let text = serde_json::to_string_pretty(value).expect("numbers and string keys only") + "\n";
    match serde_json::from_str::<T>(&text) {
        Ok(_) => Ok(text),
        Err(e) => Err(format!("it holds what no reader takes ({e}); please report the scene")),
    }
}

/// The file appears whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), StoreError> {
    replace(path, text.as_bytes())
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    storage::write(path, bytes).map_err(|e| unwritable(path, &e))
}

pub(super) fn unwritable(path: &Path, e: &std::io::Error) -> StoreError {
    StoreError::Unwritable { path: path.into(), reason: e.to_string() }
}

/// The part of a file that says which version wrote it; readable whatever else has changed.
#[derive(Deserialize)]
struct Schema {
    #[serde(default)]
    schema: u32,
}

#[derive(Deserialize)]
struct SchemaOfRecord {
    provenance: Schema,
}
