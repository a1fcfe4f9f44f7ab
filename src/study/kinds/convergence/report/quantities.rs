//! Tables of a convergence study.

use crate::report::figure::family_label;
use crate::report::numbers::{cell, digits, percent_cell, space, within};
use crate::report::table::{Table, headings};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};

/// Returns a table with one row per quantity and family.
pub fn quantities(analysis: &Analysis<ConvergenceFindings>) -> Table {
    let mut rows = vec![];
    for q in &analysis.quantities {
        let tolerance = q.quantity.tolerance(analysis.tolerance);
        for e in &q.estimates {
            let optional = |v: Option<f64>, n: usize| v.map_or("–".into(), |v| format!("{v:.n$}"));
            rows.push(vec![
                q.peak_label(),
                q.variant.clone(),
                family_label(&e.family, &e.formulation),
                e.role.words().into(),
                e.class.words().into(),
                optional(e.convergence_ratio, 2),
                optional(e.observed_order, 2),
                optional(e.observed_order_coarser, 2),
                optional(e.gci_percent, 2),
                optional(e.order_of_limit(), 2),
                format!("{}{}", within(e.extrapolated, e.uncertainty), space(&q.quantity.unit)),
                cell(e.uncertainty / tolerance.scale(e.extrapolated), percent_cell),
                e.method.to_string(),
                cross_check(q, &e.family),
            ]);
        }
    }
    Table {
        name: "quantities",
        caption: "Peak of every quantity, per family of meshes: class and ratio R of the three finest, order of these three and of the three that are one mesh coarser, GCI of the finest mesh; order p that the limit f* is found with, and f* with its uncertainty; the share U(f*) is of |f*|, or of the absolute tolerance over the relative one where that is larger.".into(),
        columns: headings(&[
            ("Quantity", "", false), ("Control", "", false), ("Family", "", false), ("Role", "", false), ("Class", "", false),
            ("R", "", true), ("p finest", "", true), ("p coarser", "", true), ("GCI", "%", true), ("p", "", true), ("f*", "", true),
            ("U(f*)", "%", true),
            ("Method", "", false), ("Cross-check", "", false),
        ]),
        rows,
        pick: None,
    }
}

/// Words for a family as the reference, or as a cross-check of it.
fn cross_check(q: &ByQuantity<MeshErrors>, family: &str) -> String {
    let Some(r) = &q.reference else { return "–".into() };
    let words = match r.others.iter().find(|o| o.of == family) {
        Some(o) if o.overlaps => "overlaps",
        Some(_) => "does not overlap",
        None if r.envelope.is_empty() => "reference without support",
        None => "reference",
    };
    words.into()
}

/// Returns a table with one row per quantity and case that has its own estimate, next to the bar from many meshes.
pub fn one_run(analysis: &ConvergenceFindings) -> Option<Table> {
    let mut rows = vec![];
    for q in &analysis.quantities {
        for own in &q.one_run {
            let decimals = digits(own.uncertainty.max(1e-6 * own.value.abs()));
            let many = q.errors.iter().find(|e| e.id == own.id);
            let percent_cell = |v: f64| percent_cell(v);
            rows.push(vec![
                q.peak_label(),
                own.id.clone(),
                format!("{:.decimals$}{}", own.value, space(&q.quantity.unit)),
                format!("{:.decimals$}", own.corrected),
                format!("{:.decimals$}", own.uncertainty),
                percent_cell(own.bar),
                many.map_or("–".into(), |e| percent_cell(e.error)),
                many.map_or("–".into(), |e| percent_cell(e.bar)),
            ]);
        }
    }
    (!rows.is_empty()).then(|| Table {
        name: "one-run",
        caption: "Errors estimated from each run alone: corrected value with its uncertainty, and the bar of the computed one, next to error and bar against the reference of the families.".into(),
        columns: headings(&[
            ("Quantity", "", false), ("Case", "", false), ("Computed", "", true), ("Corrected", "", true), ("±", "", true),
            ("Bar, one run", "%", true), ("Error, families", "%", true), ("Bar, families", "%", true),
        ]),
        rows,
        pick: None,
    })
}

/// Returns a table with one row per mesh and formulation.
pub fn settings(analysis: &Analysis<ConvergenceFindings>) -> Table {
    let (mut meets, mut refused) = ("yes", "");
    if analysis.recommended.is_none() && analysis.settings.iter().any(|s| s.worst <= analysis.tolerance) {
        (meets, refused) = ("no verdict", " The verdict is refused, and none of these bars is shown to hold.");
    }
    let rows = (analysis.settings.iter())
        .map(|s| {
            vec![
                s.label.clone(),
                s.family.clone(),
                format!("{:.2}", 1e3 * s.h_m),
                format!("{:.*}", digits(s.cost_s), s.cost_s),
                cell(s.worst, percent_cell),
                s.limited_by.clone(),
                if s.worst <= analysis.tolerance { meets } else { "no" }.into(),
            ]
        })
        .collect();
    Table {
        name: "settings",
        caption: format!(
            "Mesh and formulation by cost (CPU seconds, mean over the variants), with the error bar of the worst deciding quantity.{refused}"
        ),
        columns: headings(&[
            ("Setting", "", false),
            ("Family", "", false),
            ("h", "mm", true),
            ("Cost", "s", true),
            ("Error bar", "%", true),
            ("Limited by", "", false),
            ("Meets the tolerance", "", false),
        ]),
        rows,
        pick: analysis.recommended.as_ref().map(|r| r.label.clone()),
    }
}

pub fn curves(analysis: &ConvergenceFindings) -> Table {
    let mut rows = vec![];
    for q in &analysis.quantities {
        for (family, c) in &q.curves {
            for n in &c.norms {
                let relative = |v: f64| if n.peak == 0.0 { "–".into() } else { percent_cell(v / n.peak.abs()) };
                rows.push(vec![
                    q.quantity.label.clone(),
                    family.clone(),
                    n.id.clone(),
                    relative(n.l2_to_finer),
                    relative(n.linf_to_finer),
                    n.l2_error.map_or("–".into(), percent_cell),
                    n.lag_s.map_or("–".into(), |lag| format!("{:.1}", (1e4 * lag).round() / 10.0 + 0.0)),
                    n.cycle_defect.map_or("–".into(), |v| format!("{:.1e}", v)),
                    c.observed_order.map_or("–".into(), |p| format!("{p:.2}")),
                ]);
            }
        }
    }
    Table {
        name: "curves",
        caption: "Curves: norms of the difference to the next finer mesh (of the peak), error against the Richardson curve, phase lag behind the finest, cycle-to-cycle defect (of the range), order p of the L2 norms of the family.".into(),
        columns: headings(&[
            ("Quantity", "", false), ("Family", "", false), ("Case", "", false), ("L2 to finer", "%", true), ("L∞ to finer", "%", true),
            ("L2 error", "%", true), ("Lag", "ms", true), ("Cycle defect", "", true), ("p", "", true),
        ]),
        rows,
        pick: None,
    }
}
