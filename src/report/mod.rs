//! Reports: read what a run has stored, analyse it, write `summary.json`, figures, tables and `index.html`.
//!
//! Nothing is solved here; [`write`] may be called again on a folder to redraw it.

mod canvas;
pub mod error;
mod export;
mod figures;
pub mod fit;
mod page;
mod plot;
pub mod store;
pub mod summary;
mod surface;
mod tables;

pub use error::ReportError;
pub use summary::Summary;

use crate::study::convergence;
use std::path::Path;

/// Does the folder hold a fit (`fit.json`) and no study?
pub fn is_fit(dir: &Path) -> bool {
    dir.join("fit.json").is_file() && !dir.join("study.json").is_file()
}

/// Writes the report of the study in `dir` beside its cases.
///
/// `summary.json` comes first: a figure that cannot be drawn does not cost the numbers.
pub fn write(dir: &Path) -> Result<Summary, ReportError> {
    let store = store::read(dir)?;
    let analysis = convergence::analyse(&store.study, &store.cases);
    let summary = summary::summarise(&store, &analysis);
    let text = serde_json::to_string_pretty(&summary).expect("numbers, strings and string keys only");
    error::write(&dir.join("summary.json"), text.as_bytes())?;

    let tables = tables::all(&store, &analysis);
    error::folder(&dir.join("tables"))?;
    for table in &tables {
        table.save(&dir.join("tables"))?;
    }
    let figures = figures::all(&store, &analysis);
    error::folder(&dir.join("figures"))?;
    let page = page::html(&store, &analysis, &figures, &tables);
    error::write(&dir.join("index.html"), page.as_bytes())?;
    for figure in &figures {
        export::save(&dir.join("figures"), &figure.name, &figure.svg)?;
    }
    Ok(summary)
}
