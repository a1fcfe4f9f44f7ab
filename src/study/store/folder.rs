//! Files of a case on disk. The record is written last: with it the case counts as done.

use crate::calibrate::inverse::Calibration;
use crate::scene::{FileDigest, Run, Sensitivities};
use crate::storage::{self, DATA_LIMIT};
use crate::study::store::case_files::{ENDS, OUTDATED, PAGE, SEARCH, STATES, check_in};
use crate::study::store::csv_text;
use crate::study::store::identity::Identity;
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
    /// The record, and the files that were stored with it are those
    Sound(Box<CaseRecord>),
    /// Why it cannot be used
    Damaged(String),
}

/// The results of a case that its record does not hold.
pub struct CaseOutput<'a> {
    pub run: &'a Run,
    pub skin: &'a Skin,
    pub sensitivities: Option<&'a Sensitivities>,
    pub calibration: Option<&'a Calibration>,
    /// The page that shows the motion, where the scene records it
    pub page: Option<&'a str>,
    /// The states, where the study keeps them
    pub states: Option<&'a KeptStates>,
}

/// End of the name of a file, and its contents; none where there is no such file.
type NamedFile = (&'static str, Option<Vec<u8>>);

impl CaseOutput<'_> {
    /// The files, or the end of the name of one that could not be read again, and why.
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
        for folder in ["", "cases", "runs", "locks", OUTDATED].map(|name| self.dir.join(name)) {
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
        for extension in ENDS {
            let (from, to) = (self.path(id, extension), self.path(id, &format!("damaged-{number}.{extension}")));
            match std::fs::rename(&from, &to) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(unwritable(&from, &e)),
                _ => {}
            }
        }
        Ok(format!("cases/{id}.damaged-{number}.json"))
    }

    /// Removes the record of a case, if there is one: the case counts as not done.
    fn forget(&self, id: &str) -> Result<(), StoreError> {
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

    /// Writes the files of a case, then its record with the digests of all. An earlier record goes first: it does not belong to the new
    /// files. What an earlier result had and this one has not goes too.
    pub fn save(&self, record: &mut CaseRecord, outcome: &CaseOutput) -> Result<(), StoreError> {
        self.forget(&record.id)?;
        (record.provenance.schema, record.provenance.results) = (SCHEMA, vec![]);
        for (end, bytes) in outcome.files().map_err(|(end, reason)| self.unwritable(&record.id, end, reason))? {
            let path = self.path(&record.id, end);
            let Some(bytes) = bytes else {
                std::fs::remove_file(&path).ok();
                continue;
            };
            storage::write(&path, &bytes).map_err(|e| unwritable(&path, &e))?;
            let digest = FileDigest { file: format!("{}.{end}", record.id), sha256: storage::sha256(bytes) };
            record.provenance.results.push(digest);
        }
        self.write_record(record)?;
        // Its search came to its end, or says itself where it goes on
        std::fs::remove_file(self.path(&record.id, SEARCH)).ok();
        Ok(())
    }

    /// Keeps the best values of a search so far, so that one that is stopped goes on there.
    pub fn keep_search(&self, id: &str, identity: &Identity, values: &[f64]) -> Result<(), StoreError> {
        let kept = SearchSoFar { identity: identity.clone(), values: values.to_vec() };
        let text = json(&kept).map_err(|reason| self.unwritable(id, SEARCH, reason))?;
        write(&self.path(id, SEARCH), &text)
    }

    /// The values that were kept of a search of the same inputs.
    pub fn search(&self, id: &str, identity: &Identity) -> Option<Vec<f64>> {
        let bytes = storage::read(&self.path(id, SEARCH), DATA_LIMIT).ok()?;
        let kept: SearchSoFar = serde_json::from_slice(&bytes).ok()?;
        (kept.identity == *identity).then_some(kept.values)
    }

    /// Writes a record with its own digest.
    fn write_record(&self, record: &CaseRecord) -> Result<(), StoreError> {
        let text = json(record).map_err(|reason| self.unwritable(&record.id, "json", reason))?;
        write(&self.path(&record.id, "json"), &seal::sealed(&text))
    }

    fn unwritable(&self, id: &str, end: &str, reason: String) -> StoreError {
        StoreError::Unwritable { path: self.path(id, end), reason }
    }

    /// The record of a case that has no run.
    pub fn save_refused(&self, record: &CaseRecord) -> Result<(), StoreError> {
        self.forget(&record.id)?;
        write(&self.path(&record.id, "csv"), "t_s\n")?;
        for end in ["skin.json.gz", "fit.json", "sensitivities.csv", PAGE, STATES] {
            std::fs::remove_file(self.path(&record.id, end)).ok();
        }
        self.write_record(record)
    }

    /// The saved result of a case of a calibration, if there is one.
    pub fn calibration(&self, id: &str) -> Option<Calibration> {
        serde_json::from_slice(&storage::read(&self.path(id, "fit.json"), DATA_LIMIT).ok()?).ok()
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

/// A value as JSON. Nothing that cannot be read again is kept, such as a number that is not finite.
pub fn json<T: Serialize + DeserializeOwned>(value: &T) -> Result<String, String> {
    let text = serde_json::to_string_pretty(value).expect("numbers and string keys only") + "\n";
    match serde_json::from_slice::<T>(text.as_bytes()) {
        Ok(_) => Ok(text),
        Err(e) => Err(format!("it holds what no reader takes ({e}); please report the scene")),
    }
}

/// The file appears whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), StoreError> {
    storage::write(path, text.as_bytes()).map_err(|e| unwritable(path, &e))
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
