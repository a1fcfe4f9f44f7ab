//! The report of a study: reads what a run has stored, analyses it, writes `summary.json`, figures, tables and `index.html`.
//!
//! Nothing is solved here; [`write()`] may be called again on a folder to redraw it.

use crate::report::{ReportError, export, files};
use crate::study::kinds::KINDS;
use crate::study::summary;
pub use crate::study::summary::Summary;
use crate::study::{builds, page, results};
use std::path::Path;

/// Writes the report of the study in `dir`, next to its cases.
///
/// `summary.json` comes first: a figure that cannot be drawn does not cost the numbers.
pub fn write(dir: &Path) -> Result<Summary, ReportError> {
    let results = results::read(dir)?;
    let kind = KINDS.iter().find(|kind| kind.name == results.study.kind).ok_or_else(|| ReportError::Kind {
        path: dir.join("study.json"),
        kind: results.study.kind.clone(),
        known: KINDS.map(|kind| kind.name).join(", "),
    })?;
    let mut content =
        (kind.report)(&results).map_err(|source| ReportError::Malformed { path: dir.join("study.json"), source })?;
    content.warnings.extend(builds::warning(results.cases.iter().map(|c| &c.record)));
    let summary = summary::summarise(&results, &content);
    let text = serde_json::to_string_pretty(&summary).expect("numbers, strings and string keys only");
    files::write(&dir.join("summary.json"), text.as_bytes())?;
    files::folder(&dir.join("tables"))?;
    for table in content.all_tables() {
        table.save(&dir.join("tables"))?;
    }
    for (name, text) in &content.files {
        files::write(&dir.join(name), text.as_bytes())?;
    }
    files::folder(&dir.join("figures"))?;
    files::write(&dir.join("index.html"), page::html(&results, &content).as_bytes())?;
    for figure in &content.figures {
        export::save(&dir.join("figures"), &figure.name, &figure.svg)?;
    }
    Ok(summary)
}
