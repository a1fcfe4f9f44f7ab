//! Page of `durometer fit --law all`: `compare.json` in, `tables/` and `index.html` out. Nothing is fitted here.

use crate::calibrate::stretch_text;
use crate::report::error::ReportError;
use crate::report::files;
use crate::report::page::{document, escape};
use crate::report::paper::{Paper, Paragraph, Parts, software};
use crate::report::table::{Table, headings};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;

/// The part of `compare.json` that is shown. Misfits are relative \[–\].
#[derive(Clone, Debug, Deserialize)]
struct Stored {
    data: String,
    #[serde(default)]
    version: String,
    modes: Vec<String>,
    stretch: [f64; 2],
    rows: usize,
    laws: Vec<Law>,
    #[serde(default)]
    doubts: Vec<String>,
}

#[derive(Clone, Debug, Deserialize)]
struct Law {
    label: String,
    constants: usize,
    misfit: f64,
    hold_out: Option<f64>,
    cross_mode: Option<f64>,
    /// Predictions that failed because the law is not defined at the data; files of earlier versions lack it
    #[serde(default)]
    failed: Vec<String>,
    undetermined: Vec<String>,
    lost: Vec<(String, f64)>,
    #[serde(default)]
    slack: Vec<Slack>,
}

#[derive(Clone, Debug, Deserialize)]
struct Slack {
    mode: String,
    strain: f64,
}

/// Writes the page of the comparison in `dir`, next to its `compare.json`.
pub fn write(dir: &Path) -> Result<(), ReportError> {
    let path = dir.join("compare.json");
    let stored: Stored = files::json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: path.clone() })?;
    let table = table(&stored);
    files::folder(&dir.join("tables"))?;
    table.save(&dir.join("tables"))?;
    let title = format!("Every law on {}", stored.data);
    let [low, high] = stored.stretch.map(stretch_text);
    let modes = stored.modes.join(" + ");
    let about = format!("{} data points ({modes}), stretch {low} to {high}.", stored.rows);
    let notes: String = notes(&stored).map(|note| format!("<p>{}</p>\n", escape(&note))).collect();
    let page = format!("<h1>{}</h1>\n<p>{}</p>\n{notes}{}", escape(&title), escape(&about), table.html());
    files::write(&dir.join("index.html"), document(&title, &page).as_bytes())?;
    let laws = stored.laws.iter().map(|l| l.label.clone()).collect::<Vec<_>>().join(", ");
    let paper = Paper {
        paragraphs: vec![
            Paragraph::new("Data").text(format!("{about} From {}.", stored.data)),
            Paragraph::new("Comparison").text(format!(
                "Each of these laws was fitted to the same data points: {laws}. They are ranked by what they predict, the last third of the \
                 logarithmic stretches of each test from the rest and one mode from the others, of the laws whose constants the data determine and that are stable over the fitted stretches."
            )),
            software(std::slice::from_ref(&stored.version)),
        ],
        versions: BTreeSet::from([stored.version.as_str()]),
        last_run_s: None,
        parts: Parts { title: &title, tables_in: "tables", tables: vec![table.name], figures: vec![] },
    };
    paper.write(&dir.join("paper"))
}

/// Notes on fitted slack, and reasons to doubt the data.
fn notes(stored: &Stored) -> impl Iterator<Item = String> {
    let of = |law: &Law| {
        let all: Vec<String> = law.slack.iter().map(|s| format!("{:.4} ({})", s.strain, s.mode)).collect();
        (!all.is_empty()).then(|| format!("{} {}", law.label, all.join(", ")))
    };
    let slack: Vec<String> = stored.laws.iter().filter_map(of).collect();
    let slack = (!slack.is_empty()).then(|| format!("Slack of strain, fitted with the law: {}.", slack.join("; ")));
    let doubts = stored.doubts.iter().map(|doubt| format!("Warning: {doubt}."));
    slack.into_iter().chain(doubts)
}

fn table(stored: &Stored) -> Table {
    let percent = |v: Option<f64>| match v {
        None => "–".into(),
        Some(v) if v > 10.0 => "> 1000".into(),
        Some(v) => format!("{:.1}", 100.0 * v),
    };
    let predicted = |law: &Law, name: &str, misfit: Option<f64>| {
        if law.failed.iter().any(|failed| failed == name) { "failed".into() } else { percent(misfit) }
    };
    let lost = |(mode, at): &(String, f64)| format!("{} to {at:.3}", mode.replace('_', " "));
    let row = |c: &Law| {
        vec![
            c.label.clone(),
            c.constants.to_string(),
            percent(Some(c.misfit)),
            predicted(c, "hold_out", c.hold_out),
            predicted(c, "cross_mode", c.cross_mode),
            if c.undetermined.is_empty() { "yes".into() } else { format!("no: {}", c.undetermined.join("; ")) },
            if c.lost.is_empty() { "yes".into() } else { c.lost.iter().map(lost).collect::<Vec<_>>().join(", ") },
        ]
    };
    Table {
        name: "comparison",
        caption: "Relative misfit of the rows that were fitted, and of rows that were not: the last third of |ln λ| from the rest, and one \
                  mode from the others; –: cannot be had, failed: the law is not defined there. The order is that of the worse prediction, then of the other one, then of the number of constants; laws with constants that the data do \
                  not determine come after the others, then those without one of the predictions, and laws that are not stable over the fitted stretches are last. Stable: in every mode as far as its principal stretches lie between 1/λ and λ of the largest \
                  fitted one, in tension or compression, and over the fitted stretches of its own; otherwise the modes in which it is not, and the amounts up to which it is."
            .into(),
        columns: headings(&[
            ("Law", "", false),
            ("Constants", "", true),
            ("Fitted", "%", true),
            ("Hold-out", "%", true),
            ("Cross-mode", "%", true),
            ("All determined", "", false),
            ("Stable to the fitted principal stretches", "", false),
        ]),
        rows: stored.laws.iter().map(row).collect(),
        pick: stored.laws.first().map(|c| c.label.clone()),
    }
}
