//! Report of a fit: `fit.json` in, `figures/`, `tables/`, `paper/` and `index.html` out. Nothing is fitted here.

pub mod comparison;
mod figure;
mod methods;
mod page;
mod stored;
mod tables;

use crate::report::error::ReportError;
use crate::report::export::Pictures;
use crate::report::figure::drawn;
use crate::report::files;
use crate::report::paper::{Paper, Parts};
use crate::storage::{self, TEXT_LIMIT};
use std::collections::BTreeSet;
use std::path::Path;
use stored::StoredFit;

/// Writes the report of the fit in `dir`, next to its `fit.json`, and returns the result in words.
pub fn write(dir: &Path) -> Result<String, ReportError> {
    let path = dir.join("fit.json");
    let fit: StoredFit = files::json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: dir.join("study.json") })?;
    let tables = tables::all(&fit);
    files::folder(&dir.join("tables"))?;
    for table in &tables {
        table.save(&dir.join("tables"))?;
    }
    let figure = drawn("fit", || figure::draw(&fit)).transpose().and_then(|figure| {
        let pictures = figure.as_ref().map(|f| Pictures::of(&f.name, &f.svg)).transpose()?;
        Ok(figure.zip(pictures))
    });
    let (figure, failure) = figure.map_or_else(|why| (None, Some(why)), |figure| (figure, None));
    let law_file = storage::read_text(&dir.join("law.toml"), TEXT_LIMIT).ok();
    let page = page::html(&fit, figure.as_ref().map(|f| &f.0), &tables, law_file.as_deref());
    files::write(&dir.join("index.html"), page.as_bytes())?;
    files::folder(&dir.join("figures"))?;
    if let Some((figure, pictures)) = &figure {
        pictures.save(&dir.join("figures"), figure)?;
    }
    let title = format!("{} from {}", fit.label, fit.data);
    let paper = Paper {
        paragraphs: methods::paragraphs(&fit, law_file.as_deref()),
        versions: BTreeSet::from([fit.version.as_str()]),
        last_run_s: None,
        parts: Parts {
            title: &title,
            tables_in: "tables",
            tables: tables.iter().map(|t| t.name).collect(),
            figures: figure.iter().map(|(f, _)| f.name.as_str()).collect(),
        },
    };
    paper.write(&dir.join("paper"))?;
    failure.map_or(Ok(()), Err)?;
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
