//! Parts of a paper that follow from stored cases: the methods in sentences, from the records.

mod acting;
pub mod methods;

pub use methods::OwnMethods;

use crate::report::paper::{Paper, Parts};
use crate::report::{ReportError, files};
use crate::scene::FileDigest;
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::study::store::record::CaseRecord;
use std::path::{Path, PathBuf};

/// Writes the parts of a paper that follow from these records into `dir`.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(dir: &Path, records: &[&CaseRecord], own: OwnMethods, parts: Parts) -> Result<(), ReportError> {
    let paper = Paper {
        paragraphs: methods::paragraphs(records, own),
        versions: records.iter().map(|r| r.provenance.build.version.as_str()).collect(),
        last_run_s: records.iter().map(|r| r.provenance.started_unix_s).max().filter(|s| *s > 0),
        parts,
    };
    paper.write(dir)
}

/// Writes the parts that follow from the record of a single run, `<name>.json`, into `<name>-paper` next to it, and returns that folder.
///
/// # Errors
/// A file that is missing or is not a record, and a folder that cannot be written.
pub fn of_run(record: &Path) -> Result<PathBuf, ReportError> {
    let path = record.to_path_buf();
    let run: CaseRecord = match files::json(record) {
        // The user named the file, which may not be a result at all
        Err(ReportError::Malformed { path, source }) => return Err(ReportError::NotARecord { path, source }),
        read => read?.ok_or(ReportError::NotAStudy { path })?,
    };
    // A copy of a record under another name says nothing about the files next to it
    let is_own = record.file_stem().is_some_and(|stem| *stem == *run.id);
    let stored = |file: &&FileDigest| storage::read(&record.with_file_name(&file.file), DATA_LIMIT);
    let is_other = |file: &&FileDigest| stored(file).is_ok_and(|bytes| sha256(bytes) != file.sha256);
    if let Some(other) = run.provenance.results.iter().filter(|_| is_own).find(is_other) {
        return Err(ReportError::OtherFile { path: record.with_file_name(&other.file), record: record.into() });
    }
    let dir = record.with_file_name(format!("{}-paper", run.id));
    let parts = Parts { title: &run.id, tables_in: "tables", tables: vec![], figures: vec![] };
    write(&dir, &[&run], OwnMethods { errors: RUN_ERRORS, search: &[] }, parts)?;
    Ok(dir)
}

/// Sentence on errors for a single run, which says nothing about its mesh.
const RUN_ERRORS: &str = "No error bar follows from a single run on one mesh; a convergence study, or an estimate by a solution on an enriched \
                          mesh [@bank1993; @becker2001], states one.";
