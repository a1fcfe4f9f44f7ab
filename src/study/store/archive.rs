//! Exports a folder of results as one archive, and merges archives into one folder.
//!
//! The archive is a `.tar.gz`. Its first entry `contents.json` lists all others in order, with their sizes and SHA-256: `study.json`, the files of the
//! cases that were added to the study, then the files of each case, its record last. The same results give the same bytes: entries are sorted and carry
//! no times, owners or permissions.
//!
//! An archive is untrusted input. All of it is verified before anything is written: an entry must be a regular file, the next one in the list, with its
//! name, size and digest, and a name must be that of a file of a case or one of three others, so that no path leads out of the folder.

use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::extension;
use crate::study::rounds;
use crate::study::store::case_files::{CaseFiles, ENDS, FolderError, Unsound, check, check_in, ids, study};
use crate::study::store::field_folder;
use crate::study::store::folder::{Store, StoreError};
use crate::study::store::outdated::{forget_note, is_outdated};
use crate::study::store::placing;
use crate::study::store::record::{CaseRecord, StudyRecord};
use crate::study::store::superseded;
use flate2::read::MultiGzDecoder;
use flate2::{Compression, GzBuilder};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufReader, BufWriter, Read};
use std::path::{Path, PathBuf};
use tar::{Archive, Builder, Entries, EntryType, Header};

/// Format version of the archives that this program writes and reads.
const FORMAT: u32 = 1;
/// Name of the first entry.
const CONTENTS: &str = "contents.json";
/// Largest list of contents \[bytes\]: about a million cases.
const CONTENTS_LIMIT: u64 = 1 << 30;
/// Longest name of an entry \[bytes\].
const NAME_LIMIT: u64 = 1 << 12;
/// Name of the file with the record of the study.
const STUDY: &str = "study.json";
/// Names of the files with the cases that were added to a study.
const ADDED: [&str; 2] = [extension::FILE, rounds::FILE];
/// The fact of a conflict about inputs.
const OTHER_INPUTS: &str = "the archive has a result of other inputs";

/// An archive that cannot be written or is not accepted.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("{}: it cannot be written: {reason}; choose another place, or make room", path.display())]
    Unwritable { path: PathBuf, reason: String },
    #[error("{}: it changed while it was read; export again when no run writes into the folder", path.display())]
    Changed { path: PathBuf },
    #[error("{}: it cannot be read as an archive of results: {reason}; nothing was imported", path.display())]
    Malformed { path: PathBuf, reason: String },
    #[error("{}: it has form {found}, this program reads form {FORMAT}; import it with the program that wrote it", path.display())]
    Form { path: PathBuf, found: u32 },
    #[error(
        "{}: unpacked it would have {} MiB, more than {} MiB; nothing was imported, allow more with --limit",
        path.display(), bytes >> 20, limit >> 20
    )]
    TooLarge { path: PathBuf, bytes: u64, limit: u64 },
    #[error("{}: {}; nothing was imported", path.display(), damaged(files))]
    Damaged { path: PathBuf, files: Vec<Unsound> },
    #[error("{}: it holds results of the study {found}, the folder those of {own}; import it into another folder", path.display())]
    OtherStudy { path: PathBuf, found: String, own: String },
}

fn damaged(files: &[Unsound]) -> String {
    files.iter().map(|f| format!("{}: {}", f.file, f.fact)).collect::<Vec<_>>().join("; ")
}

/// First entry of an archive.
#[derive(Serialize, Deserialize)]
struct Contents {
    format: u32,
    study: String,
    files: Vec<Entry>,
}

#[derive(Serialize, Deserialize, Clone, PartialEq, Eq)]
struct Entry {
    /// Case id and file name suffix of a file of a case; `None` for other files
    case: Option<(String, String)>,
    /// Name of a file with added cases; `None` for `study.json`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    added: Option<String>,
    bytes: u64,
    sha256: String,
}

