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
    /// The data support a verdict
    pub supported: bool,
    /// The verdict in numbers, for those who read nothing else: (value, what it is)
    pub facts: Vec<(String, String)>,
    /// One sentence per quantity
    pub sentences: Vec<String>,
    pub warnings: Vec<String>,
    /// `analysis` of `summary.json`
    pub analysis: Map<String, Value>,
    /// The table that answers the question, under a heading of its own
    pub answer: (&'static str, Table),
    /// Tables that are shown
    pub tables: Vec<Table>,
    /// Tables to unfold, with what they hold
    pub folded: Vec<(&'static str, Table)>,
    pub figures: Vec<Drawn>,
    /// Values with their error bars
    pub claims: Vec<Claim>,
    /// Decisions by name: another result of the study that decides otherwise has another verdict, whatever the words and the costs are
    pub decisions: BTreeMap<String, String>,
    /// Files in addition to the page: name and text
    pub files: Vec<(String, String)>,
    /// Where error bars come from, for the methods of a paper, with citations as `[@key]`; empty where the kind states none
    pub errors: String,
    /// How constants were found, for the methods of a paper, where the study searches for them
    pub search: Vec<Paragraph>,
    /// The mesh that would support a verdict where there is none
    pub extension: Option<Extension>,
    /// Why the study has no result although its cases have theirs
    pub without_result: Option<String>,
    /// Case id → outcome, where cases are judged one by one
    pub outcomes: BTreeMap<String, CaseOutcome>,
}

impl Content {
    /// The frame of an analysis, with the table that answers the question; the kind adds its own.
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

    /// The same with minus signs in place of the hyphens before numbers, in the verdict and the sentences.
    #[must_use]
    pub fn with_minus_signs(self) -> Self {
        let sentences = self.sentences.iter().map(|sentence| minus_signs(sentence)).collect();
        Self { verdict: minus_signs(&self.verdict), sentences, ..self }
    }

    /// The same without what follows from a comparison of its cases: verdict, decisions, headline numbers and error bars.
    #[must_use]
    pub fn without_verdict(self, why: String) -> Self {
        let decisions = BTreeMap::new();
        Self { verdict: why, supported: false, decisions, facts: vec![], claims: vec![], extension: None, ..self }
    }

    pub fn all_tables(&self) -> impl Iterator<Item = &Table> {
        std::iter::once(&self.answer.1).chain(&self.tables).chain(self.folded.iter().map(|(_, t)| t))
    }
}
