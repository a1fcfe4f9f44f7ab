//! How a validation found its constants and judged its predictions, in sentences for a paper.

use crate::report::numbers::digits;
use crate::report::paper::Paragraph;
use crate::study::kinds::validation::findings::{FoundConstant, ValidationFindings};
use crate::wording::count;

/// Returns one paragraph; none if nothing was determined or predicted.
pub fn search(a: &ValidationFindings) -> Vec<Paragraph> {
    if a.constants.is_empty() {
        return vec![];
    }
    let constants: Vec<String> = a.constants.iter().map(constant).collect();
    let records: std::collections::BTreeSet<&str> = a.fitted.iter().map(|d| d.record.as_str()).collect();
    let start = Paragraph::new("Calibration and prediction").marked(
        "Constants are those of generalised least squares of the calibration records, over response surfaces from simulations with exact \
         derivatives [@box1951]; a family of meshes or time steps corrects them to its limit. ",
    );
    let found = format!(
        "{} of {} give {}; χ² = {:.2} with {} of freedom. ",
        count(a.fitted.len(), "value"),
        count(records.len(), "record"),
        constants.join(", "),
        a.chi2,
        count(a.freedom, "degree")
    );
    let scored: Vec<bool> = a.predictions.iter().filter_map(|p| p.inside).collect();
    let score = match scored.is_empty() {
        true => format!("Predictions: {}.", count(a.predictions.len(), "value")),
        false => format!(
            "Of {} {} can be judged by {}; {} of these lie within their 95 % intervals.",
            count(a.predictions.len(), "predicted value"),
            scored.len(),
            a.reference.as_ref().map_or("measured values".into(), |reference| format!("values of {reference}")),
            scored.iter().filter(|inside| **inside).count()
        ),
    };
    vec![start.text(found + &score)]
}

fn constant(c: &FoundConstant) -> String {
    let n = digits(0.1 * (c.interval[1] - c.interval[0]));
    let unit = if c.unit.is_empty() { String::new() } else { format!("\u{a0}{}", c.unit) };
    let [low, high] = c.interval;
    format!("{} = {:.n$}{unit} (95 % interval {low:.n$} to {high:.n$}{unit})", c.symbol, c.value)
}
