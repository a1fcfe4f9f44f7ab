//! Parts of a paper that follow from a result: `paper/` with the methods, the references, and a document of the generated parts.

mod constants;
mod methods;
mod references;
mod sample;
mod words;

use crate::report::{ReportError, files};
use crate::study::store::record::CaseRecord;
use references::Reference;
pub use sample::Parts;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use words::Paragraph;

/// Writes `methods.tex`, `methods.md`, `references.bib` and `paper.tex` into `dir`. `errors` are the sentences on error bars, with citations as `[@key]`.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(dir: &Path, records: &[&CaseRecord], errors: &str, parts: &Parts) -> Result<(), ReportError> {
    let paragraphs = methods::paragraphs(records, errors);
    files::folder(dir)?;
    let latex: String = paragraphs.iter().map(Paragraph::latex).collect();
    files::write(&dir.join("methods.tex"), latex.as_bytes())?;
    let markdown: Vec<String> = paragraphs.iter().map(Paragraph::markdown).collect();
    files::write(&dir.join("methods.md"), markdown.join("\n").as_bytes())?;
    files::write(&dir.join("references.bib"), bibliography(records, &paragraphs).as_bytes())?;
    files::write(&dir.join("paper.tex"), sample::document(parts).as_bytes())
}

/// Writes the same for the record of a single run, `<name>.json`, into `<name>-paper` next to it, and returns that folder.
///
/// # Errors
/// A file that is missing or no record, and a folder that cannot be written.
pub fn of_run(record: &Path) -> Result<PathBuf, ReportError> {
    let path = record.to_path_buf();
    let run: CaseRecord = files::json(record)?.ok_or(ReportError::NotAStudy { path })?;
    let dir = record.with_file_name(format!("{}-paper", run.id));
    write(&dir, &[&run], RUN_ERRORS, &Parts { title: &run.id, tables: vec![], figures: vec![] })?;
    Ok(dir)
}

/// A single run says nothing about its mesh.
const RUN_ERRORS: &str = "No error bar follows from a single run on one mesh; a convergence study, or an estimate by a solution on an enriched \
                          mesh [@bank1993; @becker2001], states one.";

/// Every reference once, by its key, and the program.
fn bibliography(records: &[&CaseRecord], paragraphs: &[Paragraph]) -> String {
    let cited: BTreeSet<&str> = paragraphs.iter().flat_map(Paragraph::references).map(|r| r.key).collect();
    let entries = cited.iter().filter_map(|key| Reference::of_key(key)).map(|r| r.entry.as_str());
    let entries: Vec<&str> = entries.collect();
    format!("{}\n{}", program(records), entries.join("\n"))
}

/// The entry of the program, with the version that computed the records and the year of the last run.
fn program(records: &[&CaseRecord]) -> String {
    let versions: BTreeSet<&str> =
        records.iter().map(|r| r.provenance.build.version.as_str()).filter(|v| !v.is_empty()).collect();
    let versions: Vec<&str> = versions.into_iter().collect();
    let version = if versions.is_empty() { "unknown".into() } else { versions.join(", ") };
    let seconds = records.iter().map(|r| r.provenance.started_unix_s).max().unwrap_or(0);
    // The mean year of the Gregorian calendar; the first hours of a year may count as the last one
    let year = 1970 + (seconds as f64 / (365.2425 * 86_400.0)) as u64;
    let year = if seconds == 0 { String::new() } else { format!("  year = {{{year}}},\n") };
    format!(
        "@misc{{durometer,\n  title = {{Durometer: mesh-convergence studies, hyperelastic calibration and paper figures for soft-robot simulation}},\n{year}  note = {{Version {version}}},\n}}\n"
    )
}
