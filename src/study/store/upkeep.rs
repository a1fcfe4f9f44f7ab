//! Upkeep of a folder of results: verifies all digests, and removes what no case uses.

use crate::storage::{self, TEXT_LIMIT};
use crate::study::store::case_files::{
    CaseFiles, FolderError, OUTDATED, SEARCH, Unsound, check_in, ids, sealed_record, study,
};
use crate::study::store::field_folder;
use crate::study::store::lock::{Owner, SILENT};
use crate::study::store::names::{NEXT, is_part};
use crate::study::store::placing::pending;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Result of a verification.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Verified {
    /// Number of cases whose files are all those that were stored
    pub sound: usize,
    /// Cases of the study without a record
    pub missing: Vec<String>,
    /// Files that are damaged
    pub damaged: Vec<Unsound>,
}

/// Verifies the digests of all results in a folder.
pub fn verify(dir: &Path) -> Result<Verified, FolderError> {
    let study = study(dir)?;
    let known = ids(&study);
    let files = CaseFiles::read(dir, &known)?;
    let has_record = |id: &&str| files.of_cases.get(*id).is_some_and(|ends| ends.contains("json"));
    let (recorded, missing): (Vec<&str>, Vec<&str>) = known.into_iter().partition(has_record);
    let missing = missing.into_iter().map(String::from).collect();
    let mut out = Verified { sound: 0, missing, damaged: vec![] };
    for id in recorded {
        match check_in(dir, id) {
            Ok(_) => out.sound += 1,
            Err(wrong) => out.damaged.extend(wrong),
        }
    }
    Ok(out)
}

/// Files that were removed, or would be, and those that are kept.
#[derive(Serialize, Clone, Debug, PartialEq, Default)]
pub struct Cleaned {
    pub removed: Vec<Removed>,
    /// Files and folders that this program does not know, relative to the folder of the results; they are kept
    pub unknown: Vec<String>,
}

/// A file or folder that nothing uses.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Removed {
    /// Path relative to the folder of the results
    pub file: String,
    pub bytes: u64,
    pub why: &'static str,
}

/// A file that cannot be removed, or a folder that cannot be cleaned.
#[derive(Debug, thiserror::Error)]
pub enum CleanError {
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error("{}: it cannot be removed: {reason}", path.display())]
    Kept { path: PathBuf, reason: String },
}

/// Age of the sign of life at which a run counts as dead, however small the age limit for removing files.
const DEAD: Duration = Duration::from_secs(2 * SILENT.as_secs());

/// Removes files that belong to no case of the study, and files left by killed runs that have not changed for `age`. With `dry` they are only listed.
pub fn clean(dir: &Path, age: Duration, dry: bool) -> Result<Cleaned, CleanError> {
    let study = study(dir)?;
    let known = ids(&study);
    let files = CaseFiles::read(dir, &known)?;
    let mut out = Cleaned::default();
    for (id, ends) in files.of_cases.iter().filter(|(id, _)| !known.contains(id.as_str())) {
        let own = own_ends(dir, id, ends);
        let set_aside = damaged(id).is_some_and(|id| known.contains(id));
        let why = if set_aside { "damaged result that was set aside" } else { "it belongs to no case of the study" };
        for end in ends {
            let file = format!("cases/{id}.{end}");
            match own.contains(end) {
                true => out.removed.push(removed(dir, file, why)),
                false => out.unknown.push(file),
            }
        }
    }
    for name in files.others.into_iter().filter(|name| !is_part(name)) {
        clean_folder(dir, &name, (&known, files.of_cases.contains_key(&name)), &mut out);
    }
    for id in pending(dir).into_iter().filter(|id| is_older(&dir.join(NEXT).join(id), age)) {
        out.removed.push(removed(dir, format!("{NEXT}/{id}"), "half-written result of a run that was killed"));
    }
    for folder in ["", "cases/", "runs/", "locks/", "outdated/"] {
        let parts =
            names(&dir.join(folder)).into_iter().filter(|name| is_part(name)).map(|name| format!("{folder}{name}"));
        let old = parts.filter(|file| is_older(&dir.join(file), age));
        out.removed.extend(old.map(|file| removed(dir, file, "half-written file of a run that was killed")));
    }
    let notes = names(&dir.join(OUTDATED)).into_iter().filter(|id| !is_part(id) && !known.contains(id.as_str()));
    let notes = notes.map(|id| removed(dir, format!("{OUTDATED}/{id}"), "it belongs to no case of the study"));
    out.removed.extend(notes);
    out.removed.extend(left_locks(dir, age.max(DEAD)));
    out.removed.sort_by(|a, b| a.file.cmp(&b.file));
    for removed in out.removed.iter().filter(|_| !dry) {
        let path = dir.join(&removed.file);
        let result = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        match result {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(CleanError::Kept { path, reason: e.to_string() });
            }
            _ => {}
        }
    }
    Ok(out)
}

