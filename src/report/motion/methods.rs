//! How measured motion was evaluated, in sentences for a paper: the audit of every record, and the methods behind it.

use crate::motion::Evaluation;
use crate::report::ReportError;
use crate::report::numbers::capital;
use crate::report::paper::{Paper, Paragraph, Parts, software};
use std::collections::BTreeSet;
use std::path::Path;

/// Writes the folder `paper` into `dir`, which holds these tables; its folder `figures` holds these figures.
///
/// # Errors
/// Returns an error if a folder or file cannot be written.
pub fn write(dir: &Path, found: &[Evaluation], tables: &[&str], figures: &[String]) -> Result<(), ReportError> {
    let paper = Paper {
        paragraphs: paragraphs(found),
        versions: BTreeSet::from([env!("CARGO_PKG_VERSION")]),
        last_run_s: None,
        parts: Parts {
            title: "Measured motion",
            tables_in: "",
            tables: tables.to_vec(),
            figures: figures.iter().map(String::as_str).collect(),
        },
    };
    paper.write(&dir.join("paper"))
}

fn paragraphs(found: &[Evaluation]) -> Vec<Paragraph> {
    let mut how = Paragraph::new("Evaluation").text(
        "The held and the final state are means over windows in which the curve that moves most stays within a tolerance by its noise; the \
         release is the last row before it leaves the held state.",
    );
    if found.iter().any(|e| e.registration.is_some() || !e.poses.is_empty()) {
        how = how
            .marked(" Rigid motions are those with the least squares of the distances between markers [@umeyama1991].");
    }
    if found.iter().any(|e| e.ring_down.is_some()) {
        let sentence = " Frequency and decay are those of a damped cosine that is fitted to its window by least squares, with 95\u{a0}% \
                        intervals [@bates1988].";
        how = how.marked(sentence);
    }
    let records = found.iter().map(|e| {
        let log = e.log.iter().chain(&e.doubts).map(|entry| format!("{}.", capital(entry.trim_end_matches('.'))));
        Paragraph::new("Record").text(format!("Evaluation of {}. {}", e.source, log.collect::<Vec<_>>().join(" ")))
    });
    let version = [env!("CARGO_PKG_VERSION").to_string()];
    std::iter::once(how).chain(records).chain([software(&version)]).collect()
}
