//! Files of a case on disk. A case with a record counts as done.

use crate::calibrate::inverse::Calibration;
use crate::scene::{FileDigest, Run, Sensitivities};
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::store::case_files::{ENDS, OUTDATED, PAGE, SEARCH, STATES, check_in};
use crate::study::store::csv_text;
use crate::study::store::field_folder;
use crate::study::store::identity::Identity;
use crate::study::store::names::{NEXT, is_part};
use crate::study::store::placing::{Unwritten, clear, pending, place, settle_all};
use crate::study::store::record::{CaseRecord, SCHEMA, StudyRecord};
use crate::study::store::seal;
use crate::study::store::skin::Skin;
use crate::study::store::states::KeptStates;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
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
    /// The record; the files stored with it are unchanged
    Sound(Box<CaseRecord>),
    /// Why it cannot be used
    Damaged(String),
}

/// The results of a case besides its record.
pub struct CaseOutput<'a> {
    pub run: &'a Run,
    pub skin: &'a Skin,
    pub sensitivities: Option<&'a Sensitivities>,
    pub calibration: Option<&'a Calibration>,
    /// The page that shows the motion, if the scene records it
    pub page: Option<&'a str>,
    /// The states, if the study keeps them
    pub states: Option<&'a KeptStates>,
}

/// Suffix of a file and its contents; `None` if there is no such file.
type NamedFile = (&'static str, Option<Vec<u8>>);

impl CaseOutput<'_> {
    /// The files to write, or the suffix of one that could not be read back, and why.
    fn files(&self) -> Result<[NamedFile; 6], (&'static str, String)> {
        let calibration = self.calibration.map(json).transpose().map_err(|reason| ("fit.json", reason))?;
        let sensitivities = self.sensitivities.map(|found| csv_text::sensitivities(self.run, found));
        Ok([
            ("csv", Some(csv_text::rows(self.run).into_bytes())),
            ("skin.json.gz", Some(self.skin.packed())),
            ("sensitivities.csv", sensitivities.map(String::into_bytes)),
            ("fit.json", calibration.map(String::into_bytes)),
            (PAGE, self.page.map(|page| page.as_bytes().to_vec())),
            (STATES, self.states.map(KeptStates::to_bytes)),
        ])
    }
}

/// Best values of a search that has no record yet.
#[derive(Serialize, Deserialize)]
struct SearchSoFar {
    identity: Identity,
    values: Vec<f64>,
}

/// Age from which a half-written file is taken to be left by a killed writer.
const LEFT: Duration = Duration::from_secs(600);

/// The folder of the results of a study.
#[derive(Clone, Debug)]
pub struct Store {
    pub dir: PathBuf,
}

impl Store {
    /// Creates the folder, or opens an existing one.
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

    /// Writes `study.json`, unless its content is already the same.
    pub fn describe(&self, study: &StudyRecord) -> Result<(), StoreError> {
        let path = self.dir.join("study.json");
        let text = json(study).map_err(|reason| StoreError::Unwritable { path: path.clone(), reason })?;
        let same = storage::read(&path, DATA_LIMIT).is_ok_and(|bytes| bytes == text.as_bytes());
        if same { Ok(()) } else { write(&path, &text) }
    }

    /// Removes files left by killed writers. Recent ones are kept, since they may belong to a run that is just starting.
    pub fn sweep(&self) {
        settle_all(&self.dir);
        for id in pending(&self.dir).iter().filter(|id| is_left(&self.dir.join(NEXT).join(id))) {
            clear(&self.dir, id);
        }
        for folder in ["", "cases", "runs", "locks", OUTDATED] {
            sweep_parts(&self.dir.join(folder));
        }
    }

    /// Refers to a folder of results that another process has made.
    pub fn at(dir: &Path) -> Self {
        Self { dir: dir.into() }
    }

