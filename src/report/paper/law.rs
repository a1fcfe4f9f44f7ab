//! Laws of a scene with their constants and where these come from, in sentences.

use crate::calibrate::within;
use crate::material::{LawInfo, Parameter, find};
use crate::math::units::{self, Dimension};
use crate::report::numbers::capital;
use crate::report::paper::references::Reference;
use crate::report::paper::words::Paragraph;
use toml::{Table, Value};

/// Adds a sentence on a law of a scene.
pub fn describe(to: Paragraph, table: &Table) -> Paragraph {
    let Some(Ok(entry)) = table.get("law").and_then(Value::as_str).map(find) else { return to };
    let empty = Table::new();
    let provenance = table.get("provenance").and_then(Value::as_table).unwrap_or(&empty);
    let constants: Vec<String> =
        table.iter().filter_map(|(key, value)| constant(entry.parameter(key)?, value, provenance)).collect();
    let mut to = formula(to, entry.info).text(format!(", with {}", constants.join(", ")));
    to = match source(provenance) {
        Some(source) => to.text(format!("; constants from {source}")),
        None => to.text("; the constants are those of the scene, without a stated source"),
    };
    to.text(". ")
}

/// Adds a sentence on the form of a law, without constants; a law that does not exist is left out.
pub fn named(to: Paragraph, law: &str) -> Paragraph {
    match find(law) {
        Ok(entry) => formula(to, entry.info).text(". "),
        Err(_) => to,
    }
}

/// Name, source and formula.
fn formula(to: Paragraph, info: &LawInfo) -> Paragraph {
    let cited = Reference::named_in(info.source);
    let source = if cited.is_empty() { format!(" ({})", info.source) } else { String::new() };
    let to = to.text(format!("{} law{source}", capital(info.title))).cite(cited);
    to.text(format!(", {}", info.formula))
}

/// `μ = 357 kPa (95 % interval 334 to 380 kPa)`, from the text of a scene.
fn constant(p: &Parameter, value: &Value, provenance: &Table) -> Option<String> {
    let si = |value: &Value| match value {
        Value::String(text) => units::parse(text, p.dimension).ok(),
        other => other.as_float().or_else(|| other.as_integer().map(|n| n as f64)),
    };
    let number = si(value)?;
    let ends = provenance.get(&format!("{}_interval", p.name)).and_then(Value::as_array);
    let ends = ends.and_then(|ends| Some([si(ends.first()?)?, si(ends.get(1)?)?]));
    let unit = if p.dimension == Dimension::PRESSURE { "Pa" } else { "" };
    let (factor, unit, n) = within(number, unit, ends);
    let unit = if unit.is_empty() { String::new() } else { format!("\u{a0}{unit}") };
    // A constant without an interval has the digits that it was given
    let shown = match ends {
        Some([a, b]) => {
            format!("{:.n$}{unit} (95 % interval {:.n$} to {:.n$}{unit})", factor * number, factor * a, factor * b)
        }
        None => format!("{}{unit}", plain(factor * number)),
    };
    Some(format!("{} = {shown}", p.symbol))
}

/// Six significant digits without zeros at the end.
pub fn plain(x: f64) -> String {
    let shown: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if shown != 0.0 && (shown.abs() < 1e-4 || shown.abs() >= 1e6) { format!("{shown:e}") } else { format!("{shown}") }
}

/// Where constants come from: the source of the data, the test and the fitted stretches.
fn source(provenance: &Table) -> Option<String> {
    let text = |key: &str| provenance.get(key).and_then(Value::as_str).map(String::from);
    let from = text("source").or_else(|| text("data"))?;
    let modes = provenance.get("mode").and_then(Value::as_array);
    let modes: Vec<&str> = modes.into_iter().flatten().filter_map(Value::as_str).collect();
    let stretch = provenance.get("fitted_stretch").and_then(Value::as_array);
    let stretch: Vec<f64> = stretch.into_iter().flatten().filter_map(Value::as_float).collect();
    let fitted = match (modes.is_empty(), stretch.as_slice()) {
        (false, [a, b]) => {
            format!(", fitted to its {} data for stretches from {} to {}", modes.join(" and "), plain(*a), plain(*b))
        }
        (false, _) => format!(", fitted to its {} data", modes.join(" and ")),
        (true, _) => String::new(),
    };
    Some(format!("{}{fitted}", from.trim_end_matches('.')))
}
