//! `index.html` of a fit.

use crate::calibrate::{Printed, ValidRange, stretch_text};
use crate::report::figure::Figure;
use crate::report::fit::stored::{StoredConstant, StoredFit};
use crate::report::numbers::{capital, minus_signs};
use crate::report::page::{document, drawing, escape, list, prose};
use crate::report::table::Table;
use crate::wording;

/// Returns the result in words.
pub fn answer(fit: &StoredFit) -> String {
    let one = |(p, printed): (&StoredConstant, Printed)| format!("{} = {}", p.symbol, p.words(&printed));
    let constants: Vec<String> = fit.parameters.iter().zip(fit.printed()).map(one).collect();
    let [a, b] = fit.stretch.map(stretch_text);
    let percent = 100.0 * fit.misfit.rms_relative;
    let mut out = format!(
        "{}: {} fitted to {} data points ({}, stretch {a} to {b}), misfit {percent:.1} % rms.",
        constants.join("; "),
        fit.label,
        fit.rows,
        fit.modes.join(" + "),
    );
    out += &validity(fit);
    minus_signs(&(out + &shorter_ranges(fit)))
}

/// States where the law describes each test; empty for results that do not contain this.
fn validity(fit: &StoredFit) -> String {
    let (tolerance, tests) = (100.0 * fit.validity.tolerance, &fit.validity.tests[..]);
    let end = |to: f64| format!("{} to stretch {}", if to < 1.0 { "down" } else { "up" }, stretch_text(to));
    let one = |t: &ValidRange| match t.to {
        Some(to) => format!("{} {}", t.test, end(to)),
        None => format!("{} at no stretch", t.test),
    };
    let words = match tests {
        [] => return String::new(),
        all if all.iter().all(|t| t.to.is_none()) => {
            format!(" It is nowhere within {tolerance:.0} % rms of these tests.")
        }
        [ValidRange { to: Some(to), .. }] => {
            format!(" It stays within {tolerance:.0} % rms of these tests {}.", end(*to))
        }
        all => {
            let list: Vec<String> = all.iter().map(one).collect();
            format!(" It stays within {tolerance:.0} % rms of these tests: {}.", list.join(", "))
        }
    };
    let near: Vec<String> = tests.iter().filter_map(|t| t.from).map(stretch_text).collect();
    if near.is_empty() {
        return words;
    }
    format!(
        "{words} Nearer to rest than stretch {} only its misfit in pascals is small, below 2 % of the rms stress of the fit.",
        near.join(" and ")
    )
}

/// States, in one sentence, the constants of shorter ranges whose difference is not explained by the errors, and whether the intervals contain them.
fn shorter_ranges(fit: &StoredFit) -> String {
    let printed = fit.printed();
    let of = |k: usize| (&fit.parameters[k], fit.range_spread[k]);
    let moved: Vec<usize> = (0..fit.range_spread.len()).filter(|k| of(*k).1[0] < of(*k).1[1]).collect();
    let span = |k: &usize| format!("{} from {}", of(*k).0.symbol, printed[*k].span(of(*k).1));
    let spans: Vec<String> = moved.iter().map(span).collect();
    let is_outside =
        |(p, [low, high]): &(&StoredConstant, [f64; 2])| p.ends().is_some_and(|[a, b]| *low < a || *high > b);
    let outside: Vec<&str> = moved.iter().map(|k| of(*k)).filter(is_outside).map(|(p, _)| p.symbol.as_str()).collect();
    let more = match outside.len() {
        0 => String::new(),
        1 if spans.len() == 1 => ", more than the interval says".into(),
        n if n == spans.len() => ", more than the intervals say".into(),
        _ => format!(", of {} more than the interval says", wording::all(&outside)),
    };
    if spans.is_empty() {
        String::new()
    } else {
        format!(" Ranges that end earlier give {}{more}.", wording::all(&spans))
    }
}

pub fn html(fit: &StoredFit, figure: Option<&Figure>, tables: &[Table], law_file: Option<&str>) -> String {
    let mut h = format!("<h1>{} from {}</h1>\n", escape(&fit.label), escape(&fit.data));
    h += &format!(
        "<p class=\"verdict{}\">{}</p>\n",
        if fit.is_doubtful() { " refused" } else { "" },
        prose(&answer(fit))
    );
    if !fit.messages.is_empty() {
        h += "<h2>Read this before using the numbers</h2>\n";
        h += &list(fit.messages.iter().map(|m| format!("{}.", capital(m))));
    }
    h += "<h2>Data and law</h2>\n";
    h += &figure.map_or(String::new(), |f| drawing(f, 1));
    h += "<h2>Numbers</h2>\n";
    h += &tables.iter().map(Table::html).collect::<String>();
    h += "<h2>What was done to the data</h2>\n";
    h += "<p>Nothing is changed silently; data points that are not listed were used unchanged.</p>\n";
    h += &list(fit.audit.iter().map(|entry| format!("{}.", capital(&entry.to_string()))));
    h += "<h2>Provenance</h2>\n<dl>";
    let mut put = |name: &str, value: &str| h += &format!("<dt>{name}</dt><dd>{}</dd>\n", escape(value));
    put("Law", &format!("{}. {}", fit.formula, fit.law_source));
    put("Data", fit.data_source.as_deref().unwrap_or("no source is stated (a card.toml next to the table would)"));
    put("SHA-256 of the table", &fit.data_sha256);
    put("Program", &format!("Durometer {}", fit.version));
    h += "</dl>\n<p>Every number and curve of this page is in <code>fit.json</code>; <code>durometer report</code> draws it again without fitting.</p>\n";
    if let Some(text) = law_file {
        h += &format!(
            "<details open><summary><code>law.toml</code>, as a scene includes it</summary><pre>{}</pre></details>\n",
            escape(text)
        );
    }
    document(&format!("{} from {}", fit.label, fit.data), &h)
}
