//! Tables that every kind of study shows: all cases, and the times of their effects.

use crate::report::names::title;
use crate::report::numbers::{capital, digits, measured, percent_cell, readable};
use crate::report::table::{Table, headings};
use crate::study::curve::extreme_word;
use crate::study::store::record::{CaseRecord, StudyQuantity};
use crate::study::store::results::Results;

/// Memory for the values of the factor, with 8 bytes per entry \[10⁶ bytes\].
pub fn factor_mb(r: &CaseRecord) -> f64 {
    8e-6 * r.factor_nnz as f64
}

/// Formats a time of a curve \[s\]: in milliseconds, or finer for shorter times.
fn time_of(t: f64) -> String {
    format!("{t:.*}", if t == 0.0 { 3 } else { digits(0.1 * t).max(3) })
}

/// The quantities that any variant judges, without repetition.
fn quantities(store: &Results) -> Vec<&StudyQuantity> {
    let mut out: Vec<&StudyQuantity> = vec![];
    for q in store.study.variants.iter().filter_map(|v| store.study.quantities.get(v)).flatten() {
        if out.iter().all(|known| known.name != q.name) {
            out.push(q);
        }
    }
    out
}

/// The name of each quantity in headings: its label, followed by its name if another quantity has the same label.
fn headings_of(quantities: &[&StudyQuantity]) -> Vec<String> {
    let is_shared = |q: &StudyQuantity| quantities.iter().filter(|other| other.label == q.label).count() > 1;
    let of = |q: &&StudyQuantity| if is_shared(q) { format!("{} ({})", q.label, q.name) } else { q.label.clone() };
    quantities.iter().map(of).collect()
}

/// The time steps of the stages, without immediate repetitions.
fn steps(r: &CaseRecord) -> String {
    let mut steps = r.steps_s().to_vec();
    steps.dedup();
    steps.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// Table of all cases of a study: mesh, outcome, extremes, cost.
pub fn cases(store: &Results) -> Table {
    let judged = quantities(store);
    let rows = (store.cases.iter().map(|c| &c.record))
        .map(|r| {
            let peak = |q: &&StudyQuantity| match r.probes.get(&q.name) {
                Some(p) => [readable(p.peak, digits(1e-3 * p.peak)), time_of(p.peak_t_s)],
                None => ["–".into(), "–".into()],
            };
            let mesh = vec![
                r.id.clone(),
                title(&r.formulation),
                r.mesh.cells.to_string(),
                measured(1e3 * r.mesh.h_m),
                format!("{:.2}", r.mesh.min_quality),
                r.dofs.to_string(),
                r.factor_nnz.to_string(),
                measured(factor_mb(r)),
                r.solver.linear.multigrid.as_ref().map_or("direct".into(), |m| format!("{} levels", m.levels)),
                steps(r),
                if r.converged() { r.status.clone() } else { format!("{} !", r.status) },
                r.locking.map_or("–".into(), |l| {
                    format!("{:.2}{}", l.pressure_scatter, if l.alarm { " alarm" } else { "" })
                }),
            ];
            let cost = vec![
                r.steps.to_string(),
                r.all_iterations().to_string(),
                format!("{}{}", measured(r.wall_s), if r.shared { " (shared)" } else { "" }),
                measured(r.cpu_s),
            ];
            mesh.into_iter().chain(judged.iter().flat_map(peak)).chain(cost).collect()
        })
        .collect();
    let mut columns = headings(&[
        ("Case", "", false),
        ("Element", "", false),
        ("Cells", "", true),
        ("h", "mm", true),
        ("Min quality", "", true),
        ("DOFs", "", true),
        ("nnz(L)", "", true),
        ("Factor", "MB", true),
        ("Linear solver", "", false),
        ("Δt", "s", true),
        ("Status", "", false),
        ("Pressure scatter", "", true),
    ]);
    for (q, label) in judged.iter().zip(headings_of(&judged)) {
        let word = extreme_word(&store.cases, &q.name);
        columns.push((format!("{} {label}", capital(word)), q.unit.clone(), true));
        columns.push((format!("at, {label}"), "s".into(), true));
    }
    columns.extend(headings(&[("Steps", "", true), ("Newton", "", true), ("Wall", "s", true), ("CPU", "s", true)]));
    Table {
        name: "cases",
        caption: "Every case: mesh, outcome, extremes with their times, and cost.".into(),
        columns,
        rows,
        pick: None,
    }
}

/// Table of the cost of every effect and constraint in every case. An effect that is not declared has no row.
pub fn effects(store: &Results) -> Table {
    let mut rows = vec![];
    for r in store.cases.iter().map(|c| &c.record) {
        for e in &r.effects {
            rows.push(vec![
                r.id.clone(),
                e.name.clone(),
                measured(1e3 * e.wall_s),
                measured(1e3 * e.wall_s / r.steps.max(1) as f64),
                percent_cell(e.wall_s / r.wall_s),
            ]);
        }
    }
    Table {
        name: "effects",
        caption: "Wall time in the evaluations of every effect and constraint that is assembled.".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Effect", "", false),
            ("Time", "ms", true),
            ("Per step", "ms", true),
            ("Share of the case", "%", true),
        ]),
        rows,
        pick: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_with_the_same_label_are_told_apart() {
        let of = |name: &str, label: &str| StudyQuantity {
            name: name.into(),
            label: label.into(),
            ..StudyQuantity::default()
        };
        let all = [of("tip_z_m", "sag"), of("middle_z_m", "sag"), of("force_N", "force")];
        assert_eq!(headings_of(&all.each_ref()), ["sag (tip_z_m)", "sag (middle_z_m)", "force"]);
    }
}
