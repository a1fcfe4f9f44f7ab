//! Warnings that a reader should know before relying on the numbers.

use crate::report::names::title;
use crate::report::numbers::{capital, minus_signs, percent, space};
use crate::study::analysis::{self, ByQuantity, warnings_of_costs, warnings_of_steps};
use crate::study::estimate::richardson::{LEAST_RATIO, ROUNDING, is_small_ratio};
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::errors::{StepCause, TimeStepError};
use crate::study::kinds::convergence::findings::MeshErrors;
use crate::study::kinds::convergence::members;
use crate::study::notes::notes;
use crate::study::run::one_run::OneRunRecord;
use crate::study::store::record::{Role, StoredCase};
use crate::wording::{all, count, distinct};
use std::collections::BTreeSet;

/// Returns one sentence per warning.
pub fn warnings(cases: &Cases, quantities: &[ByQuantity<MeshErrors>], incomplete: &[(String, String)]) -> Vec<String> {
    let mut out = analysis::warnings(incomplete);
    let mut seen = vec![];
    for e in quantities.iter().flat_map(|q| &q.estimates) {
        let low: Vec<String> = e.ratios.iter().filter(|r| is_small_ratio(**r)).map(|r| format!("{r:.2}")).collect();
        if !low.is_empty() && !seen.contains(&&e.family) {
            seen.push(&e.family);
            let (n, all) = (low.len(), e.ratios.len());
            out.push(format!(
                "Family {}: {n} of {} ({}) {} below the {LEAST_RATIO} that Roache recommends.",
                e.family,
                count(all, "size ratio"),
                low.join(", "),
                if n == 1 { "is" } else { "are" }
            ));
        }
    }
    out.extend(members::warnings(cases, quantities));
    out.extend(unknown_noise(cases, quantities));
    out.extend(warnings_of_costs(cases.stored));
    out.extend(idle_steps(quantities));
    out.extend(missed_peaks(quantities, cases.study.tolerance));
    let estimated = |variant: &str| {
        let has_result = |q: &&ByQuantity<MeshErrors>| !q.estimates.is_empty() || q.step.is_some();
        let mut own = quantities.iter().filter(|q| q.variant == variant).filter(has_result).peekable();
        own.peek().is_some() && own.all(|q| q.step.is_some())
    };
    out.extend(warnings_of_steps(cases.study, cases.stored, estimated));
    out.extend(inaccurate(cases, quantities));
    for q in quantities {
        out.extend(error_of_steps(q));
        out.extend(error_of_constants(q));
        for r in q.reference.iter().flat_map(|r| r.others.iter().filter(|o| !o.overlaps).map(move |o| (r, o))) {
            let (a, b) = (&r.0.family, &r.1.of);
            out.push(format!("{}: the intervals of families {a} and {b} do not overlap.", capital(&q.peak_title())));
        }
        if let Some(own) = q.reference.as_ref().and_then(|r| r.independent.as_ref()).filter(|own| !own.overlaps) {
            out.push(format!(
                "{}: the estimate from the run of {} alone, {} ± {:.1e}{}, does not overlap the reference; the uncertainty of the reference \
                 has grown to reach it.",
                capital(&q.peak_title()),
                own.of,
                minus_signs(&format!("{:.4e}", own.value)),
                own.uncertainty,
                space(&q.quantity.unit)
            ));
        }
        if let Some(c) = q.curves.iter().find(|(_, c)| c.interpolation_error > 0.01 * c.norms[0].peak.abs()) {
            out.push(format!(
                "{}: time grids differ; interpolating them costs {:.1e}.",
                capital(&q.peak_title()),
                c.1.interpolation_error
            ));
        }
    }
    if let Some(why) = cases.no_limit() {
        out.push(format!("{}: the answer has no limit as h → 0.", capital(why)));
    }
    out.extend(without_estimate(cases.stored));
    out.extend(notes(cases.stored).iter().map(|note| format!("{}.", capital(note))));
    out
}

/// The runs without an estimate of their errors, and the columns without one in runs that have estimates of other columns.
fn without_estimate(stored: &[StoredCase]) -> Vec<String> {
    let runs = || stored.iter().filter_map(|c| c.record.one_run.as_ref());
    let refusals: BTreeSet<&String> = runs().filter_map(|run| run.refused.as_ref()).collect();
    let columns: BTreeSet<&String> = runs().flat_map(|run| &run.unestimated).collect();
    let mut out: Vec<String> =
        refusals.into_iter().map(|why| format!("No error estimate from one run: {why}.")).collect();
    if !columns.is_empty() {
        let columns = all(&columns.into_iter().collect::<Vec<_>>());
        out.push(format!(
            "No error estimate from one run of {columns}: only quantities with a derivative by the state have one."
        ));
    }
    let lacking: BTreeSet<String> = runs().filter_map(OneRunRecord::lacking).collect();
    out.extend(lacking.iter().map(|bars| format!("{}: an error may be several times its bar.", capital(bars))));
    out
}

/// States that the bars lack the share of the constants if no derivative gives it.
fn error_of_constants(q: &ByQuantity<MeshErrors>) -> Option<String> {
    (!q.without_share.is_empty()).then(|| {
        format!(
            "{}: the share of constants ({}) that are known within intervals is not known, since no derivative by them is there; it is in no error bar.",
            capital(&q.peak_title()),
            q.without_share.join(", ")
        )
    })
}

