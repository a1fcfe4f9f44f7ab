//! Errors of reports, with the file and the remedy.

use std::io;
use std::path::PathBuf;

/// Reason why a report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The folder has neither `study.json` nor `fit.json`
    #[error(
        "{} does not exist; give the folder that `durometer run STUDY` or `durometer fit CSV` has written, or the record of a run such as \
         reports/simulate/scene.json",
        .path.display()
    )]
    NotAStudy { path: PathBuf },
    /// A given file that is not the record of a run
    #[error(
        "{} is not the record of a run: {source}; give the folder of results that `durometer run STUDY` or `durometer fit CSV` has \
         written, or the record of a run such as reports/simulate/scene.json",
        .path.display()
    )]
    NotARecord { path: PathBuf, source: serde_json::Error },
    /// A file next to the record of a run that differs from the one stored with it
    #[error("{}: its contents are not those that were stored with {}; run the scene again", .path.display(), .record.display())]
    OtherFile { path: PathBuf, record: PathBuf },
    /// The folder has no `summary.json`; the results of other commands are not compared
    #[error("{} does not exist; give the folder that `durometer run STUDY` has written", .path.display())]
    NoSummary { path: PathBuf },
    /// Cases were computed after the summary was written, or no longer count
    #[error(
        "{} is of other results than the folder has now, of case {case} for example; write it anew with `durometer report {}`",
        .path.display(), .dir.display()
    )]
    OutdatedSummary { path: PathBuf, dir: PathBuf, case: String },
    /// The file exists but cannot be read
    #[error("cannot read {}: {source}", .path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    /// JSON that is not a valid record, with line and column
    #[error(
        "{} is not a valid record: {source}; delete it and run the study again, the other cases are kept",
        .path.display()
    )]
    Malformed { path: PathBuf, source: serde_json::Error },
    /// A record in the format of another build, which is named
    #[error(
        "{}: {wrote} has written it in a form that this build does not read: {source}; run the study again to compute its cases \
         anew, or draw its report with that build",
        .path.display()
    )]
    OtherBuild { path: PathBuf, wrote: String, source: serde_json::Error },
    /// A file from a later version
    #[error(
        "{}: a newer version of this program has written it (schema {found}, known are those up to {known}); use that version",
        .path.display()
    )]
    Newer { path: PathBuf, found: u32, known: u32 },
    /// A time series that is not a table of numbers
    #[error("{}, line {line}: {what}; delete the file and its .json and run the study again", .path.display())]
    BadSeries { path: PathBuf, line: usize, what: String },
    /// The `kind` of a study that has no report
    #[error("{}: kind \"{kind}\" has no report; known: {known}", .path.display())]
    Kind { path: PathBuf, kind: String, known: String },
    /// No case has a result
    #[error("{} holds no finished case; run the study first", .path.display())]
    NoCases { path: PathBuf },
    /// Cases have results, but none has the files that were stored; in sentences
    #[error("no case has a sound result: {}", .facts.join(" "))]
    NoSoundCase { facts: Vec<String> },
    /// A folder or file that cannot be written, for example because the disk is full
    #[error("cannot write {}: {}", .path.display(), unwritable(.source))]
    Unwritable { path: PathBuf, source: io::Error },
    /// A drawing rejected by the PNG or PDF writer
    #[error("figure {name} could not be drawn: {what}")]
    Figure { name: String, what: String },
}

impl ReportError {
    /// Returns the failure of a figure, which affects neither the numbers nor the page; any other failure remains an error.
    pub fn of_figure<T>(report: Result<T, Self>) -> Result<Option<Self>, Self> {
        match report {
            Ok(_) => Ok(None),
            Err(why @ Self::Figure { .. }) => Ok(Some(why)),
            Err(why) => Err(why),
        }
    }

    /// The error of a figure whose drawing panicked.
    pub(super) fn drawing(name: &str) -> Self {
        let what = "a bug of this program; please report it with study.json and the folder cases".into();
        Self::Figure { name: name.into(), what }
    }
}

/// Describes why a file cannot be written, with the remedy.
fn unwritable(source: &io::Error) -> String {
    match source.kind() {
        io::ErrorKind::StorageFull => "the disk is full; free some space and give the command again".into(),
        _ => format!("{source}; check that the folder exists and is writable"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remedy_of_a_full_disk_holds_for_every_command() {
        let (path, source) = (PathBuf::from("scene.html"), io::ErrorKind::StorageFull.into());
        let said = ReportError::Unwritable { path, source }.to_string();
        assert!(said.contains("scene.html") && said.ends_with("give the command again"), "{said}");
    }
}
