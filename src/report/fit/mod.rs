//! Report of a fit: `fit.json` in, `figures/`, `tables/` and `index.html` out. Nothing is fitted here.

pub mod comparison;
mod figure;
mod page;
mod stored;
mod tables;

use crate::report::error::ReportError;
use crate::report::export;
use crate::report::files;
use std::path::Path;
use stored::StoredFit;

/// Writes the report of the fit in `dir`, next to its `fit.json`, and answers with the result in words.
pub fn write(dir: &Path) -> Result<String, ReportError> {
    let path = dir.join("fit.json");
    let fit: StoredFit = files::json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: dir.join("study.json") })?;
    let tables = tables::all(&fit);
    files::folder(&dir.join("tables"))?;
    for table in &tables {
        table.save(&dir.join("tables"))?;
    }
    let figure = figure::draw(&fit);
    let law_file = std::fs::read_to_string(dir.join("law.toml")).ok();
    let page = page::html(&fit, figure.as_ref(), &tables, law_file.as_deref());
    files::write(&dir.join("index.html"), page.as_bytes())?;
    files::folder(&dir.join("figures"))?;
    if let Some(figure) = &figure {
        export::save(&dir.join("figures"), &figure.name, &figure.svg)?;
    }
    Ok(page::answer(&fit))
}

/// Whether the folder holds a comparison of fits (`compare.json`).
pub fn is_comparison(dir: &Path) -> bool {
    dir.join("compare.json").is_file()
}

/// Whether the folder holds a fit (`fit.json`) and no study.
pub fn is_fit(dir: &Path) -> bool {
    dir.join("fit.json").is_file() && !dir.join("study.json").is_file()
}