    /// Reads the stored record of a case and checks that its files are those that were stored with it.
    pub fn look(&self, id: &str) -> Result<Stored, StoreError> {
        let path = self.path(id, "json");
        let bytes = match storage::read(&path, DATA_LIMIT) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Stored::Nothing),
            Err(e) => return Ok(Stored::Damaged(format!("{id}.json: {e}"))),
        };
        match serde_json::from_slice::<SchemaOfRecord>(&bytes) {
            Ok(SchemaOfRecord { provenance: Schema { schema: found } }) if found > SCHEMA => {
                return Err(StoreError::Newer { path, found });
            }
            _ => {}
        }
        Ok(match check_in(&self.dir, id) {
            Ok(record) => Stored::Sound(Box::new(record)),
            Err(wrong) => {
                let words = wrong.iter().map(|file| format!("{}: {}", file.file, file.fact));
                Stored::Damaged(words.collect::<Vec<_>>().join("; "))
            }
        })
    }

    /// The stored record of a case, if it is intact.
    pub fn record(&self, id: &str) -> Option<CaseRecord> {
        match self.look(id) {
            Ok(Stored::Sound(record)) => Some(*record),
            _ => None,
        }
    }

    /// Renames a damaged result to `cases/<id>.damaged-1.json` and so on; returns the name of the record.
    pub fn set_aside(&self, id: &str) -> Result<String, StoreError> {
        let free = |n: &usize| !self.path(id, &format!("damaged-{n}.json")).exists();
        let number = (1..).find(free).expect("there is always a next number");
        for extension in ENDS {
            let (from, to) = (self.path(id, extension), self.path(id, &format!("damaged-{number}.{extension}")));
            match std::fs::rename(&from, &to) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(unwritable(&from, &e)),
                _ => {}
            }
        }
        Ok(format!("cases/{id}.damaged-{number}.json"))
    }

    /// Whether there is a record of this case, intact or not.
    pub fn has(&self, id: &str) -> bool {
        self.path(id, "json").is_file()
    }

    /// Stores the result of a case and replaces an earlier one, of which nothing is lost before the new one is complete.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn save(&self, record: &mut CaseRecord, outcome: &CaseOutput) -> Result<(), StoreError> {
        let files = outcome.files().map_err(|(end, reason)| self.unwritable(&record.id, end, reason))?;
        let files = files.into_iter().filter_map(|(end, bytes)| Some((end, bytes?))).collect();
        self.put(record, files)?;
        // Its search has ended, or its record says where to continue
        std::fs::remove_file(self.path(&record.id, SEARCH)).ok();
        Ok(())
    }

    /// Stores files with a record that contains their digests and its own.
    fn put(&self, record: &mut CaseRecord, mut files: Vec<(&'static str, Vec<u8>)>) -> Result<(), StoreError> {
        let id = record.id.clone();
        let digest = |(end, bytes): &(&str, Vec<u8>)| FileDigest { file: format!("{id}.{end}"), sha256: sha256(bytes) };
        record.provenance.schema = SCHEMA;
        record.provenance.results = files.iter().map(digest).collect();
        record.provenance.record_sha256.clear();
        let text = json(record).map_err(|reason| self.unwritable(&id, "json", reason))?;
        record.provenance.record_sha256 = sha256(&text);
        files.push(("json", seal::sealed(&text).into_bytes()));
        place(&self.dir, &id, &files).and_then(|()| field_folder::remove_others(&self.dir, record)).map_err(unwritten)
    }

    /// Saves the best values of a search so far, so that a stopped search continues from there.
    pub fn keep_search(&self, id: &str, identity: &Identity, values: &[f64]) -> Result<(), StoreError> {
        let kept = SearchSoFar { identity: identity.clone(), values: values.to_vec() };
        let text = json(&kept).map_err(|reason| self.unwritable(id, SEARCH, reason))?;
        write(&self.path(id, SEARCH), &text)
    }

    /// The saved values of a search with the same inputs.
    pub fn search(&self, id: &str, identity: &Identity) -> Option<Vec<f64>> {
        let bytes = storage::read(&self.path(id, SEARCH), DATA_LIMIT).ok()?;
        let kept: SearchSoFar = serde_json::from_slice(&bytes).ok()?;
        (kept.identity == *identity).then_some(kept.values)
    }

    fn unwritable(&self, id: &str, end: &str, reason: String) -> StoreError {
        StoreError::Unwritable { path: self.path(id, end), reason }
    }

    /// Stores the record of a case that has no run. If the computation itself crashed, an earlier result that did not crash is kept, which the record
    /// then says.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written.
    pub fn save_refused(&self, record: &mut CaseRecord) -> Result<(), StoreError> {
        if record.broke() && self.record(&record.id).is_some_and(|earlier| !earlier.broke()) {
            let why = record.status_detail.take().unwrap_or_default();
            record.status_detail = Some(format!("{why}; the earlier result of the case stays"));
            return Ok(());
        }
        self.put(record, vec![("csv", b"t_s\n".to_vec())])
    }

    /// The stored result of a case of a calibration, if there is one.
    pub fn calibration(&self, id: &str) -> Option<Calibration> {
        serde_json::from_slice(&storage::read(&self.path(id, "fit.json"), DATA_LIMIT).ok()?).ok()
    }

    /// Prepares the folder for the fields of a case, without those of an earlier run.
    pub fn begin_fields(&self, id: &str) -> Result<PathBuf, StoreError> {
        field_folder::begin(&self.dir, id).map_err(unwritten)
    }

    /// Notes that the fields of a case are complete, and the inputs from which they were computed.
    pub fn end_fields(&self, id: &str, identity: &Identity) -> Result<(), StoreError> {
        field_folder::end(&self.dir, id, identity).map_err(unwritten)
    }

    /// Whether the fields of all states of this result exist.
    pub fn has_fields(&self, record: &CaseRecord) -> bool {
        field_folder::is_whole(&self.dir, record)
    }

    fn path(&self, id: &str, extension: &str) -> PathBuf {
        self.dir.join("cases").join(format!("{id}.{extension}"))
    }
}