impl Entry {
    fn of(case: Option<(&str, &str)>, bytes: &[u8]) -> Self {
        let case = case.map(|(id, end)| (id.to_string(), end.to_string()));
        Self { case, added: None, bytes: bytes.len() as u64, sha256: sha256(bytes) }
    }

    fn name(&self) -> String {
        let of_study = || self.added.clone().unwrap_or(STUDY.into());
        self.case.as_ref().map_or_else(of_study, |(id, end)| format!("cases/{id}.{end}"))
    }

    fn id(&self) -> Option<&str> {
        self.case.as_ref().map(|(id, _)| id.as_str())
    }
}

/// The content of an archive that has been written.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Exported {
    pub cases: usize,
    /// Number of cases of the study without a record
    pub missing: usize,
    pub files: usize,
    /// Unpacked size
    pub bytes: u64,
    /// Files that differ from those that were stored; their cases are left out
    pub damaged: Vec<Unsound>,
    /// Cases whose results have other inputs than the study has now; they are left out
    pub outdated: Vec<String>,
}

/// Writes all intact results of a folder that count into an archive. Fields for ParaView and the report are left out; `run --vtu` and `report` make
/// them again.
pub fn export(dir: &Path, target: &Path) -> Result<Exported, ArchiveError> {
    let study = study(dir)?;
    let known = ids(&study);
    let found = CaseFiles::read(dir, &known)?;
    let has_record = |id: &&str| found.of_cases.get(*id).is_some_and(|ends| ends.contains("json"));
    let missing = known.iter().filter(|id| !has_record(id)).count();
    let mut out = Exported { cases: 0, missing, files: 0, bytes: 0, damaged: vec![], outdated: vec![] };
    let mut files = vec![];
    let read = |name: &str| {
        let path = dir.join(name);
        storage::read(&path, DATA_LIMIT).map_err(|e| FolderError::Unreadable { path, reason: e.to_string() })
    };
    files.push(Entry::of(None, &read(STUDY)?));
    for name in ADDED.into_iter().filter(|name| dir.join(name).is_file()) {
        files.push(Entry { added: Some(name.into()), ..Entry::of(None, &read(name)?) });
    }
    for (id, ends) in found.of_cases.iter().filter(|(id, ends)| known.contains(id.as_str()) && ends.contains("json")) {
        match check_in(dir, id) {
            Ok(record) if is_outdated(dir, &study, &record) => out.outdated.push(id.clone()),
            Ok(_) => {
                out.cases += 1;
                for end in ENDS.iter().filter(|end| ends.contains(*end)) {
                    files.push(Entry::of(Some((id, end)), &read(&format!("cases/{id}.{end}"))?));
                }
            }
            Err(wrong) => out.damaged.extend(wrong),
        }
    }
    (out.files, out.bytes) = (files.len(), files.iter().map(|f| f.bytes).sum());
    let contents = Contents { format: FORMAT, study: study.study, files };
    write(dir, target, &contents)?;
    Ok(out)
}

fn write(dir: &Path, target: &Path, contents: &Contents) -> Result<(), ArchiveError> {
    let mut changed = None;
    let result = storage::write_with(target, |file| {
        let packed = GzBuilder::new().mtime(0).write(BufWriter::new(file), Compression::default());
        let mut archive = Builder::new(packed);
        let list = serde_json::to_vec_pretty(contents).expect("numbers and strings only");
        append(&mut archive, CONTENTS, &list)?;
        for entry in &contents.files {
            let path = dir.join(entry.name());
            let bytes = storage::read(&path, DATA_LIMIT)?;
            if sha256(&bytes) != entry.sha256 {
                changed = Some(path);
                return Err(std::io::ErrorKind::Other.into());
            }
            append(&mut archive, &entry.name(), &bytes)?;
        }
        archive.into_inner()?.finish()?.into_inner().map_err(std::io::IntoInnerError::into_error)?;
        Ok(())
    });
    result.map_err(|e| match changed {
        Some(path) => ArchiveError::Changed { path },
        None => ArchiveError::Unwritable { path: target.into(), reason: e.to_string() },
    })
}