/// The id of the case of which a damaged result was set aside under this name.
fn damaged(id: &str) -> Option<&str> {
    let (id, number) = id.rsplit_once(".damaged-")?;
    (!number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())).then_some(id)
}

/// The suffixes of those files of this name that a run has stored: its record names them. Other files may belong to the user.
fn own_ends(dir: &Path, id: &str, ends: &BTreeSet<&'static str>) -> BTreeSet<&'static str> {
    if damaged(id).is_some() {
        return ends.clone();
    }
    let Some(record) = sealed_record(dir, id) else { return BTreeSet::new() };
    let files = record.provenance.results;
    let is_named = |end: &str| files.is_empty() || files.iter().any(|file| file.file == format!("{id}.{end}"));
    ends.iter().filter(|end| ["json", SEARCH].contains(end) || is_named(end)).copied().collect()
}

/// Checks a folder among the cases: fields that belong to no case of the study are removed, other files are kept.
fn clean_folder(dir: &Path, name: &str, (known, has_files): (&BTreeSet<&str>, bool), out: &mut Cleaned) {
    let (fields, others) = field_folder::names(dir, name);
    let folder = format!("cases/{name}");
    let is_own = field_folder::has_origin(dir, name) || has_files && sealed_record(dir, name).is_some();
    let why = "fields that belong to no case of the study";
    match (known.contains(name) && !fields.is_empty(), is_own, others.is_empty()) {
        (true, _, _) => {}
        (false, true, true) => out.removed.push(removed(dir, folder, why)),
        (false, true, false) => {
            out.removed.extend(fields.iter().map(|file| removed(dir, format!("{folder}/{file}"), why)));
            out.unknown.extend(others.iter().map(|file| format!("{folder}/{file}")));
        }
        (false, false, _) => out.unknown.push(folder),
    }
}

/// Runs without a sign of life, and the locks that they hold.
fn left_locks(dir: &Path, age: Duration) -> Vec<Removed> {
    let of = |folder: &str| names(&dir.join(folder)).into_iter().filter(|name| !is_part(name)).collect::<Vec<_>>();
    let (dead, alive): (Vec<String>, Vec<String>) =
        of("runs").into_iter().partition(|name| is_older(&dir.join("runs").join(name), age));
    let alive: BTreeSet<&str> = alive.iter().filter_map(|name| name.strip_suffix(".json")).collect();
    let held = |name: &String| {
        let path = dir.join("locks").join(name);
        let owner = storage::read(&path, TEXT_LIMIT).ok().and_then(|b| serde_json::from_slice::<Owner>(&b).ok());
        owner.map_or_else(|| !is_older(&path, age), |owner| alive.contains(owner.name.as_str()))
    };
    let locks = of("locks").into_iter().filter(|name| !held(name));
    let dead = dead.into_iter().map(|name| removed(dir, format!("runs/{name}"), "run that was killed"));
    dead.chain(locks.map(|name| removed(dir, format!("locks/{name}"), "lock of a run that was killed"))).collect()
}

fn removed(dir: &Path, file: String, why: &'static str) -> Removed {
    Removed { bytes: size(&dir.join(&file)), file, why }
}

/// Names in a folder; empty if there is no such folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
}

/// Whether a file is older than `age`. A file without a time counts as young and is not removed.
fn is_older(path: &Path, age: Duration) -> bool {
    let changed = std::fs::metadata(path).and_then(|m| m.modified());
    changed.is_ok_and(|t| SystemTime::now().duration_since(t).is_ok_and(|since| since >= age))
}

/// Size of a file, or of all files in a folder \[bytes\].
fn size(path: &Path) -> u64 {
    match std::fs::symlink_metadata(path) {
        Ok(m) if m.is_dir() => std::fs::read_dir(path).into_iter().flatten().flatten().map(|e| size(&e.path())).sum(),
        Ok(m) => m.len(),
        Err(_) => 0,
    }
}