/// Removes the half-written files that killed writers left in a folder.
pub fn sweep_parts(folder: &Path) {
    for file in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_part(&file.file_name().to_string_lossy()) && is_left(&file.path()) {
            std::fs::remove_file(file.path()).ok();
        }
    }
}

/// Whether a file or folder is so old that nobody is still writing it.
fn is_left(path: &Path) -> bool {
    let changed = std::fs::metadata(path).and_then(|m| m.modified()).ok();
    changed.and_then(|t| t.elapsed().ok()).is_some_and(|age| age > LEFT)
}

/// Serialises a value as JSON. Values that cannot be read back, such as non-finite numbers, are an error.
pub fn json<T: Serialize + DeserializeOwned>(value: &T) -> Result<String, String> {
    let text = serde_json::to_string_pretty(value).expect("numbers and string keys only") + "\n";
    match serde_json::from_slice::<T>(text.as_bytes()) {
        Ok(_) => Ok(text),
        Err(e) => Err(format!("it holds what no reader takes ({e}); please report the scene")),
    }
}

/// Writes a file whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), StoreError> {
    storage::write(path, text.as_bytes()).map_err(|e| unwritable(path, &e))
}

/// Converts a file that cannot be written to an error of the folder.
pub fn unwritten((path, e): Unwritten) -> StoreError {
    unwritable(&path, &e)
}

pub(super) fn unwritable(path: &Path, e: &std::io::Error) -> StoreError {
    StoreError::Unwritable { path: path.into(), reason: e.to_string() }
}

/// The part of a file that says which version wrote it; it stays readable whatever else changes.
#[derive(Deserialize)]
struct Schema {
    #[serde(default)]
    schema: u32,
}

#[derive(Deserialize)]
struct SchemaOfRecord {
    provenance: Schema,
}
