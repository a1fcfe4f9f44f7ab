//! Replaces the files of a result by those of a new one, so that one of the two is complete at every moment.
//!
//! The new files are written into a separate folder, `next/<id>`. The new record then replaces the old one: a record names its files by their digests,
//! so that they count from here on. Finally they are moved to `cases/`. If a run is killed before that, whoever opens the case next moves them.

use crate::scene::FileDigest;
use crate::storage::{self, DATA_LIMIT};
use crate::study::store::names::{ENDS, NEXT, SEARCH, is_part};
use serde::Deserialize;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// A file that cannot be written, and why.
pub type Unwritten = (PathBuf, Error);

/// Replaces the files of a case by `files`, `<id>.<suffix>`, which include its record `json` with the digests of the others.
///
/// # Errors
///
/// A folder that cannot be written. Either the earlier result or the new one is complete then.
pub fn place<B: AsRef<[u8]>>(dir: &Path, id: &str, files: &[(&str, B)]) -> Result<(), Unwritten> {
    settle(dir, id);
    let folder = dir.join(NEXT).join(id);
    let written = write(dir, id, files).and_then(|()| {
        let record = format!("{id}.json");
        let (from, to) = (folder.join(&record), dir.join("cases").join(record));
        storage::keep(&from, &to).map_err(|e| (to, e))
    });
    if written.is_err() {
        // The earlier result does not need it
        clear(dir, id);
        return written;
    }
    let others = files.iter().filter(|(end, _)| *end != "json").map(|(end, _)| format!("{id}.{end}"));
    move_files(dir, id, &others.collect::<Vec<_>>())?;
    clear(dir, id);
    Ok(())
}

/// Writes the new files, the record last.
fn write<B: AsRef<[u8]>>(dir: &Path, id: &str, files: &[(&str, B)]) -> Result<(), Unwritten> {
    // A killed run has left files there that belong to no record
    clear(dir, id);
    let folder = dir.join(NEXT).join(id);
    std::fs::create_dir_all(&folder).map_err(|e| (folder.clone(), e))?;
    let (records, others): (Vec<_>, Vec<_>) = files.iter().partition(|(end, _)| *end == "json");
    others.into_iter().chain(records).try_for_each(|(end, bytes)| {
        let path = folder.join(format!("{id}.{end}"));
        storage::write(&path, bytes.as_ref()).map_err(|e| (path, e))
    })
}

/// Moves the files that the record of a case names to their places, if a run was killed before it could. The files of a result whose record is not in
/// its place stay where they are, and so do all files in a folder that cannot be written.
pub fn settle(dir: &Path, id: &str) {
    let folder = dir.join(NEXT).join(id);
    if !folder.is_dir() {
        return;
    }
    let named = named(&dir.join("cases").join(format!("{id}.json")));
    let is_next = |file: &&FileDigest| {
        storage::read(&folder.join(&file.file), DATA_LIMIT).is_ok_and(|bytes| storage::sha256(bytes) == file.sha256)
    };
    let own = named.iter().filter(|file| is_of(id, &file.file));
    let (next, others): (Vec<&FileDigest>, Vec<&FileDigest>) = own.partition(is_next);
    if !next.is_empty() {
        let names = next.iter().chain(&others).map(|file| file.file.clone());
        move_files(dir, id, &names.collect::<Vec<_>>()).ok();
    }
}

/// Settles the files of every case.
pub fn settle_all(dir: &Path) {
    for id in pending(dir) {
        settle(dir, &id);
    }
}

/// Ids of the cases with files in `next/`. A folder that contains any other file does not belong to a case.
pub fn pending(dir: &Path) -> Vec<String> {
    let has_own_only =
        |id: &String| names(&dir.join(NEXT).join(id)).is_ok_and(|all| all.iter().all(|name| is_own(id, name)));
    names(&dir.join(NEXT)).unwrap_or_default().into_iter().filter(has_own_only).collect()
}

/// Removes the files of a case in `next/`, and their folder if it is then empty.
pub fn clear(dir: &Path, id: &str) {
    let folder = dir.join(NEXT).join(id);
    for name in names(&folder).unwrap_or_default().iter().filter(|name| is_own(id, name)) {
        std::fs::remove_file(folder.join(name)).ok();
    }
    std::fs::remove_dir(folder).ok();
}

fn names(folder: &Path) -> std::io::Result<Vec<String>> {
    std::fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// Whether a file of this name in `next/<id>` belongs to the case, complete or half-written.
fn is_own(id: &str, name: &str) -> bool {
    is_of(id, name) || is_part(name)
}

/// Moves the files of a result whose record is in its place. Files of the earlier result that the new one does not have are removed first.
fn move_files(dir: &Path, id: &str, files: &[String]) -> Result<(), Unwritten> {
    let (folder, cases) = (dir.join(NEXT).join(id), dir.join("cases"));
    let is_kept = |end: &str| end == "json" || end == SEARCH || files.iter().any(|file| *file == format!("{id}.{end}"));
    for end in ENDS.iter().filter(|end| !is_kept(end)) {
        let path = cases.join(format!("{id}.{end}"));
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err((path, e)),
            _ => {}
        }
    }
    for file in files {
        let to = cases.join(file);
        match storage::keep(&folder.join(file), &to) {
            // It is already there
            Err(e) if e.kind() != ErrorKind::NotFound => return Err((to, e)),
            _ => {}
        }
    }
    Ok(())
}

