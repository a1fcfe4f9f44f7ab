//! Why a report could not be made, with the file and the remedy.

use std::fmt;
use std::io;
use std::path::PathBuf;

#[derive(Debug)]
pub enum ReportError {
    /// Neither `study.json` nor `fit.json` here
    NotAStudy { path: PathBuf },
    /// The file is there but cannot be opened
    Unreadable { path: PathBuf, source: io::Error },
    /// JSON that is not what it should be, with line and column
    Malformed { path: PathBuf, source: serde_json::Error },
    /// A record in the form of another build, which is named
    OtherBuild { path: PathBuf, wrote: String, source: serde_json::Error },
    /// Files of a later version
    Newer { path: PathBuf, found: u32, known: u32 },
    /// A time series that is no table of numbers
    BadSeries { path: PathBuf, line: usize, what: String },
    /// `kind` of another study
    Kind { path: PathBuf, kind: String, known: String },
    /// Not one case has a result
    NoCases { path: PathBuf },
    /// Cases have results, but of none the files that were stored; in sentences
    NoSoundCase { facts: Vec<String> },
    /// Folder or file that cannot be written, a full disk included
    Unwritable { path: PathBuf, source: io::Error },
    /// A drawing that the PNG or PDF writer refused
    Figure { name: String, what: String },
}

impl ReportError {
    /// Of a figure whose drawing ended in a panic.
    pub(super) fn drawing(name: &str) -> Self {
        let what = "a bug of this program; please report it with study.json and the folder cases".into();
        Self::Figure { name: name.into(), what }
    }
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAStudy { path } => {
                write!(
                    f,
                    "{} does not exist; give the folder that `durometer run STUDY` or `durometer fit CSV` has written",
                    path.display()
                )
            }
            Self::Newer { path, found, known } => write!(
                f,
                "{}: a newer version of this program has written it (schema {found}, known are those up to {known}); use that version",
                path.display()
            ),
            Self::Unreadable { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Malformed { path, source } => write!(
                f,
                "{} is not a valid record: {source}; delete it and run the study again, the other cases are kept",
                path.display()
            ),
            Self::OtherBuild { path, wrote, source } => write!(
                f,
                "{}: {wrote} has written it in a form that this build does not read: {source}; run the study again to compute its cases \
                 anew, or draw its report with that build",
                path.display()
            ),
            Self::BadSeries { path, line, what } => write!(
                f,
                "{}, line {line}: {what}; delete the file and its .json and run the study again",
                path.display()
            ),
            Self::Kind { path, kind, known } => {
                write!(f, "{}: kind \"{kind}\" has no report; known: {known}", path.display())
            }
            Self::NoCases { path } => {
                write!(f, "{} holds no finished case; run the study first", path.display())
            }
            Self::NoSoundCase { facts } => write!(f, "no case has a sound result: {}", facts.join(" ")),
            Self::Unwritable { path, source } if source.kind() == io::ErrorKind::StorageFull => {
                write!(
                    f,
                    "cannot write {}: the disk is full; free some space and give the command again",
                    path.display()
                )
            }
            Self::Unwritable { path, source } => {
                write!(f, "cannot write {}: {source}; check that the folder exists and is writable", path.display())
            }
            Self::Figure { name, what } => write!(f, "figure {name} could not be drawn: {what}"),
        }
    }
}

impl std::error::Error for ReportError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } | Self::Unwritable { source, .. } => Some(source),
            Self::Malformed { source, .. } | Self::OtherBuild { source, .. } => Some(source),
            _ => None,
        }
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