fn append(archive: &mut Builder<impl std::io::Write>, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let mut header = Header::new_gnu();
    header.set_size(bytes.len() as u64);
    header.set_mode(0o644);
    header.set_mtime(0);
    header.set_entry_type(EntryType::Regular);
    archive.append_data(&mut header, name, bytes)
}

/// Options of an import.
#[derive(Clone, Copy, Debug)]
pub struct ImportOptions {
    /// Whether results of the archive replace different ones in the folder
    pub replace: bool,
    /// Largest total size of all files \[bytes\]
    pub limit: u64,
}

/// The changes made by an import.
#[derive(Serialize, Clone, Debug, PartialEq, Default)]
pub struct Imported {
    /// Cases that the folder did not have before
    pub added: Vec<String>,
    /// Number of cases that the folder already had with the same results
    pub kept: usize,
    /// Cases whose results were replaced
    pub replaced: Vec<String>,
    /// Cases that differ, and were left unchanged in the folder
    pub conflicts: Vec<Conflict>,
    /// Files with added cases in the folder that the archive does not have, and that were removed
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<String>,
}

/// A case that differs between an archive and a folder.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Conflict {
    /// Id of the case, or `study.json`
    pub what: String,
    pub fact: String,
}

/// Merges an archive into a folder of results, which is created if necessary.
pub fn import(path: &Path, dir: &Path, options: ImportOptions) -> Result<Imported, ArchiveError> {
    let mut damaged = vec![];
    // Everything is verified before any file is written
    let mut of_study = walk(path, options.limit, &mut |id, files| match of_case(id, files) {
        Ok(_) => Ok(()),
        Err(wrong) => {
            damaged.extend(wrong);
            Ok(())
        }
    })?;
    if !damaged.is_empty() {
        return Err(ArchiveError::Damaged { path: path.into(), files: damaged });
    }
    let mut out = Imported::default();
    let is_of_archive = options.replace || !dir.join(STUDY).exists();
    let before = study(dir).ok();
    let record = of_study.remove(STUDY).unwrap_or_default();
    let (own, other) = place(path, dir, &record, (options, &mut out))?;
    if out.conflicts.is_empty() {
        place_added(dir, &of_study, (options, &mut out))?;
    }
    let known = ids(&own);
    let (inputs, others) = (&own.inputs_sha256, &other.inputs_sha256);
    let has_others = inputs != others && !inputs.is_empty() && !others.is_empty();
    let folder = Folder { dir, study: &own, has_others, is_of_archive };
    let mut brought = BTreeSet::new();
    walk(path, options.limit, &mut |id, files| {
        if !known.contains(id) {
            let fact = "the study of the folder has no such case".into();
            out.conflicts.push(Conflict { what: id.into(), fact });
            return Ok(());
        }
        let record = of_case(id, files).map_err(|files| ArchiveError::Damaged { path: path.into(), files })?;
        brought.insert(id.to_string());
        folder.merge(&record, files, options.replace, &mut out)
    })?;
    let has_other_inputs = before.is_some_and(|before| before.inputs_sha256 != own.inputs_sha256);
    if has_other_inputs || out.replaced.iter().any(|id| own.inputs_sha256.contains_key(id)) {
        note_waiting(dir, &own, &brought)?;
    }
    superseded::mark(dir, &own)?;
    Ok(out)
}

/// Marks results of waiting cases as outdated if the cases that they wait for have different results now, except results that the archive has `brought`
/// together with them. The next run finds out whether they belong to the present ones.
fn note_waiting(dir: &Path, study: &StudyRecord, brought: &BTreeSet<String>) -> Result<(), StoreError> {
    // A study of an earlier version does not store which cases wait
    let says = !study.inputs_sha256.is_empty();
    let waits = |id: &&str| says && !study.inputs_sha256.contains_key(*id) && !brought.contains(*id);
    ids(study).into_iter().filter(waits).try_for_each(|id| Store::at(dir).compare_inputs(id, None))
}

