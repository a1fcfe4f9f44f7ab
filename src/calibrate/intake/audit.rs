//! The log of everything that was found in a table and of what was done about it.

use crate::wording::lines;
use serde::{Deserialize, Serialize};
use std::fmt;

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AuditKind {
    /// How the file was understood
    Intake,
    /// Rows that are not used
    LeftOut,
    /// Rows after the rupture of a test piece, which are not used
    Ruptured,
    /// Rows that were changed or reordered, as requested
    Changed,
    /// Unusual rows that are used unchanged
    Kept,
    /// A reason to doubt the answer
    Doubt,
    /// A reason to doubt the answer unless slack is fitted
    Slack,
}

impl AuditKind {
    pub fn words(self) -> &'static str {
        match self {
            Self::Intake => "read",
            Self::LeftOut | Self::Ruptured => "left out",
            Self::Changed => "changed",
            Self::Kept => "kept",
            Self::Doubt | Self::Slack => "doubt",
        }
    }

    /// Whether the data points differ from those of the file: changed, or fewer.
    pub fn is_treatment(self) -> bool {
        match self {
            Self::LeftOut | Self::Ruptured | Self::Changed => true,
            Self::Intake | Self::Kept | Self::Doubt | Self::Slack => false,
        }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AuditEntry {
    pub kind: AuditKind,
    pub message: String,
    /// Lines of the file, counted from 1; empty if the entry is about the whole file
    pub lines: Vec<u64>,
}

impl AuditEntry {
    pub fn new(kind: AuditKind, message: impl Into<String>, lines: Vec<u64>) -> Self {
        Self { kind, message: message.into(), lines }
    }
}

impl fmt::Display for AuditEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.words(), self.message)?;
        if !self.lines.is_empty() {
            write!(f, " ({})", lines(&self.lines))?;
        }
        Ok(())
    }
}

/// Entries in the order in which they were found.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(transparent)]
pub struct Audit(pub Vec<AuditEntry>);

impl Audit {
    pub fn add(&mut self, kind: AuditKind, message: impl Into<String>, lines: Vec<u64>) {
        self.0.push(AuditEntry::new(kind, message, lines));
    }

    /// Logs rows of one kind, if there are any.
    pub fn add_rows(&mut self, kind: AuditKind, message: &str, lines: Vec<u64>) {
        if !lines.is_empty() {
            self.add(kind, message, lines);
        }
    }

    /// Removes the entries of a kind.
    pub fn remove(&mut self, kind: AuditKind) {
        self.0.retain(|entry| entry.kind != kind);
    }

    pub fn of(&self, kind: AuditKind) -> impl Iterator<Item = &AuditEntry> {
        self.0.iter().filter(move |e| e.kind == kind)
    }
}
