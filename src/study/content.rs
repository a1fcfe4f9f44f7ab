//! The part of a report that a kind of study contributes.

use crate::report::figure::Drawn;
use crate::report::numbers::minus_signs;
use crate::report::paper::Paragraph;
use crate::report::table::Table;
use crate::study::analysis::Analysis;
use crate::study::case_outcome::CaseOutcome;
use crate::study::claim::Claim;
use crate::study::extension::Extension;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The part of a report that depends on the kind of the study.
pub struct Content {
    pub verdict: String,
    /// Whether the data support a verdict
    pub supported: bool,
    /// The verdict in numbers, for a quick reader: (value, description)
    pub facts: Vec<(String, String)>,
    /// One sentence per quantity
    pub sentences: Vec<String>,
    pub warnings: Vec<String>,
    /// `analysis` of `summary.json`
    pub analysis: Map<String, Value>,
    /// The table that answers the question, under its own heading
    pub answer: (&'static str, Table),
    /// Tables that are always shown
    pub tables: Vec<Table>,
    /// Collapsed tables, with their titles
    pub folded: Vec<(&'static str, Table)>,
    pub figures: Vec<Drawn>,
    /// Values with their error bars
    pub claims: Vec<Claim>,
    /// Decisions by name: a result of the study with a different decision has a different verdict, whatever its wording and costs
    pub decisions: BTreeMap<String, String>,
    /// Additional files: name and text
    pub files: Vec<(String, String)>,
    /// Sources of the error bars, for the methods section of a paper, with citations as `[@key]`; empty if the kind states none
    pub errors: String,
    /// How constants were found, for the methods section of a paper, if the study searches for constants
    pub search: Vec<Paragraph>,
    /// The mesh that would support a verdict, if there is no verdict
    pub extension: Option<Extension>,
    /// Why the study has no result although its cases have
    pub without_result: Option<String>,
    /// Case id → outcome, if cases are judged individually
    pub outcomes: BTreeMap<String, CaseOutcome>,
}

impl Content {
    /// Builds the common part of a report from an analysis and the table that answers the question; the kind adds the rest.
    pub fn new<T>(analysis: &Analysis<T>, supported: bool, answer: (&'static str, Table)) -> Self {
        Self {
            verdict: analysis.verdict.clone(),
            supported,
            facts: vec![],
            sentences: vec![],
            warnings: analysis.warnings.clone(),
            analysis: Map::new(),
            answer,
            tables: vec![],
            folded: vec![],
            figures: vec![],
            claims: vec![],
            decisions: BTreeMap::new(),
            files: vec![],
            errors: String::new(),
            search: vec![],
            extension: None,
            without_result: None,
            outcomes: BTreeMap::new(),
        }
    }

    /// Replaces the hyphens before numbers by minus signs, in the verdict and the sentences.
    #[must_use]
    pub fn with_minus_signs(self) -> Self {
        let sentences = self.sentences.iter().map(|sentence| minus_signs(sentence)).collect();
        Self { verdict: minus_signs(&self.verdict), sentences, ..self }
    }

    /// Removes everything that follows from a comparison of the cases (verdict, decisions, headline numbers, error bars, the suggested mesh) and gives
    /// `why` as the verdict.
    #[must_use]
    pub fn without_verdict(self, why: String) -> Self {
        let decisions = BTreeMap::new();
        Self { verdict: why, supported: false, decisions, facts: vec![], claims: vec![], extension: None, ..self }
    }

    pub fn all_tables(&self) -> impl Iterator<Item = &Table> {
        std::iter::once(&self.answer.1).chain(&self.tables).chain(self.folded.iter().map(|(_, t)| t))
    }
}