/// The studies of the folder and of the archive. The study of the archive replaces the other one if the folder has none, or if the results of the
/// archive replace those of the folder.
fn place(
    path: &Path,
    dir: &Path,
    record: &[u8],
    (options, out): (ImportOptions, &mut Imported),
) -> Result<(StudyRecord, StudyRecord), ArchiveError> {
    let bad = |e: serde_json::Error| ArchiveError::Malformed { path: path.into(), reason: format!("study.json: {e}") };
    let other: StudyRecord = serde_json::from_slice(record).map_err(bad)?;
    let unwritable = |e: std::io::Error| ArchiveError::Unwritable { path: dir.into(), reason: e.to_string() };
    let write = || storage::write(&dir.join(STUDY), record).map_err(unwritable);
    match study(dir) {
        Ok(own) if (&own.study, &own.kind) != (&other.study, &other.kind) => {
            Err(ArchiveError::OtherStudy { path: path.into(), found: other.study, own: own.study })
        }
        Ok(own) if own != other && options.replace => {
            write()?;
            Ok((other.clone(), other))
        }
        Ok(own) => {
            // Different inputs are reported case by case
            let (inputs_sha256, asks) = (own.inputs_sha256.clone(), other.asks.or(own.asks));
            if own != (StudyRecord { inputs_sha256, asks, ..other.clone() }) {
                let fact = "the study of the archive was another one, or of another version".into();
                out.conflicts.push(Conflict { what: STUDY.into(), fact });
            }
            Ok((own, other))
        }
        Err(FolderError::NotAStudy { .. }) => {
            std::fs::create_dir_all(dir.join("cases")).map_err(unwritable)?;
            write()?;
            Ok((other.clone(), other))
        }
        Err(error) => Err(error.into()),
    }
}

/// Writes the files with the cases added to the study of the archive, which is that of the folder. A file that differs is left unchanged in the folder,
/// unless the archive replaces its content; then files that the archive does not have are removed.
fn place_added(dir: &Path, added: &Files, (options, out): (ImportOptions, &mut Imported)) -> Result<(), ArchiveError> {
    for name in ADDED {
        let target = dir.join(name);
        let unwritable = |e: std::io::Error| ArchiveError::Unwritable { path: target.clone(), reason: e.to_string() };
        let own = storage::read(&target, DATA_LIMIT);
        let is_absent = own.as_ref().is_err_and(storage::is_absent);
        match (added.get(name), own) {
            (Some(bytes), Ok(own)) if own == *bytes => {}
            (Some(bytes), _) if is_absent || options.replace => storage::write(&target, bytes).map_err(unwritable)?,
            (Some(_), Ok(_)) => {
                let fact = "the archive has other cases that were added to the study".into();
                out.conflicts.push(Conflict { what: name.into(), fact });
            }
            (Some(_), Err(e)) => return Err(FolderError::Unreadable { path: target, reason: e.to_string() }.into()),
            (None, _) if options.replace && !is_absent => {
                std::fs::remove_file(&target).map_err(unwritable)?;
                out.removed.push(name.into());
            }
            (None, _) => {}
        }
    }
    Ok(())
}

/// Suffix → contents of the files of a case; or name → contents of other files.
type Files = BTreeMap<String, Vec<u8>>;

fn of_case(id: &str, files: &Files) -> Result<CaseRecord, Vec<Unsound>> {
    let missing = || std::io::Error::new(std::io::ErrorKind::NotFound, "it is not in the archive");
    check(id, &|end| files.get(end).cloned().ok_or_else(missing))
}

