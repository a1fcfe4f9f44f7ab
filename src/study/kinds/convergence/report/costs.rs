//! Cost of a Newton iteration and of a digit, case by case.
//!
//! The number of digits is −log₁₀ e with e = max(|f − f*|, U(f*))/|f*| of the worst deciding quantity: no more than the reference can confirm. The
//! bytes are those of the values of L, 8 per entry; indices, K and work space are additional.

use crate::report::names::title;
use crate::report::numbers::{cell, digits, percent_cell};
use crate::report::table::{Table, headings};
use crate::study::kinds::convergence::findings::ConvergenceFindings;
use crate::study::store::record::{CaseRecord, Role, StoredCase};
use crate::study::store::results::Results;
use crate::study::tables::factor_mb;

/// Returns a table with one row per case that has an error.
pub fn table(store: &Results, analysis: &ConvergenceFindings) -> Table {
    let seeds = |c: &&StoredCase| store.study.family_of(c, None).is_some_and(|f| f.role == Role::Seeds);
    let mut rows = vec![];
    for r in store.cases.iter().filter(|c| !seeds(c)).map(|c| &c.record) {
        let Some((error, floor)) = worst(analysis, r) else { continue };
        let seconds = |s: f64| format!("{s:.*}", digits(s));
        let found = -error.max(floor).log10();
        rows.push(vec![
            r.id.clone(),
            title(&r.formulation),
            r.mesh.cells.to_string(),
            r.dofs.to_string(),
            r.factor_nnz.to_string(),
            format!("{:.1}", factor_mb(r)),
            r.all_iterations().to_string(),
            seconds(r.cpu_s),
            seconds(1e3 * r.cpu_s / r.all_iterations().max(1) as f64),
            cell(error, percent_cell),
            if found <= 0.0 { "none".into() } else { cell(found, |n| format!("{n:.2}")) },
            if found > 0.0 && found.is_finite() { seconds(r.cpu_s / found) } else { "–".into() },
        ]);
    }
    Table {
        name: "costs",
        caption: "Unknowns, entries of the factor and bytes of its values, iterations with those of refused steps, CPU time per iteration, and per digit of the worst deciding quantity. No more digits are counted than the reference has; a dash where neither has an error.".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Element", "", false),
            ("Cells", "", true),
            ("DOFs", "", true),
            ("nnz(L)", "", true),
            ("Factor", "MB", true),
            ("Newton", "", true),
            ("CPU", "s", true),
            ("CPU/Newton", "ms", true),
            ("Error", "%", true),
            ("Digits", "", true),
            ("CPU/digit", "s", true),
        ]),
        rows,
        pick: None,
    }
}

/// Largest error of a case among the deciding quantities \[–\], with U(f*)/|f*| there.
fn worst(analysis: &ConvergenceFindings, r: &CaseRecord) -> Option<(f64, f64)> {
    let of = analysis.quantities.iter().filter(|q| q.deciding).filter_map(|q| {
        let reference = q.reference.as_ref()?;
        let error = q.errors.iter().find(|e| e.id == r.id)?.error;
        Some((error, reference.uncertainty / reference.scale))
    });
    of.max_by(|a, b| a.0.max(a.1).total_cmp(&b.0.max(b.1)))
}
