//! Tables, once as data: written as CSV, as LaTeX with booktabs, and set into the page.

mod costs;

use super::error::{ReportError, write};
use super::page::escape;
use super::store::Store;
use super::summary::role;
use crate::study::convergence::verdict::digits;
use crate::study::convergence::{Analysis, CONVERGED};
use std::path::Path;

/// Columns with a heading and a unit; cells are text, ready to print.
pub struct Table {
    pub name: &'static str,
    pub caption: String,
    /// (heading, unit, numbers?)
    pub columns: Vec<(&'static str, &'static str, bool)>,
    pub rows: Vec<Vec<String>>,
    /// First cell of the row that is the answer
    pub pick: Option<String>,
}

/// On the page a negative number has a minus sign, not a hyphen.
fn minus(cell: &str) -> String {
    match cell.strip_prefix('-') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => format!("−{rest}"),
        _ => cell.into(),
    }
}

pub fn all(store: &Store, analysis: &Analysis) -> Vec<Table> {
    vec![quantities(analysis), settings(analysis), cases(store), costs::table(store, analysis), curves(analysis)]
}

/// One row per quantity × family.
fn quantities(analysis: &Analysis) -> Table {
    let mut rows = vec![];
    for q in &analysis.quantities {
        for e in &q.estimates {
            let chosen = q.reference.as_ref().is_some_and(|r| r.family == e.family);
            let decimals = digits(e.uncertainty.max(1e-4 * e.extrapolated.abs()));
            let optional = |v: Option<f64>, n: usize| v.map_or("–".into(), |v| format!("{v:.n$}"));
            rows.push(vec![
                q.quantity.label.clone(),
                q.variant.clone(),
                format!("{} ({})", e.family, e.formulation),
                role(e.role).into(),
                e.class.words().into(),
                optional(e.convergence_ratio, 2),
                optional(e.observed_order, 2),
                optional(e.observed_order_coarser, 2),
                optional(e.gci_percent, 2),
                format!(
                    "{:.decimals$}{}",
                    e.extrapolated,
                    super::super::study::convergence::verdict::space(&q.quantity.unit)
                ),
                format!("{:.2}", 100.0 * e.uncertainty / e.extrapolated.abs()),
                e.method.clone(),
                if chosen { "reference".into() } else { overlap(q, &e.family) },
            ]);
        }
    }
    Table {
        name: "quantities",
        caption: "Peak of every quantity, per family of meshes: class and ratio R of the three finest, observed order, GCI of the finest mesh, extrapolated value with its uncertainty.".into(),
        columns: vec![
            ("Quantity", "", false), ("Control", "", false), ("Family", "", false), ("Role", "", false), ("Class", "", false),
            ("R", "", true), ("p", "", true), ("p coarser", "", true), ("GCI", "%", true), ("f*", "", true), ("U(f*)", "%", true),
            ("Method", "", false), ("Cross-check", "", false),
        ],
        rows,
        pick: None,
    }
}

fn overlap(q: &crate::study::convergence::QuantityAnalysis, family: &str) -> String {
    let found = q.reference.iter().flat_map(|r| &r.others).find(|o| o.family == family);
    found.map_or("–", |o| if o.overlaps { "overlaps" } else { "does not overlap" }).into()
}

