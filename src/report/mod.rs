//! Reports: read what a run has stored, analyse it, write `summary.json`, figures, tables and `index.html`.
//!
//! Nothing is solved here; [`write()`] may be called again on a folder to redraw it.

mod calibration;
mod canvas;
pub mod comparison;
mod content;
mod convergence;
mod cost;
pub mod error;
mod export;
mod figures;
pub mod fit;
mod materials;
mod page;
mod plot;
mod prices;
mod robustness;
pub mod store;
pub mod summary;
mod surface;
mod sweep;
mod table;

pub use error::ReportError;
pub use summary::Summary;

use crate::study::overlay::Overlay;
use std::path::Path;

/// Draws measured curves over recorded ones: `<name>-compare-1.svg`, `.png`, `.pdf` and so on in `dir`.
pub fn overlays(dir: &Path, name: &str, overlays: &[Overlay]) -> Result<(), ReportError> {
    for (k, overlay) in overlays.iter().enumerate() {
        let figure = figures::overlay::draw(&format!("{name}-compare-{}", k + 1), overlay);
        export::save(dir, &figure.name, &figure.svg)?;
    }
    Ok(())
}

/// Does the folder hold a comparison of fits (`compare.json`)?
pub fn is_comparison(dir: &Path) -> bool {
    dir.join("compare.json").is_file()
}

/// Does the folder hold a fit (`fit.json`) and no study?
pub fn is_fit(dir: &Path) -> bool {
    dir.join("fit.json").is_file() && !dir.join("study.json").is_file()
}

/// Writes the report of the study in `dir` beside its cases.
///
/// `summary.json` comes first: a figure that cannot be drawn does not cost the numbers.
pub fn write(dir: &Path) -> Result<Summary, ReportError> {
    let store = store::read(dir)?;
    let kind = content::KINDS.iter().find(|(kind, _)| *kind == store.study.kind);
    let (_, analyse) = kind.ok_or_else(|| ReportError::Kind {
        path: dir.join("study.json"),
        kind: store.study.kind.clone(),
        known: content::KINDS.map(|(kind, _)| kind).join(", "),
    })?;
    let content = analyse(&store);
    let summary = summary::summarise(&store, &content);
    let text = serde_json::to_string_pretty(&summary).expect("numbers, strings and string keys only");
    error::write(&dir.join("summary.json"), text.as_bytes())?;
    error::folder(&dir.join("tables"))?;
    for table in content.all_tables() {
        table.save(&dir.join("tables"))?;
    }
    for (name, text) in &content.files {
        error::write(&dir.join(name), text.as_bytes())?;
    }
    error::folder(&dir.join("figures"))?;
    error::write(&dir.join("index.html"), page::html(&store, &content).as_bytes())?;
    for figure in &content.figures {
        export::save(&dir.join("figures"), &figure.name, &figure.svg)?;
    }
    Ok(summary)
}
