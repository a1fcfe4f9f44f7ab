//! How the constants of a calibration were found, in sentences for a paper.

use crate::calibrate::inverse::FittedCurve;
use crate::report::numbers::percent;
use crate::report::paper::Paragraph;
use crate::study::kinds::calibration::findings::{CalibratedConstant, CalibratedVariant, CalibrationFindings};
use crate::study::kinds::calibration::words::scaled;
use crate::study::store::results::Results;
use crate::wording;

/// Returns one paragraph; none without a solution.
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
        format!("{} = {:.n$}{unit}{ends}", v.symbol_of(c), f * c.value)
    });
    let constants: Vec<String> = constants.collect();
    let curves = store.found.get(&v.case).map(|f| f.curves.as_slice()).unwrap_or_default();
    let from: Vec<String> = match curves {
        [one] => vec![format!("{} ({} points)", one.measured.file, one.measured.y.len())],
        several => {
            let named = |c: &FittedCurve| format!("{} ({}, {} points)", c.name, c.measured.file, c.measured.y.len());
            several.iter().map(named).collect()
        }
    };
    format!("From {}: {} on {} cells ({}). ", wording::all(&from), constants.join(", "), v.cells, v.errors)
}

/// States the parts of the intervals, and the share of each part in those of the constants.
pub fn errors(a: &CalibrationFindings) -> String {
    const DATA: &str = "the 95 % interval of the least squares, by the derivatives of the recorded curves at the solution and, where wider, by the \
                        profile of the likelihood [@bates1988]";
    let any = |has: fn(&CalibratedConstant) -> bool| a.variants.iter().flat_map(|v| &v.constants).any(has);
    let mesh = any(|c| c.mesh.is_some()).then_some("the uncertainty of the finest mesh, by the meshes of its family");
    let steps = any(|c| c.steps.is_some()).then_some("the error of the time steps, by runs with others");
    let dimensions = any(|c| c.nuisance.is_some()).then_some("the dimensions that are known by ranges");
    let parts: Vec<&str> = [Some(DATA), mesh, steps, dimensions].into_iter().flatten().collect();
    let ends = if parts.len() > 1 { ", all at their worst ends" } else { "" };
    let one_mesh = if mesh.is_none() { " The error of the mesh is not known, and in no interval." } else { "" };
    let no_steps = match a.variants.iter().any(|v| v.lacks_steps) {
        true => " The error of the time steps is not known, and in no interval.",
        false => "",
    };
    let without = match a.variants.iter().any(|v| !v.without_constants.is_empty()) {
        true => " Where cases of dimensions that are known by ranges have no result, no interval is stated.",
        false => "",
    };
    let shares: Vec<String> = a.variants.iter().flat_map(|v| shares(v, a.variants.len() > 1)).collect();
    let shares = if shares.is_empty() { String::new() } else { format!(" {}.", shares.join("; ")) };
    format!("The interval of a constant contains {}{ends}.{one_mesh}{no_steps}{without}{shares}", wording::all(&parts))
}

/// The contributions of data, mesh, time steps and dimensions to each constant that has an interval, in per cent of its value.
fn shares(v: &CalibratedVariant, named: bool) -> impl Iterator<Item = String> {
    let of = move |c: &CalibratedConstant| {
        let half = |share: Option<f64>, of: &str| share.map(|s| format!("±{} by {of}", percent(s.abs())));
        let size = c.value.abs();
        let ends = c.nuisance.map(|ends| ends.map(|end| percent((end - c.value).abs() / size)));
        let dimensions = ends.map(|[low, high]| format!("−{low} and +{high} by the dimensions"));
        let parts = [half(c.rows, "the data"), half(c.mesh, "the mesh"), half(c.steps, "the time steps"), dimensions];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let from = if named { format!(" from {}", v.label) } else { String::new() };
        c.interval.map(|_| format!("Of {}{from}: {}", v.symbol_of(c), wording::all(&parts)))
    };
    v.constants.iter().filter_map(of)
}