/// One row per mesh and formulation.
fn settings(analysis: &Analysis) -> Table {
    let rows = (analysis.settings.iter())
        .map(|s| {
            vec![
                s.label.clone(),
                s.family.clone(),
                format!("{:.2}", 1e3 * s.h_m),
                format!("{:.*}", digits(s.cost_s), s.cost_s),
                if s.worst.is_finite() { format!("{:.2}", 100.0 * s.worst) } else { "–".into() },
                if s.worst.is_finite() { s.limited_by.clone() } else { "not run in every variant".into() },
                if s.worst <= analysis.tolerance { "yes" } else { "no" }.into(),
            ]
        })
        .collect();
    Table {
        name: "settings",
        caption: format!(
            "Mesh and formulation by price ({}, mean over the variants), with the error bar of the worst deciding quantity.",
            if analysis.cost == "cpu_s" { "CPU seconds" } else { "wall seconds" }
        ),
        columns: vec![
            ("Setting", "", false),
            ("Family", "", false),
            ("h", "mm", true),
            ("Price", "s", true),
            ("Error bar", "%", true),
            ("Limited by", "", false),
            ("Meets the tolerance", "", false),
        ],
        rows,
        pick: analysis.recommended.as_ref().map(|r| r.label.clone()),
    }
}

fn cases(store: &Store) -> Table {
    let rows = (store.cases.iter().map(|c| &c.record))
        .map(|r| {
            let probe = |name: &str, n: usize| r.probes.get(name).map_or("–".into(), |p| format!("{:.n$}", p.peak));
            vec![
                r.id.clone(),
                r.formulation.clone(),
                r.mesh.cells.to_string(),
                format!("{:.3}", 1e3 * r.mesh.h_m),
                format!("{:.2}", r.mesh.min_quality),
                r.dofs.to_string(),
                r.factor_nnz.to_string(),
                format!("{:.1}", costs::factor_mb(r)),
                format!("{}", r.dt_s),
                if r.status == CONVERGED { r.status.clone() } else { format!("{} !", r.status) },
                r.locking.map_or("–".into(), |l| {
                    format!("{:.2}{}", l.pressure_scatter, if l.alarm { " alarm" } else { "" })
                }),
                probe("bending_angle_deg", 3),
                probe("cable_tension_N", 4),
                r.steps.to_string(),
                r.newton_iterations.to_string(),
                format!("{:.2}{}", r.wall_s, if r.shared { " (shared)" } else { "" }),
                format!("{:.2}", r.cpu_s),
            ]
        })
        .collect();
    Table {
        name: "cases",
        caption: "Every case: mesh, outcome, peaks and cost.".into(),
        columns: vec![
            ("Case", "", false),
            ("Element", "", false),
            ("Cells", "", true),
            ("h", "mm", true),
            ("Min quality", "", true),
            ("DOFs", "", true),
            ("nnz(L)", "", true),
            ("Factor", "MB", true),
            ("Δt", "s", true),
            ("Status", "", false),
            ("Pressure scatter", "", true),
            ("Peak angle", "°", true),
            ("Peak tension", "N", true),
            ("Steps", "", true),
            ("Newton", "", true),
            ("Wall", "s", true),
            ("CPU", "s", true),
        ],
        rows,
        pick: None,
    }
}

fn curves(analysis: &Analysis) -> Table {
    let mut rows = vec![];
    for q in &analysis.quantities {
        for (family, c) in &q.curves {
            for n in &c.norms {
                let relative =
                    |v: f64| if n.peak == 0.0 { "–".into() } else { format!("{:.2}", 100.0 * v / n.peak.abs()) };
                rows.push(vec![
                    q.quantity.label.clone(),
                    family.clone(),
                    n.id.clone(),
                    relative(n.l2_to_finer),
                    relative(n.linf_to_finer),
                    n.l2_error.map_or("–".into(), |v| format!("{:.2}", 100.0 * v)),
                    format!("{:.1}", (1e4 * n.lag_s).round() / 10.0 + 0.0),
                    n.cycle_defect.map_or("–".into(), |v| format!("{:.1e}", v)),
                    c.observed_order.map_or("–".into(), |p| format!("{p:.2}")),
                ]);
            }
        }
    }
    Table {
        name: "curves",
        caption: "Curves: norms of the difference to the next finer mesh (of the peak), error against the Richardson curve, phase lag behind the finest, cycle-to-cycle defect (of the range), order of the family.".into(),
        columns: vec![
            ("Quantity", "", false), ("Family", "", false), ("Case", "", false), ("L2 to finer", "%", true), ("L∞ to finer", "%", true),
            ("L2 error", "%", true), ("Lag", "ms", true), ("Cycle defect", "", true), ("p", "", true),
        ],
        rows,
        pick: None,
    }
}

