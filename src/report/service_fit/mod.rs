//! Report of a fit of a law in service: its JSON in, `figures/`, `tables/`, `paper/` and `index.html` out. Nothing is fitted here.

mod figure;

use crate::calibrate::FitSummary;
use crate::report::error::ReportError;
use crate::report::export::Pictures;
use crate::report::figure::drawn;
use crate::report::files;
use crate::report::names::symbol;
use crate::report::numbers::capital;
use crate::report::page::{document, drawing, escape, list};
use crate::report::paper::{Paper, Paragraph, Parts, software};
use crate::report::table::{Table, headings};
use crate::storage::{self, TEXT_LIMIT};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Names of the result files of these fits.
const RESULTS: [&str; 3] = ["prony.json", "mullins.json", "volume.json"];

/// The part of a result that is shown.
#[derive(Deserialize)]
struct Stored {
    summary: FitSummary,
    /// Version of the program that made the fit
    #[serde(default)]
    version: String,
}

/// Returns the result file of a fit of a law in service, if the folder has one and no study.
pub fn result_of(dir: &Path) -> Option<PathBuf> {
    let file = RESULTS.iter().map(|name| dir.join(name)).find(|path| path.is_file())?;
    (!dir.join("study.json").is_file()).then_some(file)
}

/// Writes the report of the fit in `dir`, and returns the result in words.
pub fn write(dir: &Path) -> Result<String, ReportError> {
    let missing = || ReportError::NotAStudy { path: dir.join("study.json") };
    let Stored { summary, version } = files::json(&result_of(dir).ok_or_else(missing)?)?.ok_or_else(missing)?;
    let table = Table {
        name: "constants",
        caption: "Fitted values with their 95 % intervals.".into(),
        columns: headings(&[("Quantity", "", false), ("Value", "", false)]),
        rows: summary.constants.iter().map(|[name, value]| vec![symbol(name), value.clone()]).collect(),
        pick: None,
    };
    files::folder(&dir.join("tables"))?;
    table.save(&dir.join("tables"))?;
    let figure = drawn("fit", || figure::draw(&summary.curves)).transpose().and_then(|figure| {
        let pictures = figure.as_ref().map(|f| Pictures::of(&f.name, &f.svg)).transpose()?;
        Ok(figure.zip(pictures))
    });
    let (figure, failure) = figure.map_or_else(|why| (None, Some(why)), |figure| (figure, None));
    let verdict = if summary.messages.is_empty() { "verdict" } else { "verdict refused" };
    let mut h =
        format!("<h1>{}</h1>\n<p class=\"{verdict}\">{}.</p>\n", escape(&summary.title), escape(&summary.answer));
    if !summary.messages.is_empty() {
        h += "<h2>Read this before using the numbers</h2>\n";
        h += &list(summary.messages.iter().map(|m| format!("{}.", capital(m))));
    }
    h += "<h2>Data and fit</h2>\n";
    h += &figure.as_ref().map_or(String::new(), |f| drawing(&f.0, 1));
    h += "<h2>Numbers</h2>\n";
    h += &table.html();
    h += &list(summary.method.iter().map(|m| format!("{}.", capital(m))));
    h += "<h2>What was read and changed</h2>\n";
    h += &list(summary.notes.iter().map(|n| format!("{}.", capital(n))));
    if let Ok(text) = storage::read_text(&dir.join(&summary.file), TEXT_LIMIT) {
        let name = escape(&summary.file);
        h += &format!(
            "<details open><summary><code>{name}</code>, as a scene includes it</summary><pre>{}</pre></details>\n",
            escape(&text)
        );
    }
    files::write(&dir.join("index.html"), document(&summary.title, &h).as_bytes())?;
    files::folder(&dir.join("figures"))?;
    if let Some((figure, pictures)) = &figure {
        pictures.save(&dir.join("figures"), figure)?;
    }
    let paper = Paper {
        paragraphs: paragraphs(&summary, &version),
        versions: BTreeSet::from([version.as_str()]),
        last_run_s: None,
        parts: Parts {
            title: &summary.title,
            tables_in: "tables",
            tables: vec![table.name],
            figures: figure.iter().map(|(f, _)| f.name.as_str()).collect(),
        },
    };
    paper.write(&dir.join("paper"))?;
    failure.map_or(Ok(()), Err)?;
    Ok(summary.answer)
}

/// The methods of a paper: the result with its constants, how it was obtained, and the data that were read.
fn paragraphs(summary: &FitSummary, version: &str) -> Vec<Paragraph> {
    let sentences = |all: &[String]| all.iter().map(|s| format!("{}.", capital(s))).collect::<Vec<_>>().join(" ");
    let constants: Vec<String> =
        summary.constants.iter().map(|[name, value]| format!("{} {value}", symbol(name))).collect();
    let result = format!("{}. Constants: {}.", capital(summary.answer.trim_end_matches('.')), constants.join("; "));
    vec![
        Paragraph::new("Result").text(result),
        Paragraph::new("Method").text(sentences(&summary.method)),
        Paragraph::new("Data").text(sentences(&summary.notes)),
        software(&[version.to_string()]),
    ]
}
