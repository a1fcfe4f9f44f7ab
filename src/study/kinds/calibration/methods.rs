//! How the constants of a calibration were found, in sentences for a paper.

use crate::report::paper::Paragraph;
use crate::study::kinds::calibration::analysis::{CalibratedVariant, CalibrationFindings, scaled};
use crate::study::store::results::Results;

/// One paragraph; none without an answer.
pub fn search(store: &Results, a: &CalibrationFindings) -> Vec<Paragraph> {
    if a.variants.is_empty() {
        return vec![];
    }
    let start = Paragraph::new("Inverse analysis").marked(
        "Constants are those with which the simulated specimen reproduces measured curves with the least squares of the residuals, by a \
         trust-region search with exact derivatives of the recorded curves [@more1978]. ",
    );
    vec![a.variants.iter().fold(start, |p, v| p.text(answer(store, v)))]
}

fn answer(store: &Results, v: &CalibratedVariant) -> String {
    let constants = v.constants.iter().map(|c| {
        let (f, unit, n) = scaled(c);
        let unit = if unit.is_empty() { String::new() } else { format!("\u{a0}{unit}") };
        let ends = c.interval.map_or_else(
            || " (no interval is stated)".into(),
            |[a, b]| format!(" (95 % interval {:.n$} to {:.n$}{unit})", f * a, f * b),
        );
        format!("{} = {:.n$}{unit}{ends}", c.symbol, f * c.value)
    });
    let constants: Vec<String> = constants.collect();
    let curves = store.found.get(&v.case).map(|f| f.curves.as_slice()).unwrap_or_default();
    let files: Vec<String> =
        curves.iter().map(|c| format!("{} ({} points)", c.measured.file, c.measured.y.len())).collect();
    format!("From {}: {} on {} cells ({}). ", files.join(" and "), constants.join(", "), v.cells, v.errors)
}
