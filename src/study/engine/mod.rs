//! The files with which a scheduler runs a study, and their submission. The cases run as with `durometer run --batch`; an engine only decides where and
//! when.
//!
//! | File in `<results>/engine/` | Content |
//! |---|---|
//! | `batches-<digest>.txt` | the ids of the cases of each task, one task per line ([`batches`]) |
//! | `*.sbatch`, `jobs.toml` | input of [`slurm`] and [`hyperqueue`] |
//! | `logs/` | the output of the tasks |
//!
//! A lost task can safely be run again: existing results are kept. Cases with an up-to-date result are not in any batch.

pub mod batches;
pub mod hyperqueue;
pub mod slurm;

use crate::storage::{self, sha256};
use crate::study::engine::batches::Group;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An engine that is missing, or refuses the study.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error("{engine}: the program {program} is not found; {remedy}")]
    Missing { engine: &'static str, program: String, remedy: &'static str },
    #[error("{engine} does not take {what}: {reason}")]
    Refused { engine: &'static str, what: String, reason: String },
    #[error("{}: it cannot be written: {reason}; choose another folder with --out, or make room", path.display())]
    Unwritable { path: PathBuf, reason: String },
    #[error("{what} has a line break, which ends a line of the files of an engine; remove it")]
    LineBreak { what: String },
}

/// A study that an engine is to run.
#[derive(Clone, Debug)]
pub struct Submission {
    /// Name of the study
    pub study: String,
    /// Folder of the results, absolute
    pub dir: PathBuf,
    /// Folder in which the tasks run, absolute
    pub folder: PathBuf,
    /// Program and arguments of a run, to which `--batch FILE:K` is added
    pub run: Vec<String>,
    /// Program and arguments that write the report
    pub report: Vec<String>,
    pub groups: Vec<Group>,
    /// Memory for the list of all cases, which every task reads \[bytes\]
    pub list_bytes: u64,
    pub requests: Requests,
}

/// Resources that tasks request from a scheduler.
#[derive(Clone, Debug)]
pub struct Requests {
    /// Ratio of requested to expected time
    pub time_factor: f64,
    /// Ratio of requested to expected memory; 0 requests none
    pub memory_factor: f64,
    /// Memory of the report \[bytes\]
    pub report_bytes: u64,
    /// Options of the user: account, partition, quality of service
    pub options: Vec<String>,
    /// Shell lines before each task
    pub before: Vec<String>,
}

/// A file for an engine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EngineFile {
    /// Name of the file in `<results>/engine/`
    pub name: String,
    pub text: String,
}

/// Memory of the program itself, added to the expected memory of a case \[bytes\].
const OWN_BYTES: f64 = 256.0 * 1024.0 * 1024.0;
/// Time added to every request for start-up, meshes and files \[s\].
const START_S: f64 = 300.0;

impl Submission {
    /// The folder `<results>/engine`.
    pub fn place(&self) -> PathBuf {
        self.dir.join("engine")
    }

    /// Requested time of a task of a group \[s\].
    fn seconds(&self, group: &Group) -> u64 {
        (self.requests.time_factor * group.longest_s() + START_S).ceil() as u64
    }

    /// Requested memory of a task \[MiB\]; `None` if no memory is requested.
    fn mebibytes(&self, bytes: u64) -> Option<u64> {
        let wanted = self.requests.memory_factor * bytes as f64 + OWN_BYTES + self.list_bytes as f64;
        (self.requests.memory_factor > 0.0).then(|| (wanted / (1 << 20) as f64).ceil() as u64)
    }

    /// The shell command that runs a batch; `k` is inserted unquoted.
    fn run_batch(&self, batches: &EngineFile, k: &str) -> String {
        let file = self.place().join(&batches.name);
        format!("{} --batch {}:{k}", shell(&self.run), shell(&[file.to_string_lossy().into_owned()]))
    }

    /// The batches, as a file that no later submission overwrites: waiting tasks may still have to read it.
    fn batches(&self) -> EngineFile {
        let text = batches::text(&self.groups);
        EngineFile { name: format!("batches-{}.txt", &sha256(&text)[..12]), text }
    }

    /// Refuses text with characters that would break a line of a file for an engine.
    fn check(&self) -> Result<(), EngineError> {
        let own = self.run.iter().chain(&self.report).chain(&self.requests.options).chain(&self.requests.before);
        let paths = [&self.dir, &self.folder].map(|p| p.to_string_lossy().into_owned());
        match own.chain(&paths).find(|text| text.contains(['\n', '\r', '\0'])) {
            Some(text) => Err(EngineError::LineBreak { what: format!("{text:?}") }),
            None => Ok(()),
        }
    }

    /// Writes the files of an engine.
    fn write(&self, files: &[EngineFile]) -> Result<(), EngineError> {
        let place = self.place();
        let unwritable =
            |path: &Path, e: std::io::Error| EngineError::Unwritable { path: path.into(), reason: e.to_string() };
        std::fs::create_dir_all(place.join("logs")).map_err(|e| unwritable(&place, e))?;
        for EngineFile { name, text } in files {
            let path = place.join(name);
            storage::write(&path, text.as_bytes()).map_err(|e| unwritable(&path, e))?;
        }
        Ok(())
    }
}

/// Quotes words as a shell command line.
fn shell(words: &[String]) -> String {
    shlex::try_join(words.iter().map(String::as_str)).expect("no word has a zero byte")
}

/// Runs a program of an engine and returns its standard output.
fn output(engine: &'static str, remedy: &'static str, command: &mut Command) -> Result<String, EngineError> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|_| EngineError::Missing { engine, program: program.clone(), remedy })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).trim().to_string());
    }
    let said = String::from_utf8_lossy(&output.stderr).trim().to_string();
    let reason = if said.is_empty() { output.status.to_string() } else { said };
    Err(EngineError::Refused { engine, what: format!("the call of {program}"), reason })
}
