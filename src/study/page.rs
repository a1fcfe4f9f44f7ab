//! Writes `index.html` of a study.

use crate::report::figure::Figure;
use crate::report::names::title;
use crate::report::page::{document, drawing, escape, list, prose};
use crate::report::paper::law;
use crate::report::table::Table;
use crate::report::viewer::pack::Packed;
use crate::study::content::Content;
use crate::study::locking;
use crate::study::paper::methods::{law_tables, scenes};
use crate::study::store::builds;
use crate::study::store::record::CaseRecord;
use crate::study::store::results::Results;
use crate::wording::{self, distinct};

/// Name of the page next to this one that shows the cases in three dimensions.
pub const VIEW: &str = "view.html";

/// Writes the whole page with the figures that could be drawn; `shown` are the cases on the page in three dimensions.
pub fn html(store: &Results, content: &Content, figures: &[Figure], shown: &[Packed]) -> String {
    let s = &store.study;
    let mut h = String::with_capacity(1 << 20);
    let class = if content.supported { "verdict" } else { "verdict refused" };
    h += &format!("<h1>{}</h1>\n<p class=\"lead\">{}</p>\n", escape(&s.study), escape(&s.question));
    h += &format!("<p class=\"{class}\">{}</p>\n", prose(&content.verdict));
    if let Some(alarm) = locking::sentence(&store.cases) {
        h += &format!("<p class=\"verdict refused\">{}</p>\n", prose(&alarm));
    }
    h += &facts(&content.facts);
    if !shown.is_empty() {
        let what = match shown.iter().filter(|case| case.moves()).count() {
            0 => "at the states farthest from rest",
            moving if moving == shown.len() => "with their motion",
            _ => "with their motion where it is recorded",
        };
        h += &format!("<p><a href=\"{VIEW}\">The cases in three dimensions</a>, {what}.</p>\n");
    }
    if !content.sentences.is_empty() {
        h += "<h2>Per quantity</h2>\n";
        h += &list(content.sentences.iter().cloned());
    }
    if !content.warnings.is_empty() {
        h += "<h2>Read this before using the numbers</h2>\n";
        h += &list(content.warnings.iter().cloned());
    }
    h += &format!("<dl><dt>Expectation before the run</dt><dd>{}</dd></dl>\n", escape(&s.expectation));
    let (heading, answer) = &content.answer;
    if !answer.rows.is_empty() {
        h += &format!("<h2>{heading}</h2>\n{}", answer.html());
    }
    if !figures.is_empty() {
        h += "<h2>Figures</h2>\n";
    }
    for (k, f) in figures.iter().enumerate() {
        h += &drawing(f, k + 1);
    }
    h += &tables(content);
    h += &provenance(store);
    document(&s.study, &h)
}

/// The tables that have rows, with the collapsed ones below the others.
fn tables(content: &Content) -> String {
    let with_rows = |t: &&Table| !t.rows.is_empty();
    let shown = content.tables.iter().filter(with_rows).map(Table::html);
    let folded = content.folded.iter().filter(|(_, t)| with_rows(&t)).map(|(words, t)| {
        format!("<details><summary>{words} ({})</summary>{}</details>\n", wording::count(t.rows.len(), "row"), t.html())
    });
    let all: String = shown.chain(folded).collect();
    if all.is_empty() { all } else { format!("<h2>Tables</h2>\n{all}") }
}

/// The verdict in numbers.
fn facts(facts: &[(String, String)]) -> String {
    if facts.is_empty() {
        return String::new();
    }
    let fact = |(value, name): &(String, String)| format!("<div><b>{}</b>{}</div>\n", escape(value), escape(name));
    format!("<div class=\"facts\">\n{}</div>\n", facts.iter().map(fact).collect::<String>())
}

/// The laws of all cases, with the ranges of those constants that differ.
fn laws(store: &Results) -> String {
    let records: Vec<&CaseRecord> = store.cases.iter().map(|c| &c.record).collect();
    let tables = law_tables(&records, &scenes(&records));
    let one = |group: &law::LawGroup| {
        let kind = group.tables[0].get("law").and_then(toml::Value::as_str).map(title).unwrap_or_default();
        let name = group.name.map_or(kind.clone(), |name| format!("{}, {kind}", name.replace('_', " ")));
        match law::constants(&group.tables) {
            constants if constants.is_empty() => name,
            constants => format!("{name} ({constants})"),
        }
    };
    let all: Vec<String> = law::groups(&tables).iter().map(one).collect();
    if all.is_empty() { "No law: springs".into() } else { format!("Law: {}", all.join("; ")) }
}

/// The effects of the cases, with a note if not all cases have the same.
fn effects(store: &Results) -> String {
    let lists = distinct(store.cases.iter().map(|c| c.record.effects.iter().map(|e| &e.name).collect::<Vec<_>>()));
    let names = distinct(lists.iter().flatten().map(|name| name.as_str()));
    let not_all = if lists.len() > 1 { " (not the same in every case)" } else { "" };
    format!("Effects assembled: {}{not_all}.", wording::joined(&names))
}

fn provenance(store: &Results) -> String {
    let mut h = String::from("<h2>Provenance</h2>\n");
    let builds = builds::builds(store.cases.iter().map(|c| &c.record));
    h += &format!(
        "<p>Computed by durometer {}. ",
        escape(&builds.iter().map(|(b, _)| b.words()).collect::<Vec<_>>().join("; "))
    );
    h += "Every number of this page is in <code>summary.json</code>, every curve in <code>cases/</code>; <code>durometer report</code> draws it again without running a solver.</p>\n";
    if let Some(c) = store.cases.first().map(|c| &c.record) {
        let integrators = distinct(store.cases.iter().map(|c| title(&c.record.integrator)));
        h += &format!(
            "<p>{}, integrator {}. {}</p>\n",
            escape(&laws(store)),
            escape(&wording::all(&integrators)),
            escape(&effects(store))
        );
        h += &format!(
            "<details><summary>Scene of case {}, as resolved</summary><pre>{}</pre></details>\n",
            escape(&c.id),
            escape(&c.provenance.scene)
        );
    }
    h += "<details><summary>Inputs (SHA-256)</summary><pre>";
    for c in &store.cases {
        h += &format!("{}  {}\n", escape(&c.record.provenance.identity.sha256), escape(&c.record.id));
    }
    h + "</pre></details>\n"
}
