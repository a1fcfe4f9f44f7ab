//! Results as comma-separated values; numbers have the shortest form that is read back unchanged.

use crate::report::table::quoted;
use crate::scene::{ErrorEstimate, RefinementStep, Run, Scene, Sensitivities};
use std::fmt::Write;

/// The prescribed signals on the time grid of the run, as CSV text.
pub fn signals(scene: &Scene, run: &Run) -> String {
    let mut text = header(std::iter::once("t_s".to_string()).chain(scene.signals.iter().map(|s| s.name.clone())));
    for (row, signals) in run.written.iter().map(|&k| (&run.rows[k], &run.signals[k])) {
        let values = std::iter::once(&row[0]).chain(signals).map(ToString::to_string);
        text += &values.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Derivatives of the columns with respect to the keys (SI) at the times of the run for which they were computed, as CSV text.
pub fn sensitivities(run: &Run, found: &Sensitivities) -> String {
    let by_keys = |column: &String| {
        let of = |key| format!("d {column}/d {key}");
        found.keys.iter().map(of).collect::<Vec<_>>()
    };
    let names = found.columns.iter().flat_map(by_keys);
    let mut text = header(std::iter::once("t_s".to_string()).chain(names));
    let computed = |(_, derivatives): &(_, &Vec<Vec<f64>>)| derivatives.iter().flatten().any(|value| !value.is_nan());
    for (row, derivatives) in run.rows.iter().zip(&found.rows).filter(computed) {
        let values = derivatives.iter().flatten().map(ToString::to_string);
        text += &std::iter::once(row[0].to_string()).chain(values).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Estimated errors of recorded quantities as CSV text, one line each.
pub fn errors(estimate: &ErrorEstimate) -> String {
    let mut text =
        "quantity,t_s,value,enriched,geometry,corrected,uncertainty,bar,extent,unresolved,contacts\n".to_string();
    for q in &estimate.quantities {
        let geometry = q.geometry.map_or_else(String::new, |g| g.change.to_string());
        let extent = if q.cut_regions.is_empty() { q.extent.to_string() } else { String::new() };
        let (t, value, enriched, corrected) = (q.t, q.value, q.enriched, q.corrected);
        let (column, unresolved) = (quoted(&q.column), u8::from(q.unresolved));
        let contacts = quoted(&q.contacts.join(", "));
        text += &format!(
            "{column},{t},{value},{enriched},{geometry},{corrected},{},{},{extent},{unresolved},{contacts}\n",
            q.uncertainty, q.bar
        );
    }
    text
}

/// The meshes of a refinement as CSV text, one line each.
pub fn refinement(steps: &[RefinementStep]) -> String {
    let mut text = "cells,dofs,t_s,value,enriched,corrected,uncertainty,bar,tolerance,wall_s,cpu_s\n".to_string();
    for RefinementStep { cells, dofs, error: q, bar, tolerance, spent, .. } in steps {
        let numbers =
            [q.t, q.value, q.enriched, q.corrected, q.uncertainty, *bar, *tolerance, spent.wall_s, spent.cpu_s];
        text += &format!("{cells},{dofs},{}\n", numbers.map(|number| number.to_string()).join(","));
    }
    text
}

/// The recorded rows as CSV text; numbers have the shortest form that is read back unchanged.
pub fn rows(run: &Run) -> String {
    let mut text = header(run.columns.iter().cloned());
    run.written.iter().for_each(|&k| text += &line(&run.rows[k]));
    text
}

/// One row as a line of CSV text.
pub fn line(row: &[f64]) -> String {
    let mut text = String::new();
    for (k, value) in row.iter().enumerate() {
        write!(text, "{}{value}", if k > 0 { "," } else { "" }).expect("writing to a string cannot fail");
    }
    text + "\n"
}

/// The first line of a table: names are written as quoted text, whatever they contain.
pub(super) fn header(names: impl Iterator<Item = String>) -> String {
    names.map(|name| quoted(&name)).collect::<Vec<_>>().join(",") + "\n"
}
