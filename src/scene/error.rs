//! Reasons why a scene or study cannot be used, always with the place, the fact and the remedy.

use crate::mesh::error::MeshError;
pub use crate::wording::hint;
use std::fmt;
use std::path::{Path, PathBuf};

/// A scene or study file with a mistake in it.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{}: cannot be read: {reason}; check the path and its permissions", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}{mistake}", file.display())]
    Syntax { file: PathBuf, mistake: Box<Mistake> },
    #[error("{}: {place}: {fact}; {remedy}", file.display())]
    Content { file: PathBuf, place: String, fact: String, remedy: String },
    /// A mesh file that is read without a scene
    #[error(transparent)]
    Mesh(MeshError),
    #[error("{}: {place}: {source}", file.display())]
    Part {
        file: PathBuf,
        place: String,
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl SceneError {
    /// Moves the error to another place of the file.
    pub(super) fn at(self, place: &str) -> Self {
        match self {
            Self::Content { file, fact, remedy, .. } => Self::Content { file, place: place.into(), fact, remedy },
            Self::Part { file, source, .. } => Self::Part { file, place: place.into(), source },
            other => other,
        }
    }

    /// The error attributed to the file and the place that changed the scene.
    pub fn caused_by(self, file: &Path, place: &str) -> Self {
        let place = format!("{place} makes a scene that is refused");
        Self::Part { file: file.into(), place, source: self.into() }
    }
}

/// A mistake found by the reader, with its line.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Source of the text, if it is not the unchanged file: `with the change mesh.cells`
    pub origin: String,
    pub line: Option<Line>,
    /// Place in the scene, such as `effect 3 (gravity)`
    pub place: Option<String>,
    /// Fact and remedy
    pub what: String,
}

/// A line of a file, counted from 1, and the columns of the mistake, counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub number: usize,
    pub text: String,
    pub columns: std::ops::Range<usize>,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.origin.is_empty() {
            write!(f, " {}", self.origin)?;
        }
        // Line numbers of a text other than that of the file mean nothing to the reader
        let number = self.line.as_ref().filter(|_| self.origin.is_empty()).map(|line| line.number.to_string());
        if let Some(number) = &number {
            write!(f, ", line {number}")?;
        }
        write!(f, ": ")?;
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        write!(f, "{}", self.what)?;
        let Some(Line { text, columns, .. }) = &self.line else { return Ok(()) };
        let gutter = number.unwrap_or_default();
        let marks = "^".repeat(columns.len().max(1));
        write!(f, "\n  {gutter} | {text}\n  {:w$} | {:c$}{marks}", "", "", w = gutter.len(), c = columns.start)
    }
}

impl Line {
    /// The line of `text` in which the bytes `span` start.
    pub fn of(text: &str, span: std::ops::Range<usize>) -> Self {
        let start = span.start.min(text.len());
        let begin = text[..start].rfind('\n').map_or(0, |k| k + 1);
        let line = text[begin..].lines().next().unwrap_or("");
        let column = text[begin..start].chars().count();
        let meant = text.get(start..span.end.min(begin + line.len())).map_or(0, |s| s.chars().count());
        Self { number: text[..begin].matches('\n').count() + 1, text: line.into(), columns: column..column + meant }
    }
}

/// The message of the TOML reader in Durometer's wording, with the nearest known key if a key is unknown.
pub fn explain(message: &str) -> String {
    let message = message.trim_end().replace('\n', ", ");
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if let Some((unknown, known)) =
        message.strip_prefix("unexpected keys in table: ").and_then(|m| m.split_once(", available keys:"))
    {
        let known: Vec<&str> = known.split(',').map(str::trim).filter(|k| !k.is_empty()).collect();
        let hint = if known.is_empty() { "it takes no key but `kind`".into() } else { hint(unknown, &known) };
        return format!("unknown key `{unknown}`; {hint}");
    }
    match quoted.split_first() {
        Some((&"", kinds)) if message.starts_with("unknown variant") => {
            format!("it has no `kind`; add kind = \"…\" with one of {}", kinds.join(", "))
        }
        Some((word, [])) if message.starts_with("unknown field") => {
            format!("unknown key `{word}`; it takes no key but `kind`")
        }
        Some((word, known)) if message.starts_with("unknown field") => {
            format!("unknown key `{word}`; {}", hint(word, known))
        }
        Some((word, known)) if message.starts_with("unknown variant") => {
            format!("unknown name `{word}`; {}", hint(word, known))
        }
        Some((word, _)) if message.starts_with("missing field") => format!("the key `{word}` is missing; add it"),
        Some((word, _)) if message.starts_with("duplicate field") => format!("`{word}` is given twice; remove one"),
        _ if message.starts_with("invalid type") => {
            let message = message.replace(", expected ", "; this must be ").replace("invalid type: ", "");
            let message = message.replace("this must be struct variant ", "this must be a table of the keys of ");
            match message.rsplit_once("this must be ") {
                Some((found, "usize" | "u64" | "u32" | "u16" | "u8" | "i64")) => {
                    format!("{found}this must be a whole number")
                }
                Some((found, "f64")) => format!("{found}this must be a number"),
                _ => message,
            }
        }
        _ => message,
    }
}

/// A mistake in a scene: its place, the fact and the remedy.
pub(super) fn content(file: &Path, place: &str, fact: impl Into<String>, remedy: impl Into<String>) -> SceneError {
    SceneError::Content { file: file.into(), place: place.into(), fact: fact.into(), remedy: remedy.into() }
}

/// A mistake in a part of a scene, with the underlying error.
pub(super) fn part(
    file: &Path,
    place: impl Into<String>,
    source: impl Into<Box<dyn std::error::Error + Send + Sync>>,
) -> SceneError {
    SceneError::Part { file: file.into(), place: place.into(), source: source.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_by_its_bytes() {
        let text = "a = 1\nµ = \"x\"\n\nend";
        let at = |needle: &str| {
            let start = text.find(needle).expect("there");
            Line::of(text, start..start + needle.len())
        };
        assert_eq!(at("\"x\""), Line { number: 2, text: "µ = \"x\"".into(), columns: 4..7 });
        assert_eq!(at("end").number, 4);
        assert_eq!(Line::of(text, text.len()..text.len()).number, 4);
        assert_eq!(Line::of("", 0..0), Line { number: 1, text: String::new(), columns: 0..0 });
    }

    #[test]
    fn messages_name_the_nearest_known_word() {
        let known = "expected one of `cells`, `size`";
        assert_eq!(
            explain(&format!("unknown field `cell`, {known}")),
            "unknown key `cell`; did you mean `cells`? (known: cells, size)"
        );
        assert_eq!(explain(&format!("unknown field `xyz`, {known}")), "unknown key `xyz`; known: cells, size");
        assert_eq!(
            explain("unexpected keys in table: densty, available keys: region, density"),
            "unknown key `densty`; did you mean `density`? (known: region, density)"
        );
        assert_eq!(
            explain("invalid type: string \"abc\", expected usize"),
            "string \"abc\"; this must be a whole number"
        );
        assert_eq!(explain("missing field `dt`"), "the key `dt` is missing; add it");
        assert_eq!(
            explain("unknown variant ``, expected `box` or `ball`"),
            "it has no `kind`; add kind = \"…\" with one of box, ball"
        );
    }
}