/// A folder into which results are merged.
struct Folder<'a> {
    dir: &'a Path,
    study: &'a StudyRecord,
    /// Whether the archive has results of other inputs
    has_others: bool,
    /// Whether the study is the one from the archive
    is_of_archive: bool,
}

impl Folder<'_> {
    /// Whether a result of the archive does not belong to the study of the folder. A result that waits for others does not tell by itself.
    fn refuses(&self, record: &CaseRecord) -> bool {
        self.study.is_of_others(record) || self.has_others && !self.study.inputs_sha256.contains_key(&record.id)
    }

    /// Writes the files of a case, unless the folder already has results of this case, or has other inputs.
    fn merge(&self, record: &CaseRecord, files: &Files, replace: bool, out: &mut Imported) -> Result<(), ArchiveError> {
        let id = &record.id;
        if self.refuses(record) {
            out.conflicts.push(Conflict { what: id.clone(), fact: OTHER_INPUTS.into() });
            return Ok(());
        }
        // A result that does not count is replaced
        let own = check_in(self.dir, id).ok();
        let gives_way = |own: &CaseRecord| own.broke() || is_outdated(self.dir, self.study, own);
        let replace = replace || own.as_ref().is_some_and(gives_way);
        let differs = own.as_ref().and_then(|own| {
            let (own, other) = (&own.provenance, &record.provenance);
            let facts = [
                (own.identity != other.identity, OTHER_INPUTS),
                (own.build != other.build, "the archive has a result of another build"),
                (own.results != other.results, "the archive has another result of the same inputs and build"),
            ];
            facts.into_iter().find(|(differs, _)| *differs).map(|(_, fact)| fact)
        });
        match (own.is_some(), differs) {
            (true, None) => {
                out.kept += 1;
                return self.count(id);
            }
            (true, Some(fact)) if !replace => {
                out.conflicts.push(Conflict { what: id.clone(), fact: fact.into() });
                return Ok(());
            }
            (true, Some(_)) => out.replaced.push(id.clone()),
            (false, _) => out.added.push(id.clone()),
        }
        let files: Vec<(&str, &Vec<u8>)> = files.iter().map(|(end, bytes)| (end.as_str(), bytes)).collect();
        placing::place(self.dir, id, &files)
            .and_then(|()| field_folder::remove_others(self.dir, record))
            .map_err(|(path, e)| ArchiveError::Unwritable { path, reason: e.to_string() })?;
        self.count(id)
    }

    /// Removes the mark that the result of a case does not count, if the study is that of the archive, whose results count.
    fn count(&self, id: &str) -> Result<(), ArchiveError> {
        let forgotten = if self.is_of_archive { forget_note(self.dir, id) } else { Ok(()) };
        forgotten.map_err(|why| ArchiveError::Unwritable { path: self.dir.into(), reason: why.to_string() })
    }
}