impl Table {
    fn heading(&self, k: usize) -> String {
        let (name, unit, _) = self.columns[k];
        if unit.is_empty() { name.into() } else { format!("{name} [{unit}]") }
    }

    pub fn html(&self) -> String {
        let class = |k: usize| if self.columns[k].2 { " class=\"n\"" } else { "" };
        // Many columns may be wider than the text
        let wide = if self.columns.len() > 8 { " wide" } else { "" };
        let caption = escape(&self.caption);
        let mut h = format!("<p class=\"caption\">{caption}</p>\n<div class=\"scroll{wide}\"><table>\n<tr>");
        for k in 0..self.columns.len() {
            h += &format!("<th{}>{}</th>", class(k), escape(&self.heading(k)));
        }
        for row in &self.rows {
            let pick = if self.pick.as_ref().is_some_and(|p| row.first() == Some(p)) { " class=\"pick\"" } else { "" };
            h += &format!("</tr>\n<tr{pick}>");
            for (k, cell) in row.iter().enumerate() {
                h += &format!("<td{}>{}</td>", class(k), escape(&minus(cell)));
            }
        }
        h + "</tr>\n</table></div>\n"
    }

    pub fn csv(&self) -> String {
        let quote = |s: String| if s.contains([',', '"']) { format!("\"{}\"", s.replace('"', "\"\"")) } else { s };
        let line = |cells: Vec<String>| cells.into_iter().map(quote).collect::<Vec<_>>().join(",") + "\n";
        let mut out = line((0..self.columns.len()).map(|k| self.heading(k)).collect());
        for row in &self.rows {
            out += &line(row.clone());
        }
        out
    }

    /// A `tabular` between booktabs rules, to be put into a table environment.
    pub fn latex(&self) -> String {
        let spec: String = self.columns.iter().map(|c| if c.2 { 'r' } else { 'l' }).collect();
        let line =
            |cells: Vec<String>| format!("  {} \\\\\n", cells.iter().map(|c| tex(c)).collect::<Vec<_>>().join(" & "));
        let mut out = format!("% {}\n\\begin{{tabular}}{{{spec}}}\n  \\toprule\n", self.caption);
        out += &line((0..self.columns.len()).map(|k| self.heading(k)).collect());
        out += "  \\midrule\n";
        for row in &self.rows {
            out += &line(row.clone());
        }
        out + "  \\bottomrule\n\\end{tabular}\n"
    }

    pub fn save(&self, dir: &Path) -> Result<(), ReportError> {
        write(&dir.join(format!("{}.csv", self.name)), self.csv().as_bytes())?;
        write(&dir.join(format!("{}.tex", self.name)), self.latex().as_bytes())
    }
}

/// Characters that LaTeX would take for commands, and the ones outside of its usual fonts.
fn tex(s: &str) -> String {
    let mut out = String::new();
    for c in s.chars() {
        match c {
            '%' | '&' | '#' | '_' | '$' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '\\' => out += "\\textbackslash{}",
            '^' => out += "\\textasciicircum{}",
            '°' => out += "$^\\circ$",
            '±' => out += "$\\pm$",
            '²' => out += "$^2$",
            '⁴' => out += "$^4$",
            'α' => out += "$\\alpha$",
            'β' => out += "$\\beta$",
            'θ' => out += "$\\theta$",
            'Δ' => out += "$\\Delta$",
            '∞' => out += "$\\infty$",
            '·' => out += "$\\cdot$",
            '½' => out += "$\\frac12$",
            '–' => out += "--",
            '−' => out += "$-$",
            c => out.push(c),
        }
    }
    out
}