/// States the error of the time steps if it is not negligible, and whether it is part of the error bars.
fn error_of_steps(q: &ByQuantity<MeshErrors>) -> Option<String> {
    let step = q.step.as_ref().filter(|s| !s.negligible)?;
    let place = match q.reference {
        Some(_) => "above a tenth of the uncertainty of the reference; it is in the error bars",
        None => "in no error bar, since no family of meshes gives a reference",
    };
    Some(format!(
        "{}: the {} {:.2e}{}, from family {}, is {place}.{}",
        capital(&q.peak_title()),
        step.cause.words(),
        step.error,
        space(&q.quantity.unit),
        step.family,
        if step.cause == StepCause::Algebraic {
            " Give numerics.accuracy a smaller value, or let a step meet the peak."
        } else {
            ""
        }
    ))
}

/// States once that a family of time steps measures no error. Values that are rounding of the largest value in their unit have no digits that could
/// differ.
fn idle_steps(quantities: &[ByQuantity<MeshErrors>]) -> Option<String> {
    let steps = quantities.iter().filter_map(|q| Some((q, q.step.as_ref()?)));
    let idle: Vec<(&ByQuantity<MeshErrors>, &TimeStepError)> =
        steps.filter(|(_, s)| s.cause == StepCause::Algebraic).collect();
    let size = |s: &TimeStepError| s.values.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let relative = |s: &TimeStepError| s.error / size(s);
    let is_rounding = |q: &ByQuantity<MeshErrors>, s: &TimeStepError| {
        let of_unit = idle.iter().filter(|(other, _)| other.quantity.unit == q.quantity.unit);
        of_unit.map(|(_, other)| size(other)).any(|other| size(s) < ROUNDING * other)
    };
    let counted = idle.iter().filter(|(q, s)| !is_rounding(q, s));
    let (q, most) = counted.max_by(|a, b| relative(a.1).total_cmp(&relative(b.1)))?;
    let differences = match relative(most) {
        0.0 => "Its cases do not differ in any digit.".into(),
        most => format!(
            "The differences between its cases are algebraic error of the solver, or peaks between the steps, at most {} of the value ({}).",
            percent(most),
            q.peak_title()
        ),
    };
    Some(format!(
        "Family {}: the states are static and independent of the path of loading, so values at one time do not depend on the time steps. {differences}",
        idle[0].1.family
    ))
}

/// States the share of peaks that the time grid of a variant may miss, once per variant, if it counts in the error bars.
fn missed_peaks(quantities: &[ByQuantity<MeshErrors>], tolerance: f64) -> Vec<String> {
    let counts = quantities.iter().filter(|q| q.missed_share > 0.1 * tolerance);
    let variants = distinct(counts.map(|q| (q.variant_label.clone(), percent(q.missed_share))));
    let warn = |(variant, share): (String, String)| {
        format!(
            "{}: a prescribed signal has its extremum between two points of the time grid, which may miss {share} of a peak; as much is in the error \
             bars. Let a point lie on the extremum, or shorten dt.",
            capital(&variant)
        )
    };
    variants.into_iter().map(warn).collect()
}

/// The formulations of references with an unknown scatter between meshes, with the variants if seeds of other variants do not show it. The best of
/// several families that are all not defensible is no reference.
fn unknown_noise(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Vec<String> {
    let is_seen = |q: &ByQuantity<MeshErrors>, formulation: &str| q.noise.iter().any(|n| n.formulation == formulation);
    let unknown = |q: &ByQuantity<MeshErrors>| {
        let e = q.estimate(q.reference.as_ref()?.envelope.first()?)?;
        let is_known = e.role == Role::Nested || is_seen(q, &e.formulation);
        (!is_known).then(|| (e.formulation.clone(), q.variant_label.clone()))
    };
    let unknown: Vec<(String, String)> = quantities.iter().filter_map(unknown).collect();
    let has_seeds = cases.study.families.iter().any(|f| f.role == Role::Seeds);
    let warn = |formulation: &String| {
        let variants = distinct(unknown.iter().filter(|u| u.0 == *formulation).map(|u| &u.1));
        let of = match quantities.iter().any(|q| is_seen(q, formulation)) {
            true => format!(" for it in {}", all(&variants)),
            false if has_seeds => " for it".into(),
            false => String::new(),
        };
        format!(
            "A reference is of {}, whose scatter from mesh to mesh is not in its uncertainty: no seeds were run{of}. Add a family of role \"seeds\" with three members or more.",
            title(formulation)
        )
    };
    distinct(unknown.iter().map(|u| &u.0)).into_iter().map(warn).collect()
}

/// Cases with a remaining Newton correction above a tenth of the acceptable error of a deciding quantity: its error bar, or the tolerance if the bar
/// is smaller.
fn inaccurate(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Option<String> {
    let tolerance = cases.study.tolerance;
    let least_bar = |id: &str| {
        let deciding = quantities.iter().filter(|q| q.deciding);
        let bars = deciding.flat_map(|q| &q.errors).filter(|e| e.id == id).map(|e| e.bar.max(tolerance));
        bars.fold(f64::INFINITY, f64::min)
    };
    let records = cases.stored.iter().map(|c| &c.record);
    let found: Vec<&str> =
        records.filter(|r| r.solver.algebraic_error > 0.1 * least_bar(&r.id)).map(|r| r.id.as_str()).collect();
    (!found.is_empty()).then(|| {
        format!(
            "The algebraic error of {} is above a tenth of the tolerance and of the error bar of a quantity that decides. Give numerics.accuracy a smaller value.",
            found.join(", ")
        )
    })
}