/// Whether this is the name of a file of the case, and does not lead out of the folder.
fn is_of(id: &str, file: &str) -> bool {
    file.strip_prefix(id).and_then(|rest| rest.strip_prefix('.')).is_some_and(|end| ENDS.contains(&end))
}

/// The files that a record names; empty if there is no readable record.
fn named(record: &Path) -> Vec<FileDigest> {
    let read = storage::read(record, DATA_LIMIT).ok();
    let record = read.and_then(|bytes| serde_json::from_slice::<WithFiles>(&bytes).ok());
    record.map_or_else(Vec::new, |record| record.provenance.results)
}

/// The part of a record that lists its files.
#[derive(Deserialize)]
struct WithFiles {
    provenance: Files,
}

#[derive(Deserialize)]
struct Files {
    #[serde(default)]
    results: Vec<FileDigest>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::store::names::{PAGE, STATES};
    use serde_json::json;
    use std::collections::BTreeMap;

    fn record(files: &[(&str, &str)]) -> String {
        let results: Vec<_> = files
            .iter()
            .map(|(end, text)| json!({"file": format!("a.{end}"), "sha256": storage::sha256(text)}))
            .collect();
        json!({"provenance": {"results": results}}).to_string()
    }

    /// Reads names and contents of the files of the case.
    fn found(dir: &Path) -> BTreeMap<String, String> {
        let files = std::fs::read_dir(dir.join("cases")).expect("there").flatten();
        let one = |file: std::fs::DirEntry| {
            let text = std::fs::read_to_string(file.path()).expect("text");
            (file.file_name().to_string_lossy().into_owned(), text)
        };
        files.map(one).collect()
    }

    fn wanted(files: &[(&str, &str)]) -> BTreeMap<String, String> {
        let named = |(end, text): &(&str, &str)| (format!("a.{end}"), (*text).to_string());
        files.iter().map(named).chain([("a.json".into(), record(files))]).collect()
    }

    #[test]
    fn a_result_takes_the_place_of_all_files_of_the_earlier_one() {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let dir = keep.path();
        std::fs::create_dir(dir.join("cases")).expect("a folder");
        for files in [[("csv", "1"), (STATES, "2")].as_slice(), &[("csv", "3")], &[("csv", "4"), (PAGE, "5")]] {
            let text = record(files);
            place(dir, "a", &[files, &[("json", text.as_str())]].concat()).expect("room");
            assert_eq!(found(dir), wanted(files));
            assert!(pending(dir).is_empty());
        }
    }

    /// A run that is killed before the record counts leaves the earlier result; afterwards it leaves the new one.
    #[test]
    fn the_record_decides_which_result_counts() {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let dir = keep.path();
        std::fs::create_dir(dir.join("cases")).expect("a folder");
        let (earlier, next) = ([("csv", "1"), (STATES, "2")], [("csv", "3")]);
        place(dir, "a", &[earlier.as_slice(), &[("json", record(&earlier).as_str())]].concat()).expect("room");
        let record = record(&next);
        write(dir, "a", &[next.as_slice(), &[("json", record.as_str())]].concat()).expect("room");
        settle(dir, "a");
        assert_eq!(found(dir), wanted(&earlier));
        std::fs::write(dir.join("cases/a.json"), &record).expect("room");
        settle(dir, "a");
        assert_eq!(found(dir), wanted(&next));
    }

    /// A folder of the user in `next/` is kept with all its content, even if it has the name of a case.
    #[test]
    fn files_of_others_in_the_folder_of_next_results_stay() {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let dir = keep.path();
        for folder in ["cases", "next/thesis", "next/a"] {
            std::fs::create_dir_all(dir.join(folder)).expect("room");
        }
        let (own, half) = (dir.join("next/a/a.csv"), dir.join("next/a/.x.part"));
        let others = ["next/thesis/data.csv", "next/a/thesis.csv", "next/note.txt"].map(|file| dir.join(file));
        for file in others.iter().chain([&own, &half]) {
            std::fs::write(file, "mine").expect("room");
        }
        assert!(pending(dir).is_empty());
        place(dir, "a", &[("csv", "1"), ("json", record(&[("csv", "1")]).as_str())]).expect("room");
        assert_eq!(found(dir), wanted(&[("csv", "1")]));
        for id in ["thesis", "a"] {
            clear(dir, id);
        }
        assert!(others.iter().all(|file| file.is_file()) && !own.exists() && !half.exists());
        std::fs::remove_file(&others[1]).expect("there");
        std::fs::write(&half, "").expect("room");
        assert_eq!(pending(dir), ["a"]);
        clear(dir, "a");
        assert!(!dir.join("next/a").exists());
    }
}
