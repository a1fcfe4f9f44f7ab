//! Checks whether a run would replace the results of another study or of another command.

use crate::storage::results;
use crate::study::expand::Study;
use crate::study::store::case_files;
use crate::study::store::origin;
use crate::study::store::record::StudyRecord;
use std::path::{Path, PathBuf};

/// Reason why a folder does not accept the results of a study.
#[derive(Debug, thiserror::Error)]
pub enum HeldError {
    #[error("{}: holds {own}; choose another folder with --out", dir.display())]
    Command { dir: PathBuf, own: String },
    #[error(
        "{}: it holds results of {}, which has the same name; choose another folder with --out, rename one of the two, or remove this folder",
        dir.display(), other.display()
    )]
    SameName { dir: PathBuf, other: PathBuf },
    #[error(
        "{}: it holds results of {other}, which those of {} would replace; choose another folder with --out, or remove this one",
        dir.display(), file.display()
    )]
    Study { dir: PathBuf, other: String, file: PathBuf },
}

/// Refuses a folder with the results of another command and, if it is the `usual` folder for the study in this file, also one with the results of
/// another study of the same name.
///
/// # Errors
///
/// A folder with such results.
pub fn check_folder(dir: &Path, file: &Path, usual: bool) -> Result<(), HeldError> {
    if let Some(own) = results::held(dir) {
        return Err(HeldError::Command { dir: dir.into(), own });
    }
    match origin::other(dir, file).filter(|_| usual) {
        Some(other) => Err(HeldError::SameName { dir: dir.into(), other }),
        None => Ok(()),
    }
}

/// Refuses a folder with results of another study, which the run would replace.
///
/// # Errors
///
/// A folder with such results.
pub fn check(study: &Study, dir: &Path) -> Result<(), HeldError> {
    match held(study, dir) {
        Some(other) => Err(HeldError::Study { dir: dir.into(), other, file: study.file.clone() }),
        None => Ok(()),
    }
}

/// The other study whose results `dir` holds: its file, or its name if the file is not known. Returns `None` for the same study, including a moved or
/// copied study file.
fn held(study: &Study, dir: &Path) -> Option<String> {
    let stored = case_files::study(dir).ok()?;
    let has_other_name = stored.study != study.record.study;
    match origin::other(dir, &study.file) {
        Some(file) => (has_other_name || !has_cases_of(study, &stored)).then(|| file.display().to_string()),
        None if dir.join(origin::FILE).is_file() => None,
        None => has_other_name.then(|| format!("the study {}", stored.study)),
    }
}

/// Whether the stored study shares cases with this one, all with the same inputs; true for a study of an earlier version, which does not store its
/// inputs.
fn has_cases_of(study: &Study, stored: &StudyRecord) -> bool {
    let shared = study.cases.iter().filter_map(|case| Some((case, stored.inputs_sha256.get(&case.id)?)));
    let mut is_same = shared.map(|(case, inputs)| case.identity(&[]).inputs_sha256 == *inputs).peekable();
    stored.inputs_sha256.is_empty() || is_same.peek().is_some() && is_same.all(|is_same| is_same)
}
