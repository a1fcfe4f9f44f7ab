//! Results as tables of comma-separated values; numbers in the shortest form that reads back the same.

use crate::report::table::quoted;
use crate::scene::{ErrorEstimate, RefinementStep, Run, Scene, Sensitivities};
use std::fmt::Write;

/// The prescribed signals on the time grid of the run.
pub fn signals(scene: &Scene, run: &Run) -> String {
    let mut text = header(std::iter::once("t_s".to_string()).chain(scene.signals.iter().map(|s| s.name.clone())));
    for (row, signals) in run.written.iter().map(|&k| (&run.rows[k], &run.signals[k])) {
        let values = std::iter::once(&row[0]).chain(signals).map(ToString::to_string);
        text += &values.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Derivatives of the columns by the keys (SI) over the times of the run, or at the times at which they were computed.
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

/// Estimated errors of recorded quantities, one line each.
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

/// The meshes of a refinement, one line each.
pub fn refinement(steps: &[RefinementStep]) -> String {
    let mut text = "cells,dofs,t_s,value,enriched,corrected,uncertainty,bar,tolerance,wall_s,cpu_s\n".to_string();
    for RefinementStep { cells, dofs, error: q, bar, tolerance, spent, .. } in steps {
        let numbers =
            [q.t, q.value, q.enriched, q.corrected, q.uncertainty, *bar, *tolerance, spent.wall_s, spent.cpu_s];
        text += &format!("{cells},{dofs},{}\n", numbers.map(|number| number.to_string()).join(","));
    }
    text
}

/// The recorded rows; numbers in the shortest form that reads back the same.
pub fn rows(run: &Run) -> String {
    let mut text = header(run.columns.iter().cloned());
    run.written.iter().for_each(|&k| text += &line(&run.rows[k]));
    text
}

/// A row as a line.
pub fn line(row: &[f64]) -> String {
    let mut text = String::new();
    for (k, value) in row.iter().enumerate() {
        write!(text, "{}{value}", if k > 0 { "," } else { "" }).expect("writing to a string cannot fail");
    }
    text + "\n"
}

/// The first line of a table: names are written as text, whatever they hold.
pub(super) fn header(names: impl Iterator<Item = String>) -> String {
    names.map(|name| quoted(&name)).collect::<Vec<_>>().join(",") + "\n"
}
