//! The folder `cases/<id>` with the fields of a case for ParaView, and the result to which they belong.

use crate::storage::{self, TEXT_LIMIT};
use crate::study::store::identity::{Build, Identity};
use crate::study::store::placing::Unwritten;
use crate::study::store::record::CaseRecord;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Name of the file with the origin of the fields, which is written last.
const ORIGIN: &str = "computed-from.json";
/// Name of the fields of the last state of a run that did not reach its end.
pub const LAST: &str = "last";

/// The inputs and the build from which fields were computed.
#[derive(Serialize, Deserialize, PartialEq)]
struct Origin {
    identity_sha256: String,
    build: Build,
}

/// Prepares the folder for the fields of a case: creates it if necessary, and removes the fields of an earlier run.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn begin(dir: &Path, id: &str) -> Result<PathBuf, Unwritten> {
    let folder = folder(dir, id);
    match std::fs::create_dir_all(&folder).and_then(|()| remove_all(dir, id)) {
        Ok(()) => Ok(folder),
        Err(e) => Err((folder, e)),
    }
}

/// Notes that the fields of a case are complete, with the inputs from which this program computed them.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn end(dir: &Path, id: &str, identity: &Identity) -> Result<(), Unwritten> {
    let path = folder(dir, id).join(ORIGIN);
    let origin = Origin { identity_sha256: identity.sha256.clone(), build: Build::this() };
    let text = serde_json::to_string_pretty(&origin).expect("strings only") + "\n";
    storage::write(&path, text.as_bytes()).map_err(|e| (path, e))
}

/// Whether the fields of all states of this result exist.
pub fn is_whole(dir: &Path, record: &CaseRecord) -> bool {
    is_of(dir, record) && folder(dir, &record.id).join(format!("{}.pvd", record.id)).is_file()
}

/// Removes the fields of a case that do not belong to its result.
///
/// # Errors
///
/// A folder that cannot be written.
pub fn remove_others(dir: &Path, record: &CaseRecord) -> Result<(), Unwritten> {
    let folder = folder(dir, &record.id);
    if !folder.is_dir() || is_of(dir, record) {
        return Ok(());
    }
    remove_all(dir, &record.id).map_err(|e| (folder.clone(), e))?;
    // Remains if it contains other files
    std::fs::remove_dir(&folder).ok();
    Ok(())
}

fn folder(dir: &Path, id: &str) -> PathBuf {
    dir.join("cases").join(id)
}

/// Whether the noted origin of the fields is this result.
fn is_of(dir: &Path, record: &CaseRecord) -> bool {
    let own = &record.provenance;
    origin(dir, &record.id).is_some_and(|of| of.identity_sha256 == own.identity.sha256 && of.build == own.build)
}

fn origin(dir: &Path, id: &str) -> Option<Origin> {
    let bytes = storage::read(&folder(dir, id).join(ORIGIN), TEXT_LIMIT).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Whether the folder of a case contains fields whose origin this program has noted.
pub fn has_origin(dir: &Path, id: &str) -> bool {
    origin(dir, id).is_some()
}

/// The names of files in the folder of a case: those of fields, the origin first, and all others.
pub fn names(dir: &Path, id: &str) -> (Vec<String>, Vec<String>) {
    let of = |name: &str, base: &str| {
        let rest = name.strip_prefix(base);
        rest.is_some_and(|rest| {
            rest == ".pvd" || rest.starts_with('-') && (rest.ends_with(".vtu") || rest.ends_with(".pvd"))
        })
    };
    let entries = std::fs::read_dir(folder(dir, id)).into_iter().flatten().flatten();
    let all = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let (mut fields, mut others): (Vec<String>, Vec<String>) =
        all.partition(|name| name == ORIGIN || of(name, id) || of(name, LAST));
    fields.sort_by_key(|name| (name != ORIGIN, name.clone()));
    others.sort();
    (fields, others)
}

/// Removes the fields of a case, their origin first: without it they belong to no result.
fn remove_all(dir: &Path, id: &str) -> std::io::Result<()> {
    names(dir, id).0.iter().try_for_each(|name| match std::fs::remove_file(folder(dir, id).join(name)) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    })
}
