//! Tables, once as data: written as CSV, as LaTeX with booktabs, and set into the page.

use super::error::{ReportError, write};
use super::page::escape;
use super::store::Store;
use crate::study::record::CaseRecord;
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

/// Megabytes (10⁶ bytes) of the values of the factor, 8 bytes an entry.
pub fn factor_mb(r: &CaseRecord) -> f64 {
    8e-6 * r.factor_nnz as f64
}

/// Every case of a study: mesh, outcome, peaks, cost.
pub fn cases(store: &Store) -> Table {
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
                format!("{:.1}", factor_mb(r)),
                r.solver.linear.multigrid.as_ref().map_or("direct".into(), |m| format!("{} levels", m.levels)),
                format!("{}", r.dt_s),
                if r.converged() { r.status.clone() } else { format!("{} !", r.status) },
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
            ("Linear solver", "", false),
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

/// What every effect and constraint of every case costs. What is not declared has no row.
pub fn effects(store: &Store) -> Table {
    let mut rows = vec![];
    for r in store.cases.iter().map(|c| &c.record) {
        for e in &r.effects {
            rows.push(vec![
                r.id.clone(),
                e.name.clone(),
                format!("{:.3}", 1e3 * e.wall_s),
                format!("{:.3}", 1e3 * e.wall_s / r.steps.max(1) as f64),
                format!("{:.1}", 100.0 * e.wall_s / r.wall_s),
            ]);
        }
    }
    Table {
        name: "effects",
        caption: "Wall time in the evaluations of every effect and constraint that is assembled.".into(),
        columns: vec![
            ("Case", "", false),
            ("Effect", "", false),
            ("Time", "ms", true),
            ("Per step", "ms", true),
            ("Share of the case", "%", true),
        ],
        rows,
        pick: None,
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