/// Calls `each` with the files of every case of an archive, whose entries are verified against its list. Returns the other files: `study.json`, and
/// those with added cases.
fn walk(
    path: &Path,
    limit: u64,
    each: &mut dyn FnMut(&str, &Files) -> Result<(), ArchiveError>,
) -> Result<Files, ArchiveError> {
    let malformed = |reason: String| ArchiveError::Malformed { path: path.into(), reason };
    let file = storage::open(path).map_err(|e| malformed(e.to_string()))?;
    let mut archive = Archive::new(MultiGzDecoder::new(BufReader::new(file)));
    let mut entries = archive.entries().map_err(|e| malformed(e.to_string()))?.raw(true);
    let (name, list) = next(&mut entries, CONTENTS_LIMIT).map_err(malformed)?;
    if name != CONTENTS {
        return Err(malformed(format!("its first entry is {name}, not {CONTENTS}")));
    }
    let contents: Contents = serde_json::from_slice(&list).map_err(|e| malformed(format!("{CONTENTS}: {e}")))?;
    if contents.format != FORMAT {
        return Err(ArchiveError::Form { path: path.into(), found: contents.format });
    }
    let bytes = contents.files.iter().fold(0u64, |sum, f| sum.saturating_add(f.bytes));
    if bytes > limit {
        return Err(ArchiveError::TooLarge { path: path.into(), bytes, limit });
    }
    check_names(&contents.files).map_err(malformed)?;
    let (mut of_study, mut files) = (Files::new(), Files::new());
    for (k, listed) in contents.files.iter().enumerate() {
        let (name, bytes) = next(&mut entries, listed.bytes).map_err(malformed)?;
        if name != listed.name() || bytes.len() as u64 != listed.bytes || sha256(&bytes) != listed.sha256 {
            let fact = format!("name or contents are not those of the list, where {} is next", listed.name());
            return Err(ArchiveError::Damaged { path: path.into(), files: vec![Unsound { file: name, fact }] });
        }
        let Some((id, end)) = &listed.case else {
            of_study.insert(name, bytes);
            continue;
        };
        files.insert(end.clone(), bytes);
        if contents.files.get(k + 1).and_then(Entry::id) != Some(id.as_str()) {
            each(id, &std::mem::take(&mut files))?;
        }
    }
    match entries.next() {
        None => Ok(of_study),
        Some(_) => Err(malformed("it has entries that are not in its list".into())),
    }
}

/// Checks that the list has `study.json`, the files of added cases, then the files of each case together, none of them twice, with names that lead
/// nowhere else.
fn check_names(files: &[Entry]) -> Result<(), String> {
    if files.first().is_none_or(|f| f.name() != STUDY) {
        return Err("its list does not begin with study.json".into());
    }
    let is_added = |name: &str| files[1..].iter().any(|entry| entry.case.is_none() && entry.name() == name);
    let added = ADDED.into_iter().filter(|name| is_added(name)).count();
    let mut cases = BTreeSet::new();
    let mut last: (&str, BTreeSet<&str>) = ("", BTreeSet::new());
    for entry in &files[1 + added..] {
        let plain = |id: &str| !id.starts_with('.') && id.chars().all(|c| c.is_alphanumeric() || "._-".contains(c));
        let Some((id, end)) = entry.case.as_ref().filter(|(id, end)| plain(id) && ENDS.contains(&end.as_str())) else {
            return Err(format!("\"{}\" is no file of a case", entry.name()));
        };
        if id != last.0 {
            if id.is_empty() || !cases.insert(id) {
                return Err(format!("the files of \"{id}\" are not together"));
            }
            last = (id, BTreeSet::new());
        }
        if !last.1.insert(end) {
            return Err(format!("{} is listed twice", entry.name()));
        }
    }
    Ok(())
}

/// Reads name and contents of the next entry, which must be a regular file of at most `limit` bytes. A name that is too long for the header precedes
/// it, as an entry of its own.
fn next<R: Read>(entries: &mut Entries<R>, limit: u64) -> Result<(String, Vec<u8>), String> {
    let mut long = None;
    loop {
        let mut entry = match entries.next() {
            Some(entry) => entry.map_err(|e| e.to_string())?,
            None => return Err("it ends before its list does".into()),
        };
        let kind = entry.header().entry_type();
        if kind == EntryType::GNULongName && long.is_none() {
            let name = storage::limited(&mut entry, NAME_LIMIT).map_err(|e| format!("the name of an entry: {e}"))?;
            long = Some(name.strip_suffix(b"\0").unwrap_or(&name).to_vec());
            continue;
        }
        let name = long.unwrap_or_else(|| entry.path_bytes().into_owned());
        let name = String::from_utf8(name).map_err(|_| "a name is not UTF-8".to_string())?;
        if kind != EntryType::Regular {
            return Err(format!("{name} is not a regular file"));
        }
        let bytes = storage::limited(&mut entry, limit).map_err(|e| format!("{name}: {e}"))?;
        return Ok((name, bytes));
    }
}
